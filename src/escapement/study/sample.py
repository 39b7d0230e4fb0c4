"""A sample: parameters that vary together, drawn at random or listed case by case."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement import validate
from escapement.errors import InvalidValue
from escapement.model import FloatArray
from escapement.quantity import Quantity
from escapement.study.axes import MOST_VALUES, axis_values
from escapement.study.spread import Spread, parse_spread
from escapement.validate import known_keys

CASE = "case"
"""Name of the dimension along which a sample varies."""

METHODS = ("latin-hypercube", "sobol", "list")
_SETTINGS = ("method", "size", "seed")
_SIZE = "give the number of cases"


@dataclass(frozen=True, eq=False)
class Sample:
    """Cases of parameters that vary together.

    values : of every parameter, shape (size,), in the user's units.
    form : as the configuration states it, seed included.
    around : names of the parameters spread around their fixed values.
    fingerprint : of the numbers drawn, "" for a list: another version of SciPy may
        draw others of the same seed.
    """

    values: dict[str, NDArray[Any]]
    form: dict[str, Any]
    around: frozenset[str] = frozenset()
    fingerprint: str = ""

    @property
    def size(self) -> int:
        """Number of cases."""
        return next(iter(self.values.values())).size


def parse_sample(
    table: Mapping[str, Any], parameters: Mapping[str, Quantity], fixed: Mapping[str, float]
) -> Sample:
    """The sample that a [sample] table asks for.

    Parameters
    ----------
    table : Mapping
        `method`, `size`, `seed`, and a distribution (or with "list" the values) of
        each parameter.
    parameters : Mapping
        What can be sampled.
    fixed : Mapping
        Nominal values.

    Raises
    ------
    InvalidValue
        For an unknown key, or a value that breaks its rule.
    """
    known_keys(table, (*_SETTINGS, *parameters), "in [sample]")
    if "method" not in table:
        raise InvalidValue(f"the sample lacks a method; give one of {', '.join(METHODS)}")
    method = validate.choice("sample.method", table["method"], METHODS)
    forms = {name: form for name, form in table.items() if name not in _SETTINGS}
    if not forms:
        raise InvalidValue(
            "the sample must vary at least one parameter, got none; add one under [sample], "
            + ("for example friction = [0.2, 0.3]" if method == "list" else
               "for example friction = { tolerance = 0.02 }")
        )  # fmt: skip
    if method == "list":
        return _listed(table, forms, parameters)
    size, seed = _size(method, table), _seed(table)
    spreads = {
        name: parse_spread(name, form, parameters[name], fixed.get(name))
        for name, form in forms.items()
    }
    return _drawn(method, size, seed, spreads, parameters)


def _listed(
    table: Mapping[str, Any], forms: Mapping[str, Any], parameters: Mapping[str, Quantity]
) -> Sample:
    """Values given case by case."""
    for key in ("size", "seed"):
        if key in table:
            raise validate.fail(
                f"sample.{key}", 'left out with method "list"', table[key], "the lists say it all"
            )
    parsed = {name: axis_values(name, form, parameters[name]) for name, form in forms.items()}
    sizes = {name: values.size for name, (values, _) in parsed.items()}
    first, size = next(iter(sizes.items()))
    for name, other in sizes.items():
        if other != size:
            raise InvalidValue(
                f"sample.{name} must have as many values as {first}, got {other} and {size}; "
                "give every case a value of each"
            )
    plain = {name: form for name, (_, form) in parsed.items()}
    return Sample({name: v for name, (v, _) in parsed.items()}, {"method": "list"} | plain)


def _size(method: str, table: Mapping[str, Any]) -> int:
    if "size" not in table:
        raise InvalidValue(f"the sample lacks size; {_SIZE}")
    size = validate.integer("sample.size", table["size"], 1, _SIZE)
    if size > MOST_VALUES:
        raise validate.fail("sample.size", f"at most {MOST_VALUES}", size, "split the study")
    if method == "sobol" and size & (size - 1):
        below = 1 << (size.bit_length() - 1)
        nearest = [str(power) for power in (below, 2 * below) if power <= MOST_VALUES]
        raise InvalidValue(
            f"sample.size must be a power of two with method 'sobol', whose points are even only "
            f"then, got {size}; give {' or '.join(nearest)}, or use 'latin-hypercube'"
        )
    return size


def _seed(table: Mapping[str, Any]) -> int:
    remedy = "leave it out for 0"
    seed = validate.integer("sample.seed", table.get("seed", 0), 0, remedy)
    if seed >= 2**63:
        raise validate.fail("sample.seed", "below 2^63", seed, remedy)
    return seed


def _drawn(
    method: str,
    size: int,
    seed: int,
    spreads: Mapping[str, Spread],
    parameters: Mapping[str, Quantity],
) -> Sample:
    """Values drawn at random, evenly over all parameters at once."""
    shares = _unit_cube(method, size, len(spreads), seed)
    values = {}
    for (name, spread), share in zip(spreads.items(), shares, strict=True):
        values[name] = spread.at(share)
        _check_drawn(name, values[name], parameters[name])
    form = {"method": method, "size": size, "seed": seed}
    return Sample(
        values,
        form | {name: spread.form for name, spread in spreads.items()},
        frozenset(name for name, spread in spreads.items() if spread.around),
        f"{zlib.crc32(shares.tobytes()):08x}",
    )


def _unit_cube(method: str, size: int, count: int, seed: int) -> FloatArray:
    """Points in the unit cube, shape (count, size)."""
    from scipy.stats import qmc

    kind = {"latin-hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}[method]
    points = kind(count, seed=np.random.default_rng(seed)).random(size)
    return np.ascontiguousarray(points.T)


def _check_drawn(name: str, values: FloatArray, parameter: Quantity) -> None:
    """Refuse a normal distribution that reaches where its parameter must not be."""
    try:
        parameter.read_all(f"sample.{name}", values)
    except InvalidValue as error:
        rule = str(error).partition(";")[0]
        raise InvalidValue(f"{rule}; cut its distribution off with low or high") from None
