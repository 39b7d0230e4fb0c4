"""Imperfect parts of a wheel with slots: every pair of pin and slot has its own path.

Section 10 of docs/theory.md derives what this file computes. With m pins and n slots the same pairs
meet again after lcm(m, n) engagements; this sequence of engagements is the pattern. Pin j is late
by the angle psi_j. Slot i stands ahead by the angle chi_i, and the slot's centre line passes the
follower's axis at the distance delta_i. With the driver angle x = theta - psi_j, counted from where
pin j crosses the line of centres, the path is that of `slotted` with two vectors P and Q, and Phi
is the follower angle:

    C = P exp(i a x) + Q exp(i b x)
    Phi = arg C - asin(delta_i/|C|) - chi_i

At entry and exit of the pin g = 0. In a Geneva wheel P is the distance of the axes and Q the crank
of pin j; in a gear-driven wheel P is the carrier and Q the planet's arm. A pin A leaves its slot at
theta_A, and the next pin B enters its own slot at theta_B. Gamma = Phi_B - Phi_A is the difference
of the follower angles to which they lead. Pin A hands over to pin B in one of three ways:

    overlap   theta_B <= theta_A, and Gamma >= 0 where g_A = g_B: B takes over there. The follower
              jumps ahead by Gamma, so the slot must be wider than the pin by R Gamma.
    pick-up   theta_B > theta_A, and Gamma >= 0 with Phi_B at theta_B and Phi_A at theta_A: the
              follower rests while the driver turns alone, and B moves it again from theta_B on,
              without an impact.
    strike    otherwise: the follower rests where A has left it, and B strikes it where Phi_B has
              grown to the angle of the follower.

None of this depends on the speed. A pattern is therefore a list of engagements, each with fixed
ends. A pattern is refused if a pin would slide back along the wall during its impact, because
friction would then change its direction.
"""

import math
from enum import IntEnum
from functools import partial

import numpy as np

from escapement.mechanisms.path import OFFSET, PIN_RATE, Pair, Path, PinNumbers
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.slotted import path_numbers, pose_at, slide_edges
from escapement.numerics.jit import as_python, inner_jit, jit
from escapement.numerics.records import record_dtype
from escapement.numerics.roots import newton_in_bracket


class Handoff(IntEnum):
    """How a pin takes over from the one before it."""

    OVERLAP = 0
    PICK_UP = 1
    STRIKE = 2

    @property
    def label(self) -> str:
        """Its name in files and tables."""
        return self.name.lower().replace("_", "-")


PAIR = record_dtype({
    "pin_numbers": (float, (len(PinNumbers._fields),)),  # of the path
    "edges": (float, (4,)),  # edges as in `Scene`, of which the first `used` are filled
    "used": np.int64,
    "dwell": float,  # driver angle from the exit to the start of the next engagement
    "delay": float,  # psi
    "lead": float,  # chi
    # C = exp(i drift x) [long + short exp(i turn x)], counted in the sense `forward`
    **dict.fromkeys(("long", "short", "drift", "turn", "forward"), float),
    "entry": float,  # driver angles x at which g = 0
    "exit": float,
    # how it begins: a `Handoff`, with Gamma and R there
    "kind": np.int64,
    "jump": float,
    "radius": float,
})  # fmt: skip
"""One engagement of a pattern. Angles in rad from where the pin crosses the line of centres,
lengths in crank radii."""

CLOSE = 1e-13
"""Angles that differ by less count as equal [rad], so that perfect parts overlap despite rounding.
"""
POSSIBLE = -1
"""What `lay_pattern` returns for a pattern without an impossible engagement."""


