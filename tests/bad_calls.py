"""An escapement that tests change, and values that break the rules of their declarations."""

import math

import numpy as np

import escapement as esc
from escapement.base.quantity import Choice, Quantity, Truth, declared
from escapement.base.units import printed
from escapement.engines.solver import Solver
from escapement.mechanisms import kind_of
from escapement.model.escapement import Run
from escapement.study.parse import parse_plan

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
WHEEL = esc.Geneva(slots=4)
TIMER = esc.Escapement(WHEEL, INERTIA, torque=0.0113, friction=0.35)
MACHINES = {
    "geneva": {"slots": 4},
    "gear-driven": {"stations": 12, "lobes": 5, "curve": "epicycloid"},
    "elliptical-planetary": {"sun_radius": 0.6, "planet_radius": 0.3},
}


def built(**changes):
    model = {"mechanism": WHEEL, "inertia": INERTIA, "torque": 0.0113, "friction": 0.35}
    return esc.Escapement(**(model | changes))


def wheel(**changes):
    return esc.Geneva(**({"slots": 4} | changes))


def ivp(**changes):
    return esc.simulate(TIMER, 1, **({"engine": "ivp"} | changes))


def study(kind="geneva", **changes):
    content = {"mechanism": {"kind": kind} | MACHINES[kind], "torque": 1.0}
    content |= {"inertia": {"driver": 1.0, "follower": 1.0}, "sweep": {"initial_speed": [0.1]}}
    return parse_plan(content | changes)


def maker(owner, kind):
    """A function of one keyword that makes a thing of a class that is right but for it."""
    right = {esc.Inertia: {"driver": 1.0, "follower": 1.0}, Solver: {"engine": "ivp"}}
    if owner is Run:
        return lambda **wrong: esc.simulate(TIMER, **wrong)
    if owner is esc.Escapement:
        return built
    return lambda **wrong: owner(**(right.get(owner) or MACHINES[kind]) | wrong)


def declarations():
    """Everything declared but tables: its class, kind of mechanism, name and entry."""
    owners = [(kind_of(kind), kind) for kind in MACHINES]
    model = "geneva"
    owners += [(owner, model) for owner in (esc.Escapement, esc.Inertia, Solver, Run)]
    for owner, kind in owners:
        for name, entry in declared(owner).items():
            if isinstance(entry, Quantity | Choice | Truth):
                yield owner, "elliptical-planetary" if name == "efficiency" else kind, name, entry


def outside(entry):
    """Numbers just outside the range of a declaration."""
    if not isinstance(entry, Quantity):
        return []
    low, high = entry.minimum, entry.maximum
    if entry.whole or entry.fraction:
        return [int(low) - 1] + ([int(high) + 1] if math.isfinite(high) else [])
    found = [low if entry.exclusive else math.nextafter(low, -math.inf)] * math.isfinite(low)
    return found + [high if entry.below else math.nextafter(high, math.inf)] * math.isfinite(high)


def wrong_values(entry):
    """What no declaration of this sort allows."""
    if isinstance(entry, Truth):
        return [0, 1.0, "yes", np.array([True, False])]
    if isinstance(entry, Choice):
        return ["nonsense", "", 4, True]
    more = [2.5, "4"] if entry.whole else [] if entry.fraction else ["0.1", b"1", 1j]
    return [math.nan, math.inf, -math.inf, True, "x", np.True_, *more, *outside(entry)]


def rules_of(entry):
    """What a message may call the rule that a value breaks."""
    if isinstance(entry, Truth):
        return {"true or false"}
    if isinstance(entry, Choice):
        return {"one of " + ", ".join(entry.allowed)}
    low, high = entry.minimum, entry.maximum
    if entry.whole:
        return {f"a whole number of at least {low:.0f}", f"a whole number of at most {high:.0f}"}
    if entry.fraction:
        known = "a rational number of at least 0, its denominator at most 1000"
        return {known, f"at most {high:g}"}
    below = f" and {'below' if entry.below else 'at most'} {high:g}"
    words = f"{'greater than' if entry.exclusive else 'at least'} {low:g}"
    return {"a finite number", words + below * math.isfinite(high)}


def remedy_of(entry, system="SI"):
    """The remedy of a declaration, with its unit behind the first words."""
    unit = printed(entry.unit, system) if isinstance(entry, Quantity) else ""
    if not unit or entry.whole or entry.fraction:
        return entry.remedy
    first, comma, rest = entry.remedy.partition(",")
    return f"{first} in {unit}{comma}{rest}"


def fault(message, label, entry, value):
    """What is wrong with a message about a value, "" if it is that of the declaration."""
    said, _, remedy = message.partition("; ")
    # a word of the command line may be read as a number, and a fraction is shown as typed
    shown = {" ".join(text.split()) for text in (repr(value), str(value), repr(str(value)))}
    right = {f"{label} must be {rule}, got {text}" for rule in rules_of(entry) for text in shown}
    # a misspelt word is answered by the nearest
    known = remedy == remedy_of(entry) if isinstance(entry, Quantity) else remedy
    return "" if said in right and known else f"{label}: {message}"


BAD = [
    (owner, kind, name, entry, value)
    for owner, kind, name, entry in declarations()
    for value in wrong_values(entry)
]
