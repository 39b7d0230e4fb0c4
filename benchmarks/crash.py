"""The long version of `tests/test_crash.py`: killed processes, failing calls, damaged files.

    python benchmarks/crash.py [--kills 300] [--damages 2000] [--every 1]

Each part raises an error at the first lost block, wrong file or traceback, and otherwise prints how
much it has tried.
"""

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import crash_tools as tools


def kills(folder: Path, count: int) -> str:
    hits = tools.kill_until_done(folder / "a.h5", count, random.Random(1))
    return f"{count} kills, {hits} of them of a running process"


def failing_calls(folder: Path, every: int) -> str:
    injected = 0
    for begun in (False, True):
        call, more = 0, True
        while more:
            hits = [tools.fail_once(folder / "a.h5", call, code, begun) for code in tools.ERRORS]
            injected += sum(hits)
            more, call = all(hits), call + every
    return f"{injected} failing calls"


def damages(folder: Path, count: int) -> str:
    rng = random.Random(2)
    told = [tools.damage_once(folder, rng) for _ in range(count)]
    return f"{count} damages, {sum(map(bool, told))} of them refused, the others harmless"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kills", type=int, default=300)
    parser.add_argument("--damages", type=int, default=2000)
    parser.add_argument("--every", type=int, default=1, help="every n-th call of the write path")
    args = parser.parse_args()
    parts = ((kills, args.kills), (failing_calls, args.every), (damages, args.damages))
    for part, argument in parts:
        begin = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            text = part(Path(folder), argument)
        print(f"{text}: nothing lost, every file equal ({time.perf_counter() - begin:.0f} s)")


if __name__ == "__main__":
    main()
