"""A few cases of a study, so that its result can be seen at once."""

from os import PathLike
from typing import TYPE_CHECKING, Any

from escapement.status import Status
from escapement.units import factor

if TYPE_CHECKING:
    from escapement.study.plan import StudyPlan

ROWS = 12
RESULTS = ("velocity_max", "velocity_min", "velocity_mean", "period", "rise_time")


def some_cases(
    plan: "StudyPlan", path: str | PathLike[str], units: str | None
) -> list[dict[str, Any]]:
    """At most a dozen cases of a study file, spread evenly over every dimension.

    Only those are read, however large the file. Parameters are in `units`, or in the
    study's where that is None.
    """
    import h5py

    places = spread(plan.shape, ROWS)
    numbers = {name: {name: values} for name, values in plan.dimensions.items()}
    if plan.sample is not None:
        numbers[[*numbers][-1]] |= plan.sample.values
    with h5py.File(path, "r") as hdf5:
        cases = []
        for place in places:
            case = {
                name: values[i].item() * _scale(plan, name, units)
                for along, i in zip(numbers.values(), place, strict=True)
                for name, values in along.items()
            }
            case |= {name: float(hdf5[name][place]) for name in RESULTS}
            cases.append(case | {"status": Status(int(hdf5["status"][place])).label})
    return cases


def _scale(plan: "StudyPlan", name: str, units: str | None) -> float:
    """Factor from the study's units of a parameter to `units`."""
    if units in (None, plan.unit_system) or name not in plan.parameters:
        return 1  # a whole number stays whole
    quantity = plan.parameters[name].quantity
    return factor(quantity, plan.unit_system) / factor(quantity, units)


def spread(shape: tuple[int, ...], most: int) -> list[tuple[int, ...]]:
    """At most `most` grid places: the ends of every axis, then places between them."""
    import itertools
    import math

    counts = list(shape)
    while math.prod(counts) > most:
        counts[counts.index(max(counts))] -= 1
    picks = [_evenly(size, count) for size, count in zip(shape, counts, strict=True)]
    return list(itertools.product(*picks))


def _evenly(size: int, count: int) -> list[int]:
    """`count` of the indices of an axis, both ends among them; of one, the middle."""
    if count == 1:
        return [size // 2]
    return [round(i * (size - 1) / (count - 1)) for i in range(count)]
