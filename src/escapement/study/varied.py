"""What varies in a study: axes, and samples whose parameters vary together.

Each parameter becomes a column of values in the user's units, and plain JSON from which the same
column can be made again.
"""

import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Quantity
from escapement.base.validate import known_keys
from escapement.mechanisms.protocol import FloatArray

CASE = "case"
"""Name of the dimension along which a sample varies."""
MOST_VALUES = 10_000_000
METHODS = ("random", "latin-hypercube", "sobol", "list")

_DRAWS = ("hypercubes", "correlations")

_ENDS = ("low", "high")
_BESIDE = {
    "": (*_ENDS, "log"),
    "tolerance": (),
    "relative_tolerance": (),
    "standard_deviation": _ENDS,
    "relative_standard_deviation": _ENDS,
    "log_standard_deviation": _ENDS,
}
"""Keys of a distribution besides that of its width; a distribution without a width has ends."""
WIDTHS = frozenset(_BESIDE) - {""}
"""Keys of a distribution that lies around the nominal value."""
_NEVER = 1e-10  # share of a normal distribution at either side that no draw reaches

Column = tuple[NDArray[Any], Any]


def axis_values(form: Any, parameter: Quantity) -> Column:
    """Values of one axis and its form as plain JSON.

    Parameters
    ----------
    form : number, text with a unit, sequence, one-dimensional array or mapping
        A mapping holds `start`, `stop` and `num`, and may hold `log`: true for equal
        ratios instead of equal differences.
    parameter : Quantity
        The rule every value obeys.

    Returns
    -------
    values : ndarray, shape (n,), float64 or (whole numbers) int64
        In the units of the form.
    plain : list or dict
        The same axis as JSON can hold it.

    Raises
    ------
    InvalidValue
        For an empty axis, or a value that is not a number or breaks the rule.
    """
    if isinstance(form, Mapping):
        return _even_values(form, parameter)
    name = parameter.name
    # asanyarray keeps a mask, whose values become None and are refused one by one
    items = form if isinstance(form, list | tuple) else np.asanyarray(form).tolist()
    if not isinstance(items, list | tuple):
        items = [items]
    if not items:
        raise InvalidValue(f"{name} must have at least one value, got an empty axis; give a list")
    numbers = [parameter.read(f"{name}[{i}]", item) for i, item in enumerate(items)]
    values = parameter.read_all(name, np.array(numbers, dtype=float))
    return values, values.tolist()


def _even_values(form: Mapping[str, Any], parameter: Quantity) -> Column:
    """Values at equal differences, or with `log` at equal ratios."""
    name = parameter.name
    known_keys(form, ("start", "stop", "num", "log"), f"in axis {name}")
    start, stop = (parameter.read(f"{name}.{end}", form.get(end)) for end in ("start", "stop"))
    fewest = 1 if start == stop else 2
    remedy = "give the number of values, both ends included"
    num = validate.integer(f"{name}.num", form.get("num"), fewest, remedy, MOST_VALUES)
    plain = {"start": start, "stop": stop, "num": num}
    if not validate.truth(f"{name}.log", form.get("log", False)):
        return parameter.read_all(name, np.linspace(start, stop, num)), plain
    for end in ("start", "stop"):
        validate.positive(f"{name}.{end}", plain[end], "a logarithmic axis cannot reach 0")
    values = np.geomspace(start, stop, num)
    if parameter.whole:
        # geomspace misses powers of two by a rounding error
        nearest = np.rint(values)
        values = np.where(np.isclose(values, nearest, rtol=1e-12), nearest, values)
    return parameter.read_all(name, values), plain | {"log": True}


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
            name: _drawn(form, parameters[name], nominal.get(name), share)
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

    scores = ndtri(np.clip(shares, _NEVER, 1.0 - _NEVER))
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


def drawn_values(
    form: Any, parameter: Quantity, nominal: float | None, share: FloatArray
) -> NDArray[Any]:
    """Values below which the given shares of a distribution lie, of which some may break a rule."""
    return _distributed(form, parameter, nominal, share)[0]


