"""Meyer's program of 1973 as printed, its mistakes and its sampling included.

The listing (thesis, Appendix B) is in MIMIC, a language whose statements form a
differential equation and whose run time integrates it. Everything that shaped
the printed tables is kept: the cell of 1.5708 rad for every mechanism, pi =
3.1416, a friction sign taken from the acceleration 50 us earlier, and a table of one row per 0.5
ms. For the motion itself use `escapement.simulate`; this file exists to explain the printed
numbers.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.mechanisms import Geneva
from escapement.mechanisms.kind import cells_of
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray, Mechanism
from escapement.mechanisms.slotted import Transmission, transmission
from escapement.sources.meyer.listing import CELL, PI, ROW, run_listing

# X0 by slots. The data cards are not printed; rounding them to three decimals
# would change the six-slot maxima by 0.1 rad/s, too little to decide
_ENTRY = {3: -PI / 6.0, 4: -PI / 4.0, 6: -PI / 3.0}


@dataclass(frozen=True)
class PublishedCell(Mechanism):
    """A Geneva wheel in the 90-degree cell Meyer's listing gives all of them, as a mechanism.

    The pin enters at the right place, -pi/pins, and is replaced by the next one 90 degrees later,
    independently of the follower. This is a real mechanism only for 4 slots. With 3 slots the pin
    stays past its exit and the transmission turns negative; with 6 slots it leaves early; in both
    the transmission jumps at the handoff while the driver's speed does not, so energy jumps
    there.

    Parameters
    ----------
    slots : int
        3, 4 or 6.

    Source: Meyer (1973), Appendix B, card X.
    """

    slots: int = field()
    cell_angle = math.pi / 2.0
    """90 degrees [rad]."""

    def __post_init__(self) -> None:
        if self.slots not in _ENTRY:
            raise validate.fail("slots", "3, 4 or 6", self.slots, "use Geneva for other wheels")

    @cached_property
    def geneva(self) -> Geneva:
        """The real mechanism."""
        return Geneva(self.slots)

    @property
    def breaks(self) -> tuple[float, float, float]:
        """Pin entry, dead centre and end of the cell [rad]."""
        entry = self.geneva.breaks[0]
        return entry, 0.0, entry + self.cell_angle

    @property
    def follower_step(self) -> float:
        """Net turn of the follower over the cell [rad]."""
        # the pin neither enters nor leaves where this cell ends, except with 4 slots
        return float(np.diff(self.geneva.direction(self.breaks[::2]))[0])

    @property
    def path(self) -> Path:
        """The pin path, as kernels evaluate it."""
        return self.geneva.path

    def transmission(self, theta: ArrayLike) -> Transmission:
        """Transmission at driver angles of any size from dead centre [rad]."""
        return transmission(self.path, cells_of(self, theta)[1])

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles of any size [rad], zero at dead centre (Meyer 1-6)."""
        cells, local = cells_of(self, theta)
        return cells * self.follower_step + self.geneva.direction(local)


class Printout(NamedTuple):
    """One run's table, arrays of one shape (rows,).

    time : [s].
    theta : driver angle from the start, not wrapped [rad] (DISPL).
    theta_dot, theta_ddot : driver speed and acceleration [rad/s, rad/s^2].
    phi_dot : follower speed [rad/s].
    """

    time: FloatArray
    theta: FloatArray
    theta_dot: FloatArray
    theta_ddot: FloatArray
    phi_dot: FloatArray

    def __repr__(self) -> str:
        return f"Printout({self.time.size} rows)"


class Reading(NamedTuple):
    """What a reader takes from a printout; NaN where the run is too short.

    velocity_max, velocity_min : terminal driver speeds [rad/s].
    rise_time, period : [s].
    peaks : every peak of the terminal part [rad/s], shape (peaks,).
    """

    velocity_max: float
    velocity_min: float
    rise_time: float
    period: float
    peaks: FloatArray


