"""Calls that must be refused: what is wrong, and what their message must say."""

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np

import escapement as esc
from escapement.study.parse import parse_plan

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
WHEEL = esc.Geneva(slots=4)
TIMER = esc.Escapement(WHEEL, INERTIA, torque=0.0113, friction=0.35)
MODEL = ["--torque", "0.0113", "--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6"]
MODEL += ["--friction", "0.35", "-o", "out.h5", "--plot", "out.png"]


class Bad(NamedTuple):
    """A call that must be refused, and what its message must say."""

    call: Any
    name: str
    rule: str
    value: str


class Text(str):
    """A string that is not of the very type str."""


def built(**changes):
    model = {"mechanism": WHEEL, "inertia": INERTIA, "torque": 0.0113, "friction": 0.35}
    return esc.Escapement(**(model | changes))


def inertia(**changes):
    return esc.Inertia(**({"driver": 1.0, "follower": 1.0} | changes))


def wheel(**changes):
    return esc.Geneva(**({"slots": 4} | changes))


def ivp(**changes):
    return esc.simulate(TIMER, 1, **({"engine": "ivp"} | changes))


def lasting(**changes):
    return esc.simulate(TIMER, **changes)


def first_steps(**changes):
    return esc.simulate(TIMER, 1, **changes)


def figures(**changes):
    return esc.terminal(TIMER, **changes)


def grid(**changes):
    return esc.sweep(TIMER, **changes)


def study(**changes):
    content = {"mechanism": {"slots": 4}, "inertia": {"driver": 1.0, "follower": 1.0}}
    content |= {"torque": 1.0, "sweep": {"friction": [0.1]}}
    return parse_plan(content | changes)


def show(value):
    return repr(value).partition("\n")[0][:20]


# number, how it is given, its rule, and values outside it
NUMBERS = {
    "torque": (built, "torque", "greater than 0", [0, -0.0, -3e-6]),
    "friction": (built, "friction", "at least 0", [-1e-300, -0.35]),
    "load_torque": (built, "load_torque", "at least 0", [-0.5]),
    "efficiency": (built, "efficiency", "in [0.001, 1]", [1.5, 1e-4]),
    "driver_inertia": (inertia, "driver", "greater than 0", [0.0, -3e-6]),
    "follower_inertia": (inertia, "follower", "greater than 0", [0.0, -1]),
    "crank_radius": (wheel, "crank_radius", "greater than 0", [0, -0.02]),
    "initial_speed": (first_steps, "initial_speed", "at least 0", [-1.0]),
    "duration": (lasting, "duration", "greater than 0", [0.0, -2]),
    "rtol": (figures, "rtol", "at least 1e-13 and below 1", [0, -1e-9, 1.0, 9e-14, 2]),
    "atol": (ivp, "atol", "at least 0", [-1e-12]),
    "max_step": (ivp, "max_step", "greater than 0", [0, -1e-3]),
}


NO_NUMBERS = [
    *("0.1", "", Text("1"), b"1", True, math.nan, math.inf, -math.inf, [0.1], {}, 1j, 10**400),
    *(np.float64("nan"), np.str_("1"), np.array([0.1]), np.array([0.1, 0.2]), np.array("0.1")),
    *(np.array([["0.1"], ["0.2"]]), np.array(True), np.zeros((0, 3)), np.array(1j)),
    *(np.True_, np.complex128(1 + 2j), np.datetime64("1973-01-01"), object),
]


WHOLE = {
    "slots": (wheel, "a whole number of at least 3", [2, 0, -4]),
    "pins": (wheel, "a whole number of at least 1", [0, -1]),
    "engagements": (partial(esc.simulate, TIMER), "a whole number of at least 1", [0, -20]),
    "workers": (partial(grid, friction=[0.3]), "a whole number of at least 1", [0, -2]),
}


NOT_WHOLE = [
    "4",
    4.0,
    2.5,
    math.nan,
    True,
    [4],
    4j,
    np.float64(4.0),
    np.array([4]),
    np.array([4, 5]),
]


CHOICES = {
    "engine": (first_steps, "energy, ivp"),
    "method": (ivp, "DOP853, RK45, RK23, Radau, BDF, LSODA"),
}
NO_CHOICE = ["euler", "", "RK54", 4, 4.5, True, ["ivp"], b"ivp", np.array(["ivp", "energy"])]


def numbers():
    for name, (call, key, rule, outside) in NUMBERS.items():
        for value in NO_NUMBERS:
            yield Bad(partial(call, **{key: value}), name, "a finite number", show(value))
        for value in outside:
            yield Bad(partial(call, **{key: value}), name, rule, show(value))
    for name, (call, rule, outside) in WHOLE.items():
        for value in [*NOT_WHOLE, *outside]:
            yield Bad(partial(call, **{name: value}), name, rule, show(value))
    for name, (call, allowed) in CHOICES.items():
        for value in NO_CHOICE:
            yield Bad(partial(call, **{name: value}), name, f"one of {allowed}", show(value))


def objects():
    for value in (4, None, "geneva", esc.Geneva, INERTIA):
        yield Bad(partial(built, mechanism=value), "mechanism", "a mechanism", show(value))
    for value in ((1.0, 2.0), None, 1.0, esc.Inertia):
        yield Bad(partial(built, inertia=value), "inertia", "an Inertia", show(value))
    for value in (None, WHEEL, esc.Escapement):
        for call in (esc.simulate, esc.terminal):
            yield Bad(partial(call, value), "escapement", "an Escapement", show(value))
    for value in (0, 1, "yes", None, np.array([True, False])):
        yield Bad(partial(wheel, internal=value), "internal", "true or false", show(value))