@jit(allocates=True)
def lay_pattern(arms, turns, longer, pin, pins, slots, pattern):
    """Fill `pattern`; returns the first engagement that is impossible, -1 if all are possible.

    Parameters
    ----------
    arms : P, a, Q, b of perfect parts, and the sense in which the follower turns.
    turns : angles of driver and follower from one pin to the next.
    longer : error of |P|.
    pin : radius of pins or rollers.
    pins, slots : psi and the error of |Q| of each pin, chi and delta of each slot; shapes (m, 2)
        and (n, 2).
    pattern : array of `PAIR`, as long as the least common multiple of m and n.
    """
    # first the path of each pair, with entry and exit as if no other pin were there
    first, a, second, b, forward = arms
    size, m, n = pattern.size, len(pins), len(slots)
    for k in range(size):
        pair, offset = pattern[k], slots[k % n, 1]
        pair.delay, pair.lead = pins[k % m, 0], slots[k % n, 0]
        p, q = _lengthened(first, longer), _lengthened(second, pins[k % m, 1])
        # The least |C| must exceed |delta|. It counts as negative if the errors have made the
        # shorter vector the longer one, so that the pin would pass the axis on its other side.
        nearest = (abs(p) - abs(q)) * np.sign(abs(first) - abs(second))
        # the cosine of (a - b) x where g = 0 in a slot without an offset
        cosine = -(a * p * p + b * q * q) / (p * q * (a + b))
        if not (
            p * first > 0.0 and q * second > 0.0 and abs(offset) < nearest and abs(cosine) < 1.0
        ):
            return k
        # without an offset g = 0 at -half and half; with one g = 0 is sought as far as `widest`,
        # where (a - b) x is half a turn
        half, widest = np.arccos(cosine) / abs(a - b), np.pi / abs(a - b)
        row = path_numbers(p, a, q, b, forward, half, offset)
        for i in range(len(row)):
            pair.pin_numbers[i] = row[i]
        _write_angle(pair, p, a, q, b, forward)
        pair.entry, pair.exit = -half, half
        if offset != 0.0:
            path = path_in(pair)
            pair.entry = _stop(path, -half, -widest, 0.0)
            pair.exit = _stop(path, half, 0.0, widest)
    # then the handoffs, which set where the engagements end and begin
    for k in range(size):
        following = (k + 1) % size
        if not _hand_over(pattern[k], pattern[following], *turns):
            return following
    # last the angles of each engagement at which the sliding changes its direction
    for k in range(size):
        pair = pattern[k]
        # an engagement must begin before its dead centre and end behind it
        if not pair.edges[0] < 0.0 < pair.edges[1] or _slides_back(pair, pin):
            return k
        ends, path = pair.edges[:2].copy(), path_in(pair)
        edges = slide_edges(path, pin, ends)
        pair.used = len(edges)
        for i in range(len(edges)):
            pair.edges[i] = edges[i]
    return POSSIBLE


@inner_jit
def _lengthened(arm, error):
    """A signed length whose magnitude is greater by an error."""
    return arm + error * np.sign(arm)


@inner_jit
def _write_angle(pair, p, a, q, b, forward):
    """Write the numbers of the two vectors from which `follower_angle_at` computes arg C."""
    # C never turns by a quarter of a turn or more from the longer vector, which is to come first
    if abs(p) < abs(q):
        p, a, q, b = q, b, p, a
    pair.long, pair.short = abs(p), np.copysign(q, p * q)
    pair.drift, pair.turn, pair.forward = a, b - a, forward


@inner_jit(allocates=True, inlined=True)
def path_in(pair):
    """The path of an engagement."""
    # to the compiler an array in a record has a type of its own; a slice of it is a plain array
    return Path(False, pair.pin_numbers[:])


@inner_jit
def _stop(path, x, low, high):
    """Driver angle at which g = 0, between `low` and `high` and near x: an entry or an exit."""
    for _ in range(100):
        g, _u, dg, _radius = pose_at(path, x)
        guess, low, high = newton_in_bracket(x, g, dg, low, high, x < 0.0)
        step = abs(guess - x)
        x = guess
        if step <= 1e-15:
            break
    return x


@inner_jit
def follower_angle_at(pair, x):
    """Phi at the driver angle x, 0 at dead centre of perfect parts."""
    along = pair.long + pair.short * np.cos(pair.turn * x)
    across = pair.short * np.sin(pair.turn * x)
    offset = pair.pin_numbers[OFFSET]
    angle = pair.forward * (pair.drift * x + np.arctan2(across, along)) - pair.lead
    return angle - np.arcsin(offset / np.hypot(along, across)) if offset != 0.0 else angle


