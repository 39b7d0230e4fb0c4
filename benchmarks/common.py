"""What several scripts share: where results go, how a table is written, and random losses."""

import argparse
import csv
from pathlib import Path

from escapement.base.text import print_columns, show

RESULTS = Path(__file__).resolve().parent / "results"


def write_rows(name, rows, head=None):
    """Write rows, which are dictionaries or have a head, to a table of the results."""
    head = list(rows[0]) if head is None else head
    lines = [[*row.values()] if isinstance(row, dict) else row for row in rows]
    RESULTS.mkdir(exist_ok=True)
    with (RESULTS / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *lines])


def asked(description, **usual):
    """Whole numbers of the command line, with those of a whole run; and whether it is one."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    for name, count in usual.items():
        parser.add_argument(f"--{name}", type=int, default=count, help=f"default: {count}")
    found = parser.parse_args()
    return *vars(found).values(), vars(found) == usual


def tell(name, rows, whole=True):
    """Print rows, which are dictionaries; the table of the results holds only whole runs."""
    lines = [[show(value) for value in row.values()] for row in rows]
    print_columns([list(rows[0])], lines)
    if whole:
        write_rows(name, lines, list(rows[0]))


def random_losses(random, share, torque, follower, *, bearing=0.1, viscous=0.02):
    """Load, bearing torque and drags, each with the probability `share`, in the units given."""
    clock, model = (follower / torque) ** 0.5, {}
    for name, most in {
        "load_torque": 0.1 * torque, "driver_bearing_torque": bearing * torque,
        "driver_drag": 0.02 * follower, "follower_drag": 0.02 * follower,
        "driver_viscous": viscous * follower / clock,
        "follower_viscous": viscous * follower / clock,
    }.items():  # fmt: skip
        if random.random() < share:
            model[name] = most * random.random()
    return model


def random_journals(random, share, radius):
    """Friction of either body's journal, each with the probability `share`."""
    model = {}
    for body in ("driver", "follower"):
        if random.random() < share:
            model[f"{body}_bearing_friction"] = 0.2 * random.random()
            model[f"{body}_bearing_radius"] = radius
    return model
