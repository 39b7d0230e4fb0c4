"""Decides with 34 digits which of two different results is right.

It uses the Taylor series of the tests. It also computes how much each number changes if each
parameter changes by one rounding error: no program in double precision can be more exact than that.
"""

import sys
from pathlib import Path

from mpmath import mp, mpf

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "reference"))

import taylor
from series import inverse_root, reach, sign_changes, value

SETTING = {"digits": 34, "order": 26, "tolerance": "1e-23"}
ROUNDING = 2.0**-52
_STEPS = 4000


class Answer:
    """Handoff times and squared speeds; if the motion stops, angle and time of the stop."""

    def __init__(self, times, squares, reversals, stall):
        self.times, self.squares, self.reversals, self.stall = times, squares, reversals, stall

    def numbers(self):
        """All numbers in one list: times, speeds, angle and time of a stall."""
        speeds = [mp.sqrt(w) for w in self.squares]
        return [*self.times, *speeds, *(self.stall or ())]


class _Stop(Exception):
    """The driver has come to rest: angle and time since entry."""


def answer(slots, pins, internal, rho, mu, load, speed, engagements):
    """Motion in natural units, to 20 digits."""
    with mp.workdps(SETTING["digits"]):
        case = _case(slots, pins, internal, rho, mu, load)
        w, time = mpf(speed) ** 2, mpf(0)
        times, squares, reversals = [], [], []
        for _ in range(engagements):
            try:
                w, spent, turned = _engage(case, w)
            except _Stop as stop:
                angle, spent = stop.args
                return Answer(times, squares, reversals, (angle, time + spent))
            reversals.append(turned)
            time += spent
            times.append(time)
            squares.append(w)
        return Answer(times, squares, reversals, None)


def cycle(slots, pins, internal, rho, mu, load, speed):
    """Terminal cycle near a given handoff speed: greatest, least, handoff speed and period."""
    with mp.workdps(SETTING["digits"]):
        case = _case(slots, pins, internal, rho, mu, load)
        found = taylor.terminal(case, SETTING, mpf(speed) ** 2, 1, 1)
    names = ("velocity_max", "velocity_min", "handoff_velocity", "period")
    return tuple(float(found[name]) for name in names)


def unavoidable(slots, pins, internal, rho, mu, load, speed, engagements, exact):
    """Relative change of every number by one rounding in each parameter, summed."""
    total = [mpf(0)] * len(exact.numbers())
    for name in ("rho", "mu", "load", "speed"):
        inputs = {"rho": mpf(rho), "mu": mpf(mu), "load": mpf(load), "speed": mpf(speed)}
        if inputs[name] == 0:
            continue
        inputs[name] *= 1 + mpf(ROUNDING)
        moved = answer(slots, pins, internal, **inputs, engagements=engagements).numbers()
        if len(moved) != len(total):
            return None  # whether the motion stops at all depends on the last bit
        for i, (x, y) in enumerate(zip(moved, exact.numbers(), strict=True)):
            total[i] += abs(x / y - 1)
    return [float(x) for x in total]


def _case(slots, pins, internal, rho, mu, load):
    kind, step = -1 if internal else 1, mp.pi / slots
    beta, cell = mp.pi / 2 - kind * step, 2 * mp.pi / pins
    return taylor.Case(1 / mp.sin(step), beta, cell, kind, mpf(rho), mpf(mu), mpf(load))


def _engage(case, w):
    """One engagement, dwell included; raises _Stop where the driver stops."""
    time, turned, steps = mpf(0), 0, 0
    for start, end in ((-case.beta, mpf(0)), (mpf(0), case.beta)):
        angle, sign = start, taylor.initial_sign(case, start, w)
        while angle < end:
            steps += 1
            if steps > _STEPS:
                raise ArithmeticError("no end in sight")
            here = taylor.panel(case, angle, sign, w, SETTING, end)
            if w == 0 and here.w[1] <= 0:
                raise _Stop(angle, time)
            smooth = min(_smooth_reach(here), end - angle)
            falls = [
                x
                for x in sign_changes(here.contact, smooth)
                if sign * value([k * c for k, c in enumerate(here.contact)][1:], x) < 0
            ]
            within = min([smooth, *falls])
            stops = sign_changes(here.w, within) if w > 0 else sign_changes(here.w[1:], within)
            if stops:
                ended = _stop(case, angle, sign, w, here, stops[0], end)
                if ended is not None:
                    raise _Stop(angle + stops[0], time + ended)
            h = min([here.reach, smooth, *falls])
            reverses = bool(falls) and h == min(falls)
            time += taylor.elapsed(here, h)
            w = value(here.w, h)
            if w <= 0:
                raise ArithmeticError("passed a stop")
            turned += reverses
            sign = -sign if reverses else sign
            angle = end if h == end - angle else angle + h
    dwell = case.cell - 2 * case.beta
    if dwell > taylor.ROUNDING:
        leaving = w + 2 * dwell / case.rho
        time += 2 * dwell / (mp.sqrt(w) + mp.sqrt(leaving))
        w = leaving
    return w, time, turned


def _smooth_reach(here):
    """Distance to which the series of W is valid; at a stop only that of the time ends."""
    tolerance = mpf(SETTING["tolerance"])
    grown = here.w[1:] if here.from_rest else here.w
    return min(reach(x, tolerance) for x in (grown, here.tangent, here.contact))


def _stop(case, angle, sign, w, here, length, end):
    """Time from `angle` to the stop `length` ahead, or None where its series is too short."""
    back = taylor.panel(case, angle + length, sign, mpf(0), SETTING, end)
    grown = [-c for c in back.w[1:]]
    if not grown[0] > 0:
        return None
    slow = inverse_root(grown)
    tolerance = mpf(SETTING["tolerance"])
    if length > min(reach(slow, tolerance), _smooth_reach(back)):
        return None
    total = value([c * (-1) ** k / (k + mpf(1) / 2) for k, c in enumerate(slow)], length)
    return mp.sqrt(length) * total
