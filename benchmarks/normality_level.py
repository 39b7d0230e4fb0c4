"""How often tests of normality reject errors that are normal, and errors that are not.

``python benchmarks/normality_level.py [--repetitions 100000]``

A test at the level of 5 % should reject 5 % of all sets of normal errors. Whether
Pearson's chi-squared test does so depends on how the classes are chosen and how mean and deviation
are estimated; each combination is a test here.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import chi2

from escapement.base.text import print_columns
from escapement.benchmark import write_csv
from escapement.measurement import (
    anderson_darling,
    chi_squared,
    histogram,
    published_chi_squared,
)
from escapement.measurement.normality import counts

ROOT = Path(__file__).resolve().parents[1]
BATCH = 1000
LEVELS = (0.05, 0.01)
CASES = ((20, 4), (50, 7), (148, 7), (148, 9), (148, 14), (1000, 11), (5000, 14))
OTHER_LAWS_AT = (148, 9)

P = Callable[[np.ndarray, int], np.ndarray]


class Rate(NamedTuple):
    """Share of the sets of errors that a test rejects.

    misses : how many standard errors the rate lies from the level; for normal errors
        more than three mean that the test rejects too often or too rarely.
    """

    law: str
    samples: int
    bins: int
    test: str
    level: float
    rate: float
    standard_error: float
    misses: float


def published(errors: np.ndarray, bins: int) -> np.ndarray:
    """Classes of equal width, mean and deviation from the classes, none outside: bins - 3."""
    return published_chi_squared(histogram(errors, bins)).p_value


def equal_width(errors: np.ndarray, bins: int) -> np.ndarray:
    """Classes of equal width, outer ones open, mean and deviation of the errors: bins - 3."""
    observed, expected = _open_classes(errors, bins)
    return chi2.sf(_pearson(observed, expected), bins - 3)


def merged(errors: np.ndarray, bins: int) -> np.ndarray:
    """The same, classes merged from the ends until five errors are expected in each."""
    found = np.empty(len(errors))
    for i, (observed, expected) in enumerate(zip(*_open_classes(errors, bins), strict=True)):
        while expected.size > 1 and expected[0] < 5.0:
            observed, expected = _joined(observed), _joined(expected)
        while expected.size > 1 and expected[-1] < 5.0:
            observed, expected = _joined(observed[::-1])[::-1], _joined(expected[::-1])[::-1]
        freedom = expected.size - 3
        found[i] = chi2.sf(_pearson(observed, expected), freedom) if freedom > 0 else 1.0
    return found


def equally_probable(errors: np.ndarray, bins: int) -> np.ndarray:
    """Classes of equal probability, mean and deviation of the errors: bins - 3."""
    observed, expected = _probable_classes(_standard(errors), bins)
    return chi2.sf(_pearson(observed, expected), bins - 3)


def fitted_to_counts(errors: np.ndarray, bins: int) -> np.ndarray:
    """Classes of equal probability, mean and deviation fitted to the counts: bins - 3.

    To first order, after Dzhaparidze and Nikulin (1974): from the deviations of the counts their
    projection on the changes that mean and deviation can cause is subtracted.
    """
    observed, expected = _probable_classes(_standard(errors), bins)
    deviation = (observed - expected) / np.sqrt(expected)
    inner = ndtri(np.arange(1, bins) / bins)
    density = np.exp(-0.5 * inner**2)
    rates = np.diff([density, inner * density], prepend=0.0, append=0.0, axis=-1)
    directions, _ = np.linalg.qr(rates.T)
    statistic = (deviation**2).sum(axis=-1) - ((deviation @ directions) ** 2).sum(axis=-1)
    return chi2.sf(statistic, bins - 3)


def known_law(errors: np.ndarray, bins: int) -> np.ndarray:
    """Classes of equal probability, true mean 0 and deviation 1: bins - 1."""
    observed, expected = _probable_classes(errors, bins)
    return chi2.sf(_pearson(observed, expected), bins - 1)


TESTS: dict[str, P] = {
    "chi-squared as published": published,
    "equal widths, open ends": equal_width,
    "equal widths, merged to five": merged,
    "equal probabilities": equally_probable,
    "equal probabilities, fitted to counts": fitted_to_counts,
    "equal probabilities, known law": known_law,
    "chi-squared": lambda errors, bins: chi_squared(errors, bins).p_value,
    "Anderson-Darling": lambda errors, bins: anderson_darling(errors).p_value,
}

LAWS: dict[str, Callable[[np.random.Generator, tuple[int, int]], np.ndarray]] = {
    "normal": lambda random, shape: random.standard_normal(shape),
    "uniform": lambda random, shape: random.uniform(-(3**0.5), 3**0.5, shape),
    "Laplace": lambda random, shape: random.laplace(0.0, 0.5**0.5, shape),
    "normal and once a turn": lambda random, shape: (
        (random.standard_normal(shape) + 2.0 * _wave(shape[1])) / 3.0**0.5
    ),
}


def _wave(samples: int) -> np.ndarray:
    return np.sin(np.linspace(0.0, 6.0 * np.pi, samples, endpoint=False))


def _standard(errors: np.ndarray) -> np.ndarray:
    return (errors - errors.mean(axis=-1, keepdims=True)) / errors.std(axis=-1, keepdims=True)


def _probable_classes(standard: np.ndarray, bins: int) -> tuple[np.ndarray, float]:
    places = np.minimum((bins * ndtr(standard)).astype(int), bins - 1)
    return counts(places, bins), standard.shape[-1] / bins


def _open_classes(errors: np.ndarray, bins: int) -> tuple[np.ndarray, np.ndarray]:
    classes = histogram(errors, bins)
    mean, deviation = (f(axis=-1, keepdims=True) for f in (errors.mean, errors.std))
    shares = ndtr((classes.edges - mean) / deviation)
    shares[:, 0], shares[:, -1] = 0.0, 1.0
    return classes.observed, errors.shape[-1] * np.diff(shares, axis=-1)


def _joined(values: np.ndarray) -> np.ndarray:
    return np.concatenate([[values[0] + values[1]], values[2:]])


def _pearson(observed: np.ndarray, expected: np.ndarray | float) -> np.ndarray:
    return ((observed - expected) ** 2 / expected).sum(axis=-1)


def rates(law: str, samples: int, bins: int, repetitions: int, seed: int) -> Iterator[Rate]:
    """Every test on the same sets of errors."""
    below = {(name, level): 0 for name in TESTS for level in LEVELS}
    batches = -(-repetitions // BATCH)
    for batch in range(batches):
        random = np.random.default_rng([seed, samples, bins, batch])
        errors = LAWS[law](random, (BATCH, samples))
        for name, test in TESTS.items():
            p_values = test(errors, bins)
            for level in LEVELS:
                below[name, level] += int((p_values < level).sum())
    total = batches * BATCH
    for (name, level), count in below.items():
        rate = count / total
        error = (level * (1.0 - level) / total) ** 0.5
        yield Rate(law, samples, bins, name, level, rate, error, (rate - level) / error)


def main() -> None:
    """Repeat, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=2020)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "benchmarks" / "results")
    args = parser.parse_args()
    cases = [("normal", *case) for case in CASES]
    cases += [(law, *OTHER_LAWS_AT) for law in LAWS if law != "normal"]
    found = [rate for case in cases for rate in rates(*case, args.repetitions, args.seed)]
    args.output.mkdir(parents=True, exist_ok=True)
    write_csv(args.output / "normality_level.csv", found)
    print_columns([Rate._fields], found)


if __name__ == "__main__":
    sys.exit(main())
