"""Results of cases of indexing drives: those of one mechanism at once."""

import contextlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.constant_speed.index_record import in_si
from escapement.constant_speed.index_rows import IndexRows
from escapement.mechanisms.protocol import dwell_angle
from escapement.mechanisms.wheel_checks import LENGTHS
from escapement.study.plan import StudyPlan


def evaluate_drives(plan: StudyPlan, cases: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    """Results of cases in SI, angles in rad; a bad case never ends the study."""
    columns = plan.columns(cases)
    found = {name: np.full(cases.size, np.nan) for name in plan.results if name != "status"}
    status = np.full(cases.size, Status.INVALID, dtype=np.uint8)
    # the path of a pin does not depend on its width
    machine = [name for name in columns if plan.parameters[name].section == "mechanism"]
    key = [columns[name] for name in machine if name not in LENGTHS]
    which = np.zeros(cases.size, dtype=int)
    if key:
        which = np.unique(np.column_stack(key), axis=0, return_inverse=True)[1].reshape(-1)
    for group in range(int(which.max()) + 1):
        rows = np.flatnonzero(which == group)
        # a mechanism that cannot be built must not end the study
        with contextlib.suppress(InvalidValue):
            _fill(plan, cases, rows, found, status)
    return found | {"status": status}


def _fill(
    plan: StudyPlan, cases: NDArray[np.int64], rows: NDArray[np.intp], found: dict[str, Any],
    status: NDArray[np.uint8],
) -> None:  # fmt: skip
    """Fill the results of cases of one mechanism."""
    mechanism = plan.mechanism(int(cases[rows[0]]), ideal=True)
    columns = plan.columns(cases[rows])
    numbers = plan.fixed_si | plan.lengths | columns
    good = _possible(mechanism, numbers, rows.size)
    rows, columns = rows[good], {name: column[good] for name, column in columns.items()}
    if not rows.size:
        return
    with np.errstate(all="ignore"):  # the status reports numbers out of range
        drives = IndexRows(mechanism, numbers | columns, rows.size)
        for name, values in found.items():
            values[rows] = in_si(drives, name)
        sound = np.isfinite(drives.torque_rms) & np.isfinite(drives.torque_max)
    status[rows[sound]] = Status.OK
    for values in found.values():
        values[rows[~sound]] = np.nan


def _possible(mechanism: Any, numbers: dict[str, Any], count: int) -> NDArray[np.bool_]:
    """Whether sizes of pins fit their wheel, and whether a drive comes to rest if it must."""
    given = [numbers.get(name) for name in LENGTHS]
    crank, pin, roller, gap = (np.asarray(0.0 if x is None else x, dtype=float) for x in given)
    outer = np.where(roller > 0.0, roller, pin)
    fits = (roller == 0.0) | ((pin > 0.0) & (pin < roller))
    wide = outer + 0.5 * gap
    widest = np.where(crank > 0.0, crank, 1.0) * mechanism.widest_pin
    fits = fits & ((wide == 0.0) | (wide < widest))
    if not mechanism.takes_clearance:
        fits = fits & (gap == 0.0)
    if not dwell_angle(mechanism) > 0.0:
        fits = fits & (gap == 0.0) & (np.asarray(numbers["load_frequency"]) == 0.0)
    return np.broadcast_to(fits, count)
