"""Random torques whose knots coincide with breaks of the wheel: `energy` against `ivp`.

Prints every scene that breaks a bar; results/coinciding_breaks.csv has the greatest differences
of states at 400 instants, the energy residual of `energy`, and the seconds of the slower engine.

    python benchmarks/coinciding_breaks.py [SCENES] [FIRST SEED]
"""

import sys
from pathlib import Path
from time import process_time

import numpy as np
from common import write_rows

import escapement as esc

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "tests"))
from coinciding import STATES, counts, curve_scene, differences, spring_scene  # noqa: E402

BARS = {**dict.fromkeys(STATES, 1e-9), "residual": 1e-12, "seconds": 2.0}


def compare(escapement, engagements):
    """What `energy` and `ivp` count, and the greatest differences."""
    seconds, motions = [], []
    for engine, rtol in (("energy", None), ("ivp", 1e-12)):
        start = process_time()
        motion = esc.simulate(escapement, engagements, engine=engine, rtol=rtol)
        motion.balance()
        seconds.append(process_time() - start)
        motions.append(motion)
    found = {"residual": abs(motions[0].ledger.residual), "seconds": max(seconds)}
    return [counts(motion) for motion in motions], found | differences(*motions)


def main(scenes=500, first=0):
    """Compare so many scenes of either family; the table goes to the results."""
    compare(spring_scene(np.random.default_rng(first)), 1)  # compiled and imported before it counts
    rows = []
    for kind in (curve_scene, spring_scene):
        bad, worst = 0, dict.fromkeys(BARS, 0.0)
        for seed in range(first, first + scenes):
            counted, found = compare(kind(np.random.default_rng(seed)), 3 + seed % 2)
            broken = [name for name, bar in BARS.items() if not found[name] <= bar]
            if broken or counted[0] != counted[1]:
                bad += 1
                print(kind.__name__, seed, *counted, {k: f"{found[k]:.1e}" for k in broken})
            worst = {name: max(worst[name], found[name]) for name in BARS}
        rows.append([kind.__name__, scenes, bad, *(f"{value:.1e}" for value in worst.values())])
        print(*rows[-1], flush=True)
    write_rows("coinciding_breaks", rows, ["family", "scenes", "break a bar", *BARS])


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