def program_1973(
    slots: int,
    friction: float,
    torque: float,
    driver_inertia: float,
    follower_inertia: float,
    duration: float = 0.2,
    interval: float = ROW,
) -> Printout:
    """Run the listing of Meyer (1973), Appendix B.

    Parameters
    ----------
    slots : int
        3, 4 or 6.
    friction : float
        Coefficient of friction [-], >= 0.
    torque, driver_inertia, follower_inertia : float
        In any consistent units, SI or inch-pound-second; only their ratios count.
    duration : float
        FIN, length of the run [s].
    interval : float
        Time between rows [s]. Shorter intervals show peaks that the printout misses; the delay of
        the friction sign stays at 50 us.

    Returns
    -------
    Printout
        t = 0 included.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule, or friction is at the Painleve limit
        and the listing breaks down.
    """
    if slots not in _ENTRY:
        raise validate.fail("slots", "3, 4 or 6", slots, "the listing has no other data card")
    mu = validate.non_negative("friction", friction, "give a coefficient of friction")
    follower = validate.positive("follower_inertia", follower_inertia, "give it as driver_inertia")
    rho = validate.positive("driver_inertia", driver_inertia, "give a consistent unit") / follower
    e = validate.positive("torque", torque, "give the constant driving torque") / follower
    length = validate.positive("duration", duration, "give the length of the run in s")
    between = validate.number("interval", interval)
    if between < 1e-6:
        raise validate.fail("interval", "at least 1e-6 s", interval, "the listing's is 0.0005")
    if length < between:
        raise validate.fail("duration", f"at least {between:g} s", duration, "the listing ran 0.2")
    out = np.zeros((round(length / between) + 1, 4))
    rows = run_listing((float(slots), mu, rho, e, _ENTRY[slots]), between, out)
    if rows < out.shape[0]:
        raise InvalidValue(
            "friction must be below the Painleve limit of the inertias and the motion slow "
            f"enough for steps of 50 us, got {mu!r}; the listing breaks down after "
            f"{rows * between:.4f} s, give less friction or torque"
        )
    return Printout(between * np.arange(rows), *out.T)


def read_printout(printout: Printout) -> Reading:
    """Read the four tabulated figures from a printout, as its author would.

    Terminal speeds are the largest and smallest entry of the last two thirds of
    the run; they agree with the printed ones better than those of the last half, because sampling
    misses every peak by a different amount and more peaks give a higher maximum. The period is
    the mean spacing of handoffs there (THETA passing a multiple of 1.5708, between rows). Rise
    time is the first extremum among the rows within 2 % of its terminal value, maximum against
    maximum and minimum against minimum. `peaks` holds the largest row of each stretch above mean
    speed: their spread is the variation of the peak that Meyer's recommendation 2 asks to
    investigate; it is caused by the sampling.
    """
    time, theta, speed = printout.time, printout.theta, printout.theta_dot
    start = time[-1] / 3.0
    # the first third of a run counts as its rise
    last_cycle = speed[time >= start]
    highest, lowest = float(last_cycle.max()), float(last_cycle.min())
    count = np.arange(1, int(theta[-1] // CELL) + 1)
    # the driver of these runs never turns back, so time is a function of its angle
    handoffs = np.interp(CELL * count, theta, time)
    handoffs = handoffs[handoffs >= start]
    period = float(np.diff(handoffs).mean()) if handoffs.size > 1 else np.nan
    # a turn is a row whose neighbours are both lower or both higher
    slope = np.sign(np.diff(speed))
    turns = np.flatnonzero(slope[:-1] * slope[1:] < 0) + 1
    terminal = np.where(slope[turns - 1] > 0, highest, lowest)
    risen = turns[np.abs(speed[turns] / terminal - 1.0) < 0.02]
    rise = float(time[risen[0]]) if risen.size else np.nan
    tops = [stretch.max() for stretch in stretches(last_cycle, 0.5 * (highest + lowest))]
    return Reading(highest, lowest, rise, period, np.array(tops))


def stretches(speed: FloatArray, level: float) -> list[FloatArray]:
    """Runs of rows above `level` that begin and end inside the table."""
    runs = np.split(speed, np.flatnonzero(np.diff(speed > level)) + 1)[1:-1]
    return [run for run in runs if run[0] > level]
