"""Why a printed figure differs from a computed one, decided by recomputing.

A cause is named only where the recomputation that has it meets the printed
figure better than the one that lacks it; no list of rows is kept.
"""

import math
from collections.abc import Mapping, Sequence

from escapement.sources.meyer.listing import ROW
from escapement.sources.meyer.program import program_1973, read_printout, stretches

RunFigures = Mapping[str, float | None]
"""velocity_max, velocity_min [rad/s], rise_time and period [s]; None for none."""
RunArguments = tuple[int, float, float, float, float]
"""Arguments of `program_1973`: slots, friction, torque, inertias."""

HALF_DIGIT = {"velocity_max": 0.5, "velocity_min": 0.5, "rise_time": 5e-4, "period": 5e-4}
"""Half a unit of the last printed digit [rad/s] and [s]."""
_CYCLE = (
    "velocity_max",
    "velocity_min",
    "period",
)  # rise times were read by eye
_SHOWN = {"velocity_max": "{:.1f} rad/s", "velocity_min": "{:.1f} rad/s", "period": "{:.4f} s"}
_FINE = 50  # so many rows for each printed one show a peak before sampling cuts it


def distance(first: RunFigures, second: RunFigures, name: str) -> float:
    """Difference of one figure in half digits; infinite where one is missing."""
    a, b = first[name], second[name]
    return math.inf if a is None or b is None else abs(a - b) / HALF_DIGIT[name]


def why_inertias(
    printed: RunFigures, used: RunFigures, headed: RunFigures, inertias: str
) -> list[str]:
    """Inertias of a table's heading against those of the thesis' figures.

    `used` and `headed` are solved with the one and the other.
    """
    with_heading = max(distance(printed, headed, name) for name in _CYCLE)
    with_used = max(distance(printed, used, name) for name in _CYCLE)
    if with_heading <= max(1.0, with_used):
        return []
    return [
        f"the heading swaps the inertias: the table is met with {inertias}, while the heading's "
        f"give {_list(headed, _CYCLE)}"
    ]


def why_cell(
    printed: RunFigures, exact: RunFigures, true: RunFigures, cell_deg: float
) -> list[str]:
    """90-degree cell against the real one of `cell_deg`."""
    names = [
        name
        for name in _CYCLE
        if distance(printed, true, name) > 1.0
        and distance(printed, exact, name) < distance(printed, true, name)
        and distance(exact, true, name) > 1.0  # the solver's noise must not decide
    ]
    if not names:
        return []
    return [
        f"the program hard-codes a 90-degree cell instead of {cell_deg:.0f}: it gives "
        f"{_list(exact, names)}, the real mechanism {_list(true, names)}"
    ]


def why_extremes(printed: RunFigures, exact: RunFigures, run: RunArguments) -> list[str]:
    """Peaks and troughs that fall between rows, and what the listing does to them."""
    return [
        _why_extreme(name, printed[name], exact[name], run)  # type: ignore[arg-type]
        for name in ("velocity_max", "velocity_min")
        if 1.0 < distance(printed, exact, name) < math.inf
    ]


def _why_extreme(name: str, shown: float, value: float, run: RunArguments) -> str:
    lowest, highest = _row_range(name, run)
    half = HALF_DIGIT[name]
    rows = f"rows of the listing show it as {lowest:.2f} to {highest:.2f}"
    if not lowest - half <= shown <= highest + half:
        return f"unexplained: {name} is {value:.2f} rad/s, and {rows}"
    if (shown < value) is (name == "velocity_max"):
        return f"the 0.5 ms print step misses the {name} of {value:.2f} rad/s: {rows}"
    return (
        "the friction sign is that of the acceleration 50 us earlier, which moves the "
        f"{name} of {value:.2f} rad/s: {rows}"
    )


def _row_range(name: str, run: RunArguments) -> tuple[float, float]:
    """Least and greatest value an extreme row can have, over all phases of the rows."""
    fine = program_1973(*run, interval=ROW / _FINE)
    reading = read_printout(fine)
    level = 0.5 * (reading.velocity_max + reading.velocity_min)
    if name == "velocity_max":
        peak = stretches(fine.theta_dot, level)[-1]
        rows = [peak[phase::_FINE].max() for phase in range(_FINE)]
    else:
        trough = stretches(-fine.theta_dot, -level)[-1]
        rows = [-trough[phase::_FINE].max() for phase in range(_FINE)]
    return float(min(rows)), float(max(rows))


def why_times(printed: RunFigures, exact: RunFigures) -> list[str]:
    """Times read off the table by hand."""
    reasons = []
    if distance(printed, exact, "period") > 2.0:
        reasons.append(f"unexplained: period recomputes to {exact['period']:.4f} s")
    elif distance(printed, exact, "period") > 1.0:
        reasons.append(
            f"the period of {exact['period']:.4f} s was read between rows 0.5 ms apart and rounded"
        )
    return reasons + _why_rise_time(printed, exact)


def _why_rise_time(printed: RunFigures, exact: RunFigures) -> list[str]:
    if distance(printed, exact, "rise_time") <= 1.0:
        return []
    shown, rise, period = printed["rise_time"], exact["rise_time"], exact["period"]
    if shown is None or rise is None or period is None:
        return ["the rise time was read by eye: no extremum meets the 2 % rule"]
    reach = "within half a period" if abs(shown - rise) <= period / 2.0 else "another extremum"
    return [f"the rise time was read by eye ({reach}): the 2 % rule gives {rise:.4f} s"]


def _list(figures: RunFigures, names: Sequence[str]) -> str:
    return ", ".join(
        f"{name} none" if figures[name] is None else f"{name} {_SHOWN[name].format(figures[name])}"
        for name in names
    )
