"""Outcomes of the cases, kept in CSV files from one part of a run to the next."""

import csv

from comparison import OUTCOMES
from random_cases import Problem

COUNTS = (*OUTCOMES, "error <= 0.1 rtol", "error <= rtol", "error <= 10 rtol")
HEAD = ("engine", "seed", "cases", *COUNTS, "worst ok error / rtol")
FAILED = ("engine", "outcome", "error / rtol", "told", *Problem._fields)


def added(table, results):
    """Counts of a table {engine: row}, with the results of one more case."""
    for engine, kind, error, _told in results:
        row = table.setdefault(engine, dict.fromkeys(("cases", *COUNTS), 0) | {"worst": 0.0})
        row["cases"] += 1
        row[kind] += 1
        if kind == "ok":
            for limit, name in ((0.1, COUNTS[-3]), (1.0, COUNTS[-2]), (10.0, COUNTS[-1])):
                row[name] += error <= limit
            row["worst"] = max(row["worst"], error)


def read(path, seed):
    """Table of earlier runs, and the number of the next case."""
    if not path.exists():
        return {}, 0
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    if any(int(row["seed"]) != seed for row in rows):
        raise SystemExit(f"{path} was written with another seed; add --again to start over")
    table = {
        row["engine"]: {name: int(row[name]) for name in ("cases", *COUNTS)}
        | {"worst": float(row["worst ok error / rtol"])}
        for row in rows
    }
    # every case is in one of these rows
    return table, sum(table[name]["cases"] for name in ("energy", "independent") if name in table)


def write(path, table, seed):
    """Replace the table; each part of a run is in it whole or not at all."""
    partial = path.with_suffix(".partial")
    with open(partial, "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(HEAD)
        for engine, row in table.items():
            counts = [row[name] for name in COUNTS]
            writer.writerow([engine, seed, row["cases"], *counts, f"{row['worst']:.3g}"])
    partial.replace(path)


def append(path, failures):
    """Add rows to the list of failures, with a heading if the file is new."""
    fresh = not path.exists()
    with open(path, "a", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows([FAILED, *failures] if fresh else failures)
