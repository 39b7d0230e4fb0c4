"""The package's benchmark with the solvers of other packages added.

``python benchmarks/standings.py [--quick] [-o DIR]``

It measures what ``escapement bench`` measures and writes the same tables and figure to
benchmarks/results, with heyoka among the solvers if it is installed. The quick version writes
files only with ``-o``.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import peers

from escapement.benchmark import work_precision
from escapement.cli.bench import print_tables

RESULTS = Path(__file__).resolve().parent / "results"


def main() -> None:
    """Measure, print, and fill the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="ten seconds, not many minutes")
    parser.add_argument("-o", "--output", type=Path, help=f"folder (default: {RESULTS})")
    args = parser.parse_args()
    further = [each for each in peers.peer_solvers() if not args.quick or each.solver == "heyoka"]
    if not further:
        print("heyoka is not installed and is not measured; it is in the extra 'bench'")
    results = work_precision.run(
        quick=args.quick, further=further, note=lambda text: print(text, file=sys.stderr)
    )
    folder = args.output or (None if args.quick else RESULTS)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        work_precision.write(results, folder)
    print_tables(results)


if __name__ == "__main__":
    main()
