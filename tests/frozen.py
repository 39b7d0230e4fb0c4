"""Three hundred cases whose results must not change when the code is reorganised.

The cases are drawn once and kept in `reference/frozen_cases.json`, inputs and outcomes; a
change that moves them is either a mistake or has to say which numbers were wrong before.

    python tests/frozen.py draw        draw the inputs anew
    python tests/frozen.py record      compute the outcomes with this tree, and keep them
    python tests/frozen.py compare DIR compute with this tree and with that of DIR
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

FILE = Path(__file__).parent / "reference" / "frozen_cases.json"
COUNTS = {"simulate": 140, "terminal": 110, "sweep": 50}
_FIGURES = (
    *("velocity_max", "velocity_min", "velocity_mean", "period", "rise_time", "settling_time"),
    *("handoff_velocity", "contraction", "critical_friction", "acceleration_max"),
    *("follower_acceleration_max", "contact_moment_max", "contact_force_max", "reversal_angles"),
)
_STATE = (
    *("theta", "theta_dot", "theta_ddot", "phi", "phi_dot", "phi_ddot", "contact_moment"),
    "contact_force",
)


def build(case):
    """The escapement of a case, by the public interface alone."""
    import escapement as esc

    given = dict(case["mechanism"])
    kind = given.pop("kind")
    if kind == "Tabulated":
        drive = esc.EllipticalPlanetary(given["sun_radius"], given["planet_radius"])
        theta = np.linspace(*drive.breaks, given["rows"])
        mechanism = esc.Tabulated(theta, drive.follower_angle(theta))
    else:
        mechanism = getattr(esc, kind)(**given)
    return esc.Escapement(mechanism, esc.Inertia(**case["inertia"]), **case["model"])


def outcome(case):
    """What a case gives: lists of numbers by name, and the status."""
    import escapement as esc

    arguments = case["arguments"]
    timer = build(case)
    if case["call"] == "simulate":
        return _of_motion(esc.simulate(timer, **arguments))
    if case["call"] == "terminal":
        cycle = esc.terminal(timer, **arguments)
        found = {name: _plain(getattr(cycle, name)) for name in _FIGURES}
        found["reversal_angles"] = _plain(_away_from_stops(timer.mechanism, cycle.reversal_angles))
        return found | {"status": cycle.status.label}
    study = esc.sweep(timer, **case["axes"], **arguments)
    return {name: _plain(values) for name, values in study.results.items()}


def _of_motion(motion):
    found = {
        "status": motion.status.label,
        "end_time": [motion.end_time],
        "handoff_times": _plain(motion.handoff_times),
        "handoff_velocities": _plain(motion.handoff_velocities),
    }
    if motion.end_time > 0.0:
        for name in ("reversals", "extrema"):
            events = getattr(motion, name)
            kept = ~_next_to_a_stop(motion.escapement.mechanism, events.theta)
            for column in ("engagement", "time", "theta", "theta_dot"):
                found[f"{name}.{column}"] = _plain(getattr(events, column)[kept])
        state = motion.at(motion.end_time * np.linspace(0.0, 1.0, 9))
        found |= {f"at.{name}": _plain(getattr(state, name)) for name in _STATE}
        found["friction"] = [motion.ledger.friction]
    return found


def _away_from_stops(mechanism, angles):
    """The driver angles of events, without those next to a stop of a table."""
    if angles is None:
        return None
    theta = np.asarray(angles, dtype=float)
    return theta[~_next_to_a_stop(mechanism, theta)]


def _next_to_a_stop(mechanism, theta):
    """Which events have a place that the last digit of a table's rows decides: the processor's."""
    if type(mechanism).__name__ != "Tabulated":
        return np.zeros(theta.size, dtype=bool)
    way = (theta - mechanism.breaks[0]) % mechanism.cell_angle
    return np.minimum(way, mechanism.cell_angle - way) < 1e-5


def _plain(values):
    """A dozen of some numbers, evenly chosen, and how many there are."""
    if values is None:
        return None
    flat = np.asarray(values, dtype=float).reshape(-1)
    chosen = flat[np.unique(np.linspace(0, flat.size - 1, 12).astype(int))] if flat.size else flat
    return [*map(float, chosen), float(flat.size)]


def difference(found, expected):
    """Greatest relative difference of two outcomes, and the name that has it.

    Each list is compared relative to its greatest magnitude; other statuses, lengths or
    missing values differ by infinity.
    """
    worst = 0.0, ""
    for name in {*found, *expected}:
        one, two = found.get(name), expected.get(name)
        if isinstance(one, list) and isinstance(two, list) and len(one) == len(two):
            a, b = np.array(one, dtype=float), np.array(two, dtype=float)
            same = (a == b) | (np.isnan(a) & np.isnan(b))
            scale = np.abs(b[np.isfinite(b)]).max(initial=1e-300)
            with np.errstate(invalid="ignore"):  # infinite less infinite
                off = np.where(same, 0.0, np.abs(a - b) / scale)
            apart = float(np.where(np.isnan(off), np.inf, off).max(initial=0.0))
        else:
            apart = 0.0 if one == two else np.inf
        if apart > worst[0]:
            worst = apart, name
    return worst


def allowed(case, energy=1e-14):
    """What a change of structure may move: rounding, and less than the tolerance asked for."""
    arguments, table = case["arguments"], case["mechanism"]["kind"] == "Tabulated"
    if arguments.get("engine") == "ivp":
        # next to a stop the rounding of a table's rows decides where a reversal lies
        return (10.0 if table else 1.0) * arguments.get("rtol", 1e-10)
    # accelerations carry the rounding of a table's rows over the square of their distance; at a
    # handoff rounding decides whether the piece before it or the one behind it is read
    return max(energy, 2e-11 if table else 0.0, 0.1 * arguments.get("rtol", 0.0))


# --- drawing the inputs ---------------------------------------------------------------------


def draw(seed=20261123):
    """Inputs of all cases: every kind of mechanism, loads, starts, tolerances, both engines."""
    random = np.random.default_rng(seed)
    cases = []
    for call, count in COUNTS.items():
        for k in range(count):
            ivp = call != "sweep" and k % 4 == 3
            case = _draw_one(random, call, ivp)
            case["name"] = f"{call}-{k:03d}"
            cases.append(case)
    return cases


def _draw_one(random, call, ivp):
    import escapement as esc

    while True:
        case = {"call": call, "mechanism": _draw_mechanism(random)}
        if ivp and call == "terminal" and case["mechanism"]["kind"] == "Tabulated":
            continue  # up to half a minute each: the knots of a table are all pieces
        follower = 10.0 ** random.uniform(-7, -3)
        ratio = 10.0 ** random.uniform(-2, 1)
        case["inertia"] = {"driver": follower * ratio, "follower": follower}
        torque = 10.0 ** random.uniform(-3, 1)
        case["model"] = model = {"torque": torque}
        try:
            timer = build(case)
        except esc.errors.InvalidValue:
            continue
        if case["mechanism"]["kind"] in ("Tabulated", "EllipticalPlanetary"):
            model["efficiency"] = random.uniform(0.6, 1.0)
        else:
            limit = esc.critical_friction(timer.mechanism, timer.inertia)
            model["friction"] = min(limit, 3.0) * random.choice([0.0, 0.05, 0.3, 0.7, 0.95, 1.1])
        if random.random() < 0.4:
            greatest = np.abs(timer.mechanism.transmission(np.linspace(*_ends(timer), 99)).g).max()
            model["load_torque"] = torque / greatest * random.uniform(0.0, 0.7)
        case["arguments"] = _draw_arguments(random, call, ivp, timer)
        if call == "sweep":
            case["axes"] = _draw_axes(random, model)
        return case


def _ends(timer):
    return timer.mechanism.breaks[0], timer.mechanism.breaks[-1]


def _draw_mechanism(random):
    kind = random.choice(["Geneva", "internal", "GearDriven", "EllipticalPlanetary", "Tabulated"],
                         p=[0.5, 0.15, 0.15, 0.1, 0.1])  # fmt: skip
    if kind == "Geneva":
        n = int(random.integers(3, 13))
        pins = int(random.integers(1, 2 * n // (n - 2) + 1))
        sized = {"crank_radius": 0.01} if random.random() < 0.3 else {}
        return {"kind": kind, "slots": n, "pins": pins, **sized}
    if kind == "internal":
        return {"kind": "Geneva", "slots": int(random.integers(3, 13)), "internal": True}
    if kind == "GearDriven":
        curve = random.choice(["hypocycloid", "epicycloid", "contracted-hypocycloid"])
        lobes = str(random.choice(["1/2", "1", "3/2", "2", "3"]))
        return {
            "kind": kind, "stations": int(random.integers(4, 9)), "lobes": lobes,
            "curve": str(curve), "unused_lobes": int(random.integers(0, 2)),
        }  # fmt: skip
    sun = 0.01 * random.uniform(1.2, 3.0)
    size = {"rows": int(random.integers(60, 200))} if kind == "Tabulated" else {}
    return {"kind": str(kind), "sun_radius": sun, "planet_radius": 0.01, **size}


def _draw_arguments(random, call, ivp, timer):
    speed = random.choice([0.0, 0.0, 1.0, 30.0]) * random.uniform(0.5, 2.0) / timer.time_unit
    arguments = {"initial_speed": speed} if speed else {}
    if ivp:
        return (
            arguments
            | {"engine": "ivp", "rtol": float(random.choice([1e-6, 1e-8, 1e-10]))}
            | ({"engagements": int(random.integers(1, 7))} if call == "simulate" else {})
        )
    rtol = random.choice([0.0, 1e-6, 1e-9, 1e-13])
    arguments |= {"rtol": float(rtol)} if rtol else {}
    if call != "simulate":
        return arguments
    if random.random() < 0.2:
        return arguments | {"duration": timer.time_unit * random.uniform(1.0, 60.0)}
    return arguments | {"engagements": int(random.integers(1, 60))}


def _draw_axes(random, model):
    axes = {"torque": [0.5 * model["torque"], model["torque"], 3.0 * model["torque"]]}
    if "friction" in model:
        axes["friction"] = [model["friction"] * x for x in (0.5, 0.8, 0.9, 1.0)]
    if random.random() < 0.5:
        axes["driver_inertia"] = [1e-7, 1e-6, 1e-5]
    return axes


# --- comparing ------------------------------------------------------------------------------


def outcomes_of(source):
    """Outcomes of all cases as the package below `source` gives them, in its own process."""
    environment = {**os.environ, "PYTHONPATH": str(source)}
    done = subprocess.run(
        [sys.executable, __file__, "outcomes"], env=environment, stdout=subprocess.PIPE, check=True
    )
    return json.loads(done.stdout)


def main():
    """Draw, record or compare; see the head of the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("action", choices=("draw", "record", "outcomes", "compare"))
    parser.add_argument("other", nargs="?", type=Path)
    given = parser.parse_args()
    here = Path(__file__).parents[1] / "src"
    if given.action == "draw":
        write([{"input": case} for case in draw()])
        return
    rows = json.loads(FILE.read_text())
    if given.action == "outcomes":
        json.dump([outcome(row["input"]) for row in rows], sys.stdout)
        return
    if given.action == "record":
        pairs = zip(rows, outcomes_of(here), strict=True)
        write([{"input": row["input"], "outcome": found} for row, found in pairs])
        return
    before, after = outcomes_of(given.other / "src"), outcomes_of(here)
    equal, broken = 0, 0
    for row, old, new in zip(rows, before, after, strict=True):
        apart, name = difference(new, old)
        equal += apart == 0.0
        if apart > allowed(row["input"]):
            broken += 1
            print(f"{row['input']['name']}: {name} moved by {apart:.3g}")
    print(f"{len(rows)} cases, {equal} with the same bits, {broken} beyond what is allowed")
    sys.exit(1 if broken else 0)


def write(rows):
    """Keep the cases, one a line."""
    FILE.write_text("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


if __name__ == "__main__":
    main()