def together():
    for n, pins, most in ((4, 5, 4), (5, 4, 3), (3, 7, 6), (1000, 3, 2), (6, 10**400, 3)):
        call = partial(esc.Geneva, n, pins)
        yield Bad(call, "pins", f"at most {most} for {n} slots", show(pins))
    inside = partial(esc.Geneva, 5, 2, internal=True)
    yield Bad(inside, "pins", "at most 1 for an internal wheel", "2")
    both = partial(lasting, engagements=3, duration=1.0)
    yield Bad(both, "engagements and duration", "not both be given", "3 and 1.0")
    for name, value in (("atol", 1e-9), ("method", "RK45"), ("max_step", 1.0)):
        call = partial(first_steps, **{name: value})
        yield Bad(call, name, "left out with engine 'energy'", show(value))
    yield Bad(partial(built, efficiency=0.0), "efficiency", "in [0.001, 1]", "0.0")
    yield Bad(partial(built, efficiency=0.9), "efficiency", "1 for a slotted mechanism", "0.9")
    tiny = partial(built, torque=1e-300)
    yield Bad(tiny, "follower_inertia / torque", "between 1e-100 and 1e100", "e+294")
    light = partial(inertia, driver=1e-300)
    yield Bad(light, "driver_inertia / follower_inertia", "between 1e-100 and 1e100", "1e-300")
    yield Bad(partial(built, load_torque=1e300), "load_torque / torque", "below 1e100", "e+301")
    yield Bad(partial(first_steps, initial_speed=1e300), "initial_speed", "at most", "1e+300")
    for count in (10**7, 10**400, 10**5000):
        yield Bad(partial(esc.Geneva, count), "slots", "at most 1000000", "")
    for count in (10**12, 10**30, 10**400):
        call = partial(esc.simulate, TIMER, count)
        yield Bad(call, "engagements", "whole number of at most 10000000", show(count))
    many = partial(esc.simulate, TIMER, 10_001, engine="ivp")
    yield Bad(many, "engagements", "whole number of at most 10000", "10001")
    for engine, most in (("energy", 10_000_000), ("ivp", 10_000)):
        for time in (1e9, 1e300):
            call = partial(lasting, duration=time, engine=engine)
            yield Bad(call, "duration", f"in which {most} engagements pass", show(time))


def look(t):
    return esc.simulate(TIMER, 1).at(t)


def times():
    rule = "between 0 and the end of the motion"
    for t in (-1e-300, -1.0, 1.0, math.nan, math.inf, [0.0, 0.01, 9.0], [[math.nan]], None):
        shown = show(float(np.array(t, dtype=float).flat[-1]))
        yield Bad(partial(look, t), "t", rule, shown)
    for t in ("now", 1j, {}, [[0.0], [0.0, 0.0]], 10**400):
        yield Bad(partial(look, t), "t", "a time in s or an array of times", show(t))


def axes():
    yield Bad(grid, "study", "sweep at least one parameter", "none")
    for value in ("0.1", None, True, {1, 2}, np.zeros((2, 0)), np.array(["a"])):
        yield Bad(partial(grid, friction=value), "friction", "must be", "")
    for name, value, rule in (
        ("friction", -0.1, "at least 0"),
        ("torque", 0.0, "greater than 0"),
        ("load_torque", math.nan, "a finite number"),
        ("driver_inertia", -1.0, "greater than 0"),
        ("follower_inertia", math.inf, "a finite number"),
        ("initial_speed", -2.0, "at least 0"),
        ("slots", 2, "a whole number of at least 3"),
        ("pins", 0, "a whole number of at least 1"),
    ):
        yield Bad(partial(grid, **{name: [5.0, value]}), f"{name}[1]", rule, show(value))
        yield Bad(partial(study, sweep={name: [value]}), f"{name}[0]", rule, show(value))
    yield Bad(partial(grid, friction=[]), "friction", "at least one value", "an empty axis")
    yield Bad(partial(grid, radius=[1.0]), "'radius'", "unknown key", "radius")
    for key, value in (("start", "a"), ("stop", -1.0), ("num", 0), ("log", "yes"), ("step", 1)):
        form = {"start": 0.1, "stop": 0.2, "num": 2, key: value}
        rule = "unknown key" if key == "step" else "must be"
        shown = "" if key == "step" else show(value)
        yield Bad(partial(study, sweep={"friction": form}), key, rule, shown)


def studies():
    for section in ("mechanism", "inertia", "sweep", "solver"):
        for value in ("x", 4, [1]):
            yield Bad(partial(study, **{section: value}), section, "a table", show(value))
    for key, value in (("engine", "eenrgy"), ("method", "RK45"), ("rtol", "small"), ("atol", 1.0)):
        rule = "left out with engine 'energy'" if key in ("method", "atol") else "must be"
        yield Bad(partial(study, solver={key: value}), key, rule, show(value))
    for value in ("imperial", None, 3, ["SI"]):
        yield Bad(partial(study, units=value), "units", "one of SI, in-lbf-s", show(value))
    for value in (None, 3, "two\nlines", ["a"]):
        yield Bad(partial(study, title=value), "title", "one line of text", show(value))
    for key in ("frictions", "Torque", "slot", "", "sweeps", "load torque"):
        yield Bad(partial(study, **{key: 1.0}), repr(key), "unknown key", key)


TABLE = [*numbers(), *objects(), *together(), *times(), *axes(), *studies()]
