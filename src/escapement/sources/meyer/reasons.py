"""Why a printed figure differs from a recomputed one, decided by recomputing.

A cause is named only if the recomputation with it is closer to the printed figure than the one
without it; no list of rows is kept.
"""

import math
from collections.abc import Iterable, Iterator, Mapping

from escapement.mechanisms import Geneva
from escapement.sources.meyer.listing import ROW
from escapement.sources.meyer.program import program_1973, read_printout, stretches

RunFigures = Mapping[str, float]
"""velocity_max, velocity_min [rad/s], rise_time and period [s]."""
RunArguments = tuple[int, float, float, float, float]
"""Arguments of `program_1973`: slots, friction, torque, inertias."""

HALF_DIGIT = {"velocity_max": 0.5, "velocity_min": 0.5, "rise_time": 5e-4, "period": 5e-4}
"""Half a unit of the last printed digit [rad/s] and [s]."""
# rise times were read by eye
_SHOWN = {"velocity_max": "{:.1f} rad/s", "velocity_min": "{:.1f} rad/s", "period": "{:.4f} s"}
_FINE = 50  # number of rows for each printed one, enough to show a peak without sampling


def why(
    printed: RunFigures, exact: RunFigures, true: RunFigures, headed: RunFigures, run: RunArguments
) -> Iterator[str]:
    """Explanations of errors of more than half a printed digit, a sentence for each cause.

    exact, headed : solved in the cell of 90 degrees, with the inertias of the thesis' figures
        and with those of the table's heading.
    true : the real mechanism.
    run : inputs of the listing.
    """
    # rise times do not count, because they were read by eye
    heading, used = (max(distance(printed, it, name) for name in _SHOWN) for it in (headed, exact))
    if heading > max(1.0, used):
        yield (
            f"the heading swaps the inertias: the table is met with driver {run[3]:g} and "
            f"follower {run[4]:g} in-lbf-s², while the heading's give {_list(headed, _SHOWN)}"
        )
    of_cell = [
        name
        for name in _SHOWN
        if distance(printed, true, name) > max(1.0, distance(printed, exact, name))
        and distance(exact, true, name) > 1.0  # the solver's noise must not decide
    ]
    if of_cell:
        yield (
            "the program hard-codes a 90-degree cell instead of "
            f"{math.degrees(Geneva(run[0]).cell_angle):.0f}: it gives {_list(exact, of_cell)}, "
            f"the true cell {_list(true, of_cell)}"
        )
    for name in ("velocity_max", "velocity_min"):
        if distance(printed, exact, name) > 1.0:
            yield _why_extreme(name, printed[name], exact[name], run)
    # times were read off the table by hand
    rise, period = exact["rise_time"], exact["period"]
    off = distance(printed, exact, "period")
    if off > 2.0:
        yield f"unexplained: period recomputes to {period:.4f} s"
    elif off > 1.0:
        yield f"the period of {period:.4f} s was read between rows 0.5 ms apart and rounded"
    if distance(printed, exact, "rise_time") > 1.0:
        near = abs(printed["rise_time"] - rise) <= period / 2.0
        reach = "within half a period" if near else "another extremum"
        yield f"the rise time was read by eye ({reach}): the 2 % rule gives {rise:.4f} s"


def distance(first: RunFigures, second: RunFigures, name: str) -> float:
    """Difference of one figure in half digits."""
    return abs(first[name] - second[name]) / HALF_DIGIT[name]


def _why_extreme(name: str, shown: float, value: float, run: RunArguments) -> str:
    """Why a printed extreme differs, from the values that its row can have."""
    fine = program_1973(*run, interval=ROW / _FINE)
    reading = read_printout(fine)
    # a minimum is a maximum of the negative speed
    sign = 1.0 if name == "velocity_max" else -1.0
    level = 0.5 * (reading.velocity_max + reading.velocity_min)
    peak = stretches(sign * fine.theta_dot, sign * level)[-1]
    # over all phases of the rows
    found = [sign * float(peak[phase::_FINE].max()) for phase in range(_FINE)]
    rows = f"rows of the listing show it as {min(found):.2f} to {max(found):.2f}"
    # the printed number was itself rounded
    if not min(found) - HALF_DIGIT[name] <= shown <= max(found) + HALF_DIGIT[name]:
        return f"unexplained: {name} is {value:.2f} rad/s, and {rows}"
    if (shown < value) is (name == "velocity_max"):
        return f"the 0.5 ms print step misses the {name} of {value:.2f} rad/s: {rows}"
    return (
        "the friction sign is that of the acceleration 50 us earlier, which moves the "
        f"{name} of {value:.2f} rad/s: {rows}"
    )


def _list(figures: RunFigures, names: Iterable[str]) -> str:
    return ", ".join(f"{name} {_SHOWN[name].format(figures[name])}" for name in names)