def _drawn(form: Any, parameter: Quantity, nominal: float | None, share: FloatArray) -> Column:
    """Values below which the given shares (0 to 1) of a distribution lie, and its form."""
    values, plain = _distributed(form, parameter, nominal, share)
    cut = replace(parameter, remedy="cut its distribution off with low or high")
    return cut.read_all(f"sample.{parameter.name}", values), plain


def _distributed(
    form: Any, parameter: Quantity, nominal: float | None, share: FloatArray
) -> Column:
    """As `_drawn`, without the check of the values."""
    label = f"sample.{parameter.name}"
    if parameter.whole or parameter.fraction:
        raise InvalidValue(
            f"{label} must be left out, whole numbers and fractions cannot be drawn at random; "
            f'write {parameter.name} in [sweep], or use method = "list"'
        )
    if not isinstance(form, Mapping):
        remedy = "write for example { relative_tolerance = 0.05 }"
        raise validate.fail(label, "a table that says how it varies", form, remedy)
    known_keys(form, (*_BESIDE[""], *WIDTHS), f"in {label}")
    width = next((key for key in _BESIDE if key in form), "")
    known_keys(form, (width, *_BESIDE[width]), f"in {label} with {width or 'two ends'}")
    if width:
        return _around(form, width, parameter, nominal, share)
    return _between(form, parameter, share)


def _between(form: Mapping[str, Any], parameter: Quantity, share: FloatArray) -> Column:
    """A uniform distribution between two ends, or one whose logarithm is uniform."""
    label = f"sample.{parameter.name}"
    low, high = (parameter.read(f"{label}.{end}", form.get(end)) for end in _ENDS)
    if not low < high:
        raise validate.fail(f"{label}.high", f"greater than low = {low:g}", high, "exchange them")
    plain = {"low": low, "high": high}
    if not validate.truth(f"{label}.log", form.get("log", False)):
        return np.clip(low + share * (high - low), low, high), plain
    validate.positive(f"{label}.low", low, "a logarithmic spread cannot reach 0")
    return np.clip(low * (high / low) ** share, low, high), plain | {"log": True}


def _around(
    form: Mapping[str, Any], key: str, parameter: Quantity, nominal: float | None, share: FloatArray
) -> Column:
    """A distribution around the nominal value, uniform or normal."""
    label = f"sample.{parameter.name}"
    if nominal is None:
        raise InvalidValue(
            f"{label} must have a nominal value to spread around, got none; "
            f"give {parameter.label} a fixed value, or {label} low and high"
        )
    log, remedy = key.startswith("log"), "a parameter without one stays fixed"
    relative = key.startswith("relative")
    kind = "ratio" if relative or log else parameter.unit
    given = units.measured(f"{label}.{key}", form[key], kind, parameter.system, remedy)
    given = validate.positive(f"{label}.{key}", given, remedy)
    width = given * nominal if relative else given
    if width == 0.0:
        raise InvalidValue(
            f"{label}.{key} must be a part of a nominal value other than 0, got 0; "
            f"give {key.removeprefix('relative_')} in its own unit"
        )
    if key.endswith("tolerance"):
        low = parameter.read(f"the lowest value of {label}", nominal - width)
        high = parameter.read(f"the highest value of {label}", nominal + width)
        return np.clip(low + share * (high - low), low, high), {key: given}
    ends = {end: parameter.read(f"{label}.{end}", form[end]) for end in _ENDS if end in form}
    low, high = ends.get("low", -np.inf), ends.get("high", np.inf)
    if not low <= nominal <= high:
        raise InvalidValue(
            f"{label} must have its nominal value between low and high, got {nominal:g}; "
            "move the end beyond it"
        )
    from scipy.special import ndtr, ndtri

    if log:
        with np.errstate(divide="ignore", invalid="ignore"):
            nominal, low, high = np.log([nominal, max(low, 0.0), high])
        validate.positive(
            f"the nominal value of {label}", float(np.exp(nominal)), "it has a logarithm"
        )
        width = given
    # truncnorm has the same distribution, but other bits than files of the same seed hold
    below, up_to = (ndtr((end - nominal) / width) for end in (low, high))
    # a share of exactly 0 or 1 would be infinitely far away
    inside = np.clip(below + share * (up_to - below), _NEVER, 1.0 - _NEVER)
    values = np.clip(nominal + width * ndtri(inside), low, high)
    return np.exp(values) if log else values, {key: given} | ends