@inner_jit(allocates=True)
def _hand_over(a, b, cell, step):
    """Find the handoff from pair A to pair B, and set the end of A and the start of B.

    `cell` and `step` are the angles of driver and follower from one pin to the next. The result is
    False if B does not drive at all: if it never reaches the follower before its exit, or if the
    follower is more than a quarter of `step` away from where B needs it, so that B misses its slot.
    """
    # all driver angles here are the x of A; the x of B at the same instant is x - shift
    shift = cell + b.delay - a.delay
    leaves, enters, last = a.exit, b.entry + shift, b.exit + shift
    path_a, path_b = path_in(a), path_in(b)
    start, kind, found = leaves, Handoff.OVERLAP, False
    if enters <= leaves + CLOSE:
        # both pins are in their slots for a while: look for g_A = g_B
        low, high = enters, leaves
        for _ in range(100 if leaves - enters > CLOSE else 0):
            g_a, _u, dg_a, _radius = pose_at(path_a, start)
            g_b, _u, dg_b, _radius = pose_at(path_b, start - shift)
            guess, low, high = newton_in_bracket(start, g_a - g_b, dg_a - dg_b, low, high, False)
            distance = abs(guess - start)
            start = guess
            if distance <= 1e-15:
                break
        jump = follower_angle_at(b, start - shift) + step - follower_angle_at(a, start)
        found = jump >= -CLOSE
    if not found:
        # the follower angle at which A leaves the follower, counted as that of B
        rest = follower_angle_at(a, leaves) - step
        # a B that has caught up with the follower before A leaves counts as striking at this exit
        start, kind = max(enters, leaves), Handoff.PICK_UP if enters > leaves else Handoff.STRIKE
        jump = follower_angle_at(b, start - shift) - rest
        if jump < -CLOSE:
            # B is behind the follower, and strikes where it has caught up
            if jump < -0.25 * step or not follower_angle_at(b, b.exit) > rest:
                return False
            start, kind, jump = _strike(b, path_b, rest, start - shift) + shift, Handoff.STRIKE, 0.0
    b.edges[0], b.kind, b.jump = start - shift, kind, max(jump, 0.0)
    b.radius = pose_at(path_b, b.edges[0])[3]
    a.edges[1] = start if kind == Handoff.OVERLAP else leaves
    a.dwell = start - a.edges[1]
    return start < last and jump < 0.25 * step


@inner_jit
def _slides_back(pair, pin):
    """Whether the pin changes its sense of sliding along the wall in the course of an impact."""
    if pair.kind != Handoff.STRIKE:
        return False
    g, u, _dg, radius = pose_at(path_in(pair), pair.edges[0])
    # Sliding speeds per driver radian: at the start of the impact the follower is at rest, and at
    # the end it has the speed g.
    at_rest = radius * u - g * pair.pin_numbers[OFFSET] - pin * pair.pin_numbers[PIN_RATE]
    return at_rest * (radius * u + pin * (g - pair.pin_numbers[PIN_RATE])) < 0.0


@inner_jit
def _strike(pair, path, rest, low):
    """Driver angle x after `low` at which Phi of a pair reaches `rest`, by Newton's method."""
    high = pair.exit
    _g, _u, dg, _radius = pose_at(path, low)
    # first guess: if g = 0 at `low`, Phi grows by g' x^2/2 over a small angle x behind it
    missing = rest - follower_angle_at(pair, low)
    x = min(low + np.sqrt(2.0 * missing / abs(dg)), 0.5 * (low + high))
    for _ in range(100):
        g = pose_at(path, x)[0]
        guess, low, high = newton_in_bracket(
            x, follower_angle_at(pair, x) - rest, g, low, high, True
        )
        step = abs(guess - x)
        x = guess
        if step <= 1e-15:
            break
    return x


def pattern_of(
    arms: tuple[float, ...],
    turns: tuple[float, float],
    longer: float,
    pin: float,
    pins: FloatArray,
    slots: FloatArray,
) -> tuple[np.ndarray, int]:
    """The pattern of pins and slots, and its first impossible engagement, -1 if there is none.

    The arguments are those of `lay_pattern`.
    """
    pattern = np.zeros(math.lcm(len(pins), len(slots)), PAIR)
    return pattern, int(lay_pattern(arms, turns, longer, pin, pins, slots, pattern))


def pairs_of(pattern: np.ndarray) -> tuple[Pair, ...]:
    """The engagements of a possible pattern, as `Pair`s for Python."""
    # whole columns are read, since reading a field of a single record takes ten times as long
    names = ("used", "dwell", "delay", "kind", "jump", "radius")
    columns = zip(*(pattern[name].tolist() for name in names), strict=True)
    return tuple(
        Pair(
            path=Path(False, row["pin_numbers"].copy()), edges=row["edges"][:used].copy(),
            dwell=dwell, delay=delay, follower_angle=partial(as_python(follower_angle_at), row),
            kind=Handoff(kind).label, jump=jump, radius=radius,
        )
        for row, (used, dwell, delay, kind, jump, radius) in zip(pattern, columns, strict=True)
    )  # fmt: skip
