"""How often tests of normality reject errors that are normal, and errors that are not.

``python benchmarks/normality_level.py [--repetitions 100000]``

A test at the level of 5 % should reject 5 % of all sets of normal errors. Each rate has its
standard error, and how many of these it lies from the level; for normal errors more than three mean
that the test rejects too often or too rarely.
"""

import numpy as np
from common import asked, tell

from escapement.measurement import (
    anderson_darling,
    histogram,
    published_chi_squared,
)

BATCH = 1000
LEVELS = (0.05, 0.01)
CASES = ((20, 4), (50, 7), (148, 7), (148, 9), (148, 14), (1000, 11), (5000, 14))
OTHER_LAWS_AT = (148, 9)
TESTS = {
    "chi-squared as published": lambda errors, bins: (
        published_chi_squared(histogram(errors, bins)).p_value
    ),
    "Anderson-Darling": lambda errors, bins: anderson_darling(errors).p_value,
}
LAWS = {
    "normal": lambda random, shape: random.standard_normal(shape),
    "uniform": lambda random, shape: random.uniform(-(3**0.5), 3**0.5, shape),
    "Laplace": lambda random, shape: random.laplace(0.0, 0.5**0.5, shape),
    "normal and once a turn": lambda random, shape: (
        (random.standard_normal(shape) + 2.0 * _wave(shape[1])) / 3.0**0.5
    ),
}


def _wave(samples):
    return np.sin(np.linspace(0.0, 6.0 * np.pi, samples, endpoint=False))


def rates(law, samples, bins, repetitions, seed):
    """Share of the sets of errors that each test rejects, on the same sets."""
    below = {(name, level): 0 for name in TESTS for level in LEVELS}
    batches = -(-repetitions // BATCH)
    for batch in range(batches):
        random = np.random.default_rng([seed, samples, bins, batch])
        errors = LAWS[law](random, (BATCH, samples))
        for name, test in TESTS.items():
            p_values = np.array([test(one, bins) for one in errors])
            for level in LEVELS:
                below[name, level] += int((p_values < level).sum())
    total = batches * BATCH
    for (name, level), count in below.items():
        rate, error = count / total, (level * (1.0 - level) / total) ** 0.5
        yield {
            "law": law, "samples": samples, "bins": bins, "test": name, "level": level,
            "rate": rate, "standard_error": error, "misses": (rate - level) / error,
        }  # fmt: skip


def main():
    """Repeat, print, write."""
    repetitions, seed, whole = asked(__doc__, repetitions=100_000, seed=2020)
    cases = [("normal", *case) for case in CASES]
    cases += [(law, *OTHER_LAWS_AT) for law in LAWS if law != "normal"]
    tell("normality_level", [x for case in cases for x in rates(*case, repetitions, seed)], whole)


if __name__ == "__main__":
    main()
