"""Reference motions for the tests: cases, accuracy and file format.

``python tests/reference/generate.py [OUT.json]`` writes ``motions.json`` next to this file in about
five minutes.  Every case is solved by ``taylor.py`` at two precisions, orders and tolerances; the
largest relative difference of all its numbers is stored as ``error``.

Inputs are the binary doubles that the JSON numbers stand for.  Units: any coherent set (N m,
kg m^2, s; or Meyer's in-lbf, in-lbf-s^2, s), since only inertia/torque enters; angles in rad,
speeds in rad/s.  ``angle`` counts from dead centre of its engagement; a corner of the speed at pin
entry belongs to the engagement that begins there; start and end of a run are no extrema.
``terminal`` is null without friction, where no terminal speed exists.
"""

import json
import random
import sys
from pathlib import Path

from mpmath import mp, mpf
from taylor import critical_friction, dimensionless, solve

COARSE = {"digits": 34, "order": 26, "tolerance": "1e-23"}
FINE = {"digits": 42, "order": 32, "tolerance": "1e-29"}


def leaves(tree):
    if isinstance(tree, dict | list):
        for item in tree.values() if isinstance(tree, dict) else tree:
            yield from leaves(item)
    else:
        yield tree


def printable(tree):
    if isinstance(tree, dict):
        return {k: printable(v) for k, v in tree.items()}
    if isinstance(tree, list):
        return [printable(v) for v in tree]
    return mp.nstr(tree, 20) if isinstance(tree, mpf) else tree


def reference(data):
    rough, fine = solve(data, COARSE), solve(data, FINE)
    error = mpf(0)
    for x, y in zip(leaves(rough), leaves(fine), strict=True):
        if isinstance(y, mpf):
            error = max(error, abs(x - y) / abs(y))
        elif x != y:
            raise ArithmeticError("the two resolutions see different events")
    return data | {"error": mp.nstr(error, 3)} | printable(fine)


def problem(name, wheel, friction, inertia, torque, limit=None, **more):
    """Input of one case; ``limit`` gives friction as a fraction of the Painleve limit."""
    data = {
        "name": name,
        "slots": wheel[0],
        "pins": wheel[1],
        "internal": False,
        "friction": friction or 0.0,
        "driver_inertia": inertia[0],
        "follower_inertia": inertia[1],
        "torque": torque,
        "load_torque": 0.0,
        "initial_speed": 0.0,
        "engagements": 6,
    } | more
    critical = critical_friction(dimensionless(data)[0])
    if limit is not None:
        data["friction"] = float(critical * mpf(limit))
    if data["friction"] >= critical:
        raise ValueError(f"{name}: friction must stay below the Painleve limit {critical}")
    return data


def chosen():
    """Meyer's mechanisms and inertias first, then the limits of the model."""
    four, light, heavy = (3e-6, 50e-6), (5e-9, 50e-6), (5e-2, 50e-6)
    six, three = (6e-6, 10e-6), (3e-6, 40e-6)
    yield problem("meyer four pins", (4, 4), 0.35, four, 0.10, engagements=20)
    yield problem("meyer four pins, low friction", (4, 4), 0.20, four, 0.20, engagements=12)
    yield problem("meyer six pins", (3, 6), 0.20, six, 0.03, engagements=12)
    yield problem("meyer six pins, high friction", (3, 6), 0.35, six, 0.03)
    yield problem("meyer three pins", (6, 3), 0.20, three, 0.08, engagements=12)
    yield problem("meyer three pins, high friction", (6, 3), 0.35, three, 0.08)
    yield problem("four pins near the limit", (4, 4), None, four, 0.10, "0.99")
    yield problem("four pins at the limit", (4, 4), None, four, 0.10, "0.9999")
    yield problem("six pins near the limit", (3, 6), None, six, 0.03, "0.99")
    yield problem("six pins at the limit", (3, 6), None, six, 0.03, "0.9999")
    yield problem("three pins near the limit", (6, 3), None, three, 0.08, "0.99")
    yield problem("three pins at the limit", (6, 3), None, three, 0.08, "0.9999")
    yield problem("frictionless", (4, 4), 0.0, four, 0.10)
    pushed = {"load_torque": 0.02, "initial_speed": 20.0}
    yield problem("frictionless with load", (6, 3), 0.0, three, 0.08, **pushed)
    # So fast that dead centre and the reversal behind it nearly coincide.
    yield problem("faster than terminal", (4, 4), 0.25, four, 0.10, initial_speed=3000.0)
    yield problem("slower than terminal", (3, 6), 0.30, six, 0.03, initial_speed=5.0)
    yield problem("light driver", (4, 4), 0.01, light, 0.10)
    yield problem("heavy driver", (4, 4), 0.35, heavy, 0.10)
    yield problem("eight slots, one pin", (8, 1), 0.25, (2e-5, 4e-5), 0.15)
    yield problem("five slots, three pins", (5, 3), 0.30, (2e-5, 3e-5), 0.12)
    yield problem("internal, five slots", (5, 1), 0.15, (1e-5, 2e-5), 0.10, internal=True)
    loaded = {"internal": True, "load_torque": 0.03}
    yield problem("internal with load", (4, 1), 0.20, (3e-5, 2e-5), 0.10, **loaded)
    yield problem("load", (4, 4), 0.35, four, 0.10, load_torque=0.02)
    # No reversal in the first engagement, two in the next ones, one in the last ones.
    slow = {"load_torque": 0.002, "engagements": 20}
    yield problem("load on a heavy driver", (3, 6), 0.10, (4e-3, 1e-5), 0.02, **slow)
    yield problem("load, one pin", (7, 1), 0.30, (4e-5, 2e-5), 0.05, load_torque=0.01)
    # All is decided within sqrt(driver/follower inertia), 1e-4 rad, of pin entry and exit.
    far = (7e-13, 5e-5)
    yield problem("next to no driver", (6, 3), None, far, 0.08, "0.67", load_torque=0.098)


def seeded(count=6, seed=1973):
    """Random wheels, inertias and friction; every third one internal."""
    draw = random.Random(seed)
    for k in range(count):
        internal, slots = k % 3 == 2, draw.randint(3, 12)
        pins = 1 if internal else draw.randint(1, 2 * slots // (slots - 2))
        follower, torque = rounded(10 ** draw.uniform(-7, -4)), rounded(10 ** draw.uniform(-3, 0))
        driver = rounded(follower * 10 ** draw.uniform(-2, 1.5))
        share = f"{draw.uniform(0.1, 0.95):.2f}"
        start = draw.choice([0.0, draw.uniform(0.2, 5.0) * (torque / follower) ** 0.5])
        more = {"internal": internal, "initial_speed": rounded(start)}
        wheel, inertia = (slots, pins), (driver, follower)
        data = problem(f"seeded {k}", wheel, None, inertia, torque, share, **more)
        # g and |u| stay below 1/(a - 1), so p M_f stays below 0.3 tau and the driver cannot stall.
        a = float(dimensionless(data)[0].a)
        bearable = 0.15 * torque * (a - 1) / max(1.0, data["friction"])
        yield data | {"load_torque": rounded(draw.choice([0.0, bearable]))}


def rounded(x):
    return float(f"{x:.6g}")


def main():
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("motions.json")
    with mp.workdps(FINE["digits"]):
        problems = [*chosen(), *seeded()]
    lines = []
    for data in problems:
        case = reference(data)
        lines.append(json.dumps(case))
        print(case["name"], case["error"], file=sys.stderr)
    out.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
