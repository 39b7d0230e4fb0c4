"""Samples of a study: parameters that vary together, case by case."""

import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Quantity
from escapement.base.validate import known_keys
from escapement.mechanisms.protocol import FloatArray
from escapement.study.parse.columns import MOST_VALUES, NEVER, axis_values, drawn_within

METHODS = ("random", "latin-hypercube", "sobol", "list")
_DRAWS = ("hypercubes", "correlations")


def sample_columns(
    table: Mapping[str, Any], parameters: Mapping[str, Quantity], nominal: Mapping[str, Any]
) -> tuple[dict[str, NDArray[Any]], dict[str, Any], str]:
    """The columns of a [sample] table.

    Parameters
    ----------
    table : Mapping
        `method`, `size`, `seed`, and a distribution (or with "list" the values) of
        each parameter.
    parameters : Mapping
        What can be sampled.
    nominal : Mapping
        Fixed values, around which distributions with a width lie.

    Returns
    -------
    columns : dict of ndarray, shape (size,)
        Values of each parameter in the units of the table.
    plain : dict
        The table as JSON can hold it, seed included.
    fingerprint : str
        Fingerprint of the numbers drawn, "" for a list: another version of SciPy may draw other
        numbers from the same seed.

    Raises
    ------
    InvalidValue
        For an unknown key, or a value that breaks its rule.
    """
    known_keys(table, ("method", "size", "seed", *_DRAWS, *parameters), "in [sample]")
    method = validate.choice("sample.method", table.get("method"), METHODS)
    forms = {name: form for name, form in table.items() if name in parameters}
    if not forms:
        raise InvalidValue(
            "the sample must vary at least one parameter, got none; add one under [sample], "
            'for example friction = { tolerance = 0.02 }, or with method "list" [0.2, 0.3]'
        )
    plain: dict[str, Any] = {"method": method}
    fingerprint = ""
    if method == "list":
        known_keys(table, ("method", *parameters), 'in [sample] with method "list"')
        found = {name: axis_values(form, parameters[name]) for name, form in forms.items()}
    else:
        size, seed = _size(method, table), table.get("seed", 0)
        seed = validate.integer("sample.seed", seed, 0, "leave it out for 0")
        plain |= {"size": size, "seed": seed}
        if "hypercubes" in table:
            plain["hypercubes"] = _hypercubes(method, size, table["hypercubes"])
        shares = unit_cube(method, size, len(forms), seed, plain.get("hypercubes", 1))
        if "correlations" in table:
            plain["correlations"] = pairs = _pairs(table["correlations"], [*forms])
            shares = _correlated(shares, pairs, [*forms])
        fingerprint = f"{zlib.crc32(shares.tobytes()):08x}"
        # the order of the parameters decides which coordinate of the points each one gets
        found = {
            name: drawn_within(form, parameters[name], nominal.get(name), share)
            for share, (name, form) in zip(shares, forms.items(), strict=True)
        }
    columns = {name: values for name, (values, _) in found.items()}
    first, *others = columns
    for name in others:
        if columns[name].size != columns[first].size:
            raise InvalidValue(
                f"sample.{name} must have as many values as {first}, got {columns[name].size} and "
                f"{columns[first].size}; give every case a value of each"
            )
    return columns, plain | {name: form for name, (_, form) in found.items()}, fingerprint


def _size(method: str, table: Mapping[str, Any]) -> int:
    remedy = "give the number of cases"
    size = validate.integer("sample.size", table.get("size"), 1, remedy, MOST_VALUES)
    if method == "sobol" and size & (size - 1):
        below = 1 << (size.bit_length() - 1)
        remedy = f"only then its points are evenly spread: give {below} or {2 * below}"
        raise validate.fail("sample.size", "a power of two with method 'sobol'", size, remedy)
    return size


def _hypercubes(method: str, size: int, given: Any) -> int:
    count = validate.integer("sample.hypercubes", given, 1, "leave it out for one")
    if method != "latin-hypercube" or size % count:
        rule = "left out, or with method 'latin-hypercube' a divisor of the size"
        raise validate.fail("sample.hypercubes", rule, given, "give for example 10")
    return count


def _pairs(given: Any, names: list[str]) -> list[list[Any]]:
    """Correlations as lists of two parameters and a number."""
    rule, remedy = "a list of pairs with a number", 'write [["friction", "torque", 0.5]]'
    try:
        pairs: list[list[Any]] = [[str(a), str(b), float(r)] for a, b, r in given]
    except (TypeError, ValueError):
        raise validate.fail("sample.correlations", rule, given, remedy) from None
    for one, two, r in pairs:
        if not {one, two} <= {*names} or one == two or not -1.0 < r < 1.0:
            rule = "between two parameters of the sample, and between -1 and 1"
            raise validate.fail("sample.correlations", rule, [one, two, r], remedy)
    return pairs


def correlation_matrix(pairs: list[list[Any]], names: list[str]) -> FloatArray:
    """The matrix of correlations between parameters; those that are not given are 0.

    Raises
    ------
    InvalidValue
        When no distribution has all these correlations.
    """
    matrix = np.eye(len(names))
    for one, two, r in pairs:
        i, j = names.index(one), names.index(two)
        matrix[i, j] = matrix[j, i] = r
    if np.linalg.eigvalsh(matrix)[0] <= 0.0:
        rule, remedy = "possible together", "make some of them smaller"
        raise validate.fail("sample.correlations", rule, pairs, remedy)
    return matrix


def _correlated(shares: FloatArray, pairs: list[list[Any]], names: list[str]) -> FloatArray:
    """Shares whose normal scores have the correlations; the distribution of each is unchanged."""
    from scipy.special import ndtr, ndtri

    scores = ndtri(np.clip(shares, NEVER, 1.0 - NEVER))
    return np.asarray(ndtr(np.linalg.cholesky(correlation_matrix(pairs, names)) @ scores))


def unit_cube(method: str, size: int, count: int, seed: int, hypercubes: int = 1) -> FloatArray:
    """Points of a sample in the unit cube, shape (count, size)."""
    from scipy.stats import qmc

    random = np.random.default_rng(seed)
    if method == "random":
        return random.random((count, size))
    kind = {"latin-hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}[method]
    # each hypercube continues the sequence of random numbers of the one before
    drawn = [kind(count, seed=random).random(size // hypercubes) for _ in range(hypercubes)]
    return np.ascontiguousarray(np.concatenate(drawn).T)
