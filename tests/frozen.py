"""Three hundred cases whose results must not change when the code is reorganised.

The cases are drawn once and kept in `reference/frozen_cases.json`, inputs and outcomes; a
change that moves them is either a mistake or has to say which numbers were wrong before.

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


def outcomes_of(source):
    """Outcomes of all cases as the package below `source` gives them, in its own process."""
    environment = {**os.environ, "PYTHONPATH": str(source)}
    done = subprocess.run(
        [sys.executable, __file__, "outcomes"], env=environment, stdout=subprocess.PIPE, check=True
    )
    return json.loads(done.stdout)


def main():
    """Record or compare; see the head of the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("action", choices=("record", "outcomes", "compare"))
    parser.add_argument("other", nargs="?", type=Path)
    given = parser.parse_args()
    here = Path(__file__).parents[1] / "src"
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
