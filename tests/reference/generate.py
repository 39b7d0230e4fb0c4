"""Reference motions for the tests: accuracy and file format.

``python tests/reference/generate.py [OUT.json]`` solves every case of ``motions.json`` anew, in
about five minutes, from its inputs: Meyer's mechanisms and inertias, the limits of the model, and
six drawn at random. A further case is a further object with these `INPUTS`. Each is solved by
``taylor.py`` at two precisions, orders and tolerances; the largest relative difference of all its
numbers is stored as ``error``.

Inputs are the binary doubles that the JSON numbers stand for.  Units: any coherent set (N m,
kg m^2, s; or Meyer's in-lbf, in-lbf-s^2, s), since only inertia/torque enters; angles in rad,
speeds in rad/s.  ``angle`` counts from dead centre of its engagement; a corner of the speed at pin
entry belongs to the engagement that begins there; start and end of a run are no extrema.
``terminal`` is null without friction, where no terminal speed exists.
"""

import json
import sys
from pathlib import Path

from mpmath import mp, mpf
from taylor import solve

MOTIONS = Path(__file__).with_name("motions.json")
INPUTS = (
    "name", "slots", "pins", "internal", "friction", "driver_inertia", "follower_inertia",
    "torque", "load_torque", "initial_speed", "engagements",
)  # fmt: skip
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


def main():
    lines = []
    for case in json.loads(MOTIONS.read_text(encoding="utf-8")):
        solved = reference({key: case[key] for key in INPUTS})
        lines.append(json.dumps(solved))
        print(solved["name"], solved["error"], file=sys.stderr)
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else MOTIONS
    out.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
