"""A motion as a piecewise solution, the same for every engine.

Within a piece one side of the slot carries the force and the transmission is
analytic. The engine supplies position and speed. Acceleration, follower motion
and contact moment follow from the equation of motion, so they are
computed when they are asked for.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.base.text import Shown
from escapement.base.validate import fail
from escapement.dynamics.energy_balance import Judged, JudgedResult, Ledger, ledger_of
from escapement.dynamics.events import handoffs_of, impacts_among, slide_changes_of
from escapement.dynamics.flow_changes import FlowChanges, flow_changes_of
from escapement.dynamics.law import LOSSES
from escapement.dynamics.painleve import painleve_message
from escapement.dynamics.state_table import LOST, ROWS, LawTable, tabulate
from escapement.dynamics.trajectory import (
    Events,
    Extrema,
    Handoffs,
    Impacts,
    NoTrajectory,
    Trajectory,
)
from escapement.dynamics.variables import as_dataframe, as_dataset
from escapement.mechanisms.protocol import FloatArray
from escapement.model.escapement import Escapement

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

_SAMPLES = 100  # per engagement on the default grid: a curve over a full page looks smooth


@dataclass(frozen=True, repr=False)
class State(Shown):
    """Driver, follower and contact at the times `t`: arrays of one shape.

    t [s]; theta, phi [rad]; theta_dot, phi_dot [rad/s]; theta_ddot, phi_ddot
    [rad/s^2]; contact_moment N h [N m], the moment of the contact on the follower minus the
    friction of its bearing, > 0 where the driver pushes it forward; contact_force N [N], None
    without a crank radius. driver_bearing_reaction, follower_bearing_reaction [N]: forces that
    the bearings carry, None without a crank radius, and of a gear-driven wheel's driver.
    power_lost [W]: arrays by the names in `dynamics.law.LOSSES`.
    """

    t: FloatArray
    theta: FloatArray
    theta_dot: FloatArray
    theta_ddot: FloatArray
    phi: FloatArray
    phi_dot: FloatArray
    phi_ddot: FloatArray
    contact_moment: FloatArray
    contact_force: FloatArray | None
    driver_bearing_reaction: FloatArray | None
    follower_bearing_reaction: FloatArray | None
    power_lost: dict[str, FloatArray]


def stall_message(angle: float, engagement: int, status: Status = Status.STALL) -> str:
    """Message of a motion that stops at `angle` [rad] of an engagement, counted from 0."""
    spent = status is Status.SPENT
    where = f"{np.degrees(angle):.3f} degrees from dead centre of engagement {engagement + 1}"
    reason = "the spring is spent" if spent else "the drive cannot carry the load and losses"
    return f"the mechanism {'stops' if spent else 'stalls'} {where}: {reason}"


def _on_grid(name: str, meaning: str) -> cached_property[FloatArray]:
    """An attribute of a motion that is a column of its `samples`."""
    column = cached_property(attrgetter(f"samples.{name}"))
    column.__doc__ = f"{meaning} on the default grid."
    return column


# creating a frozen instance would take longer than solving an engagement
@dataclass(eq=False, repr=False, init=False)
class Motion(JudgedResult, Shown):
    """Motion of an escapement, exact between its handoffs and reversals.

    Attributes
    ----------
    escapement : Escapement
        What was simulated.
    engine, rtol : str, float
        The engine, and the relative error asked for.
    trajectory : Trajectory
        The engine's piecewise solution.
    end_time : float
        Length of the motion [s].
    handoff_times, handoff_velocities : ndarray, shape (engagements,)
        End of each completed engagement [s] and the driver speed there [rad/s], after the impact if
        there is one.
    status, message : Status, str
        How it ended, and the reason in a sentence. It is NOT_CONVERGED where the energy balance
        does not close, and becomes so where there are no states at the times asked for. For the
        balance the `ledger` is computed when the status is first read; of a motion of more than 512
        engagements only that of the first 512, until the whole `ledger` is asked for.
    """

    escapement: Escapement
    engine: str
    rtol: float
    trajectory: Trajectory
    end_time: float
    handoff_times: FloatArray
    handoff_velocities: FloatArray
    status: Judged = Judged()  # noqa: RUF009 - the descriptor of the field, not its default
    message: Judged = Judged()  # noqa: RUF009

    def __init__(
        self,
        escapement: Escapement,
        engine: str,
        rtol: float,
        trajectory: Trajectory,
        end_time: float,
        handoff_times: FloatArray,
        handoff_velocities: FloatArray,
        status: Status,
        message: str,
    ) -> None:
        self.escapement, self.engine, self.rtol = escapement, engine, rtol
        self.trajectory, self.end_time = trajectory, end_time
        self.handoff_times, self.handoff_velocities = handoff_times, handoff_velocities
        # nothing is judged yet, and the calls of two descriptors would take a third of this time
        kept = self.__dict__
        kept["status"], kept["message"] = status, message

    def _shown(self) -> list[tuple[str, Any, str]]:
        speeds, failed = self.handoff_velocities, self.status != Status.OK
        return [
            ("status", self.message if failed else self.status, ""),
            ("engagements", self.handoff_times.size, ""),
            ("end_time", self.end_time, "s"),
            ("handoff_velocity", speeds[-1] if speeds.size else np.nan, "rad/s"),
            ("engine", self.engine, ""),
            ("rtol", self.rtol, ""),
            ("mechanism", self.escapement.mechanism, ""),
        ]

    @property
    def reversals(self) -> Events:
        """Every pin reversal, located exactly."""
        found: Events = self.trajectory.reversals
        return found

    @property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed, corners at handoffs included."""
        found: Extrema = self.trajectory.extrema
        return found

    @cached_property
    def handoffs(self) -> Handoffs:
        """Every handoff: its kind, its impact, and the clearance that it needs."""
        return handoffs_of(self.escapement, self.handoff_times, self.handoff_velocities)

    @property
    def impacts(self) -> Handoffs | Impacts:
        """Every impact: with clearance those between pin and slot, otherwise those of handoffs."""
        computed = self.trajectory.impacts
        return impacts_among(self.handoffs) if computed is None else computed

    @cached_property
    def slide_changes(self) -> Events:
        """Every instant at which the contact point reverses its direction of sliding.

        There it crosses the line of centres; for a pin without a radius this is dead centre.
        """
        return slide_changes_of(self)

    @cached_property
    def flow_changes(self) -> FlowChanges:
        """Every instant at which the direction of the power through a train changes."""
        return flow_changes_of(self)

    def at(self, t: ArrayLike) -> State:
        """State at any times within the motion [s].

        At the boundary of two pieces, where contact moment and acceleration may jump, the state
        is that of the later piece.

        Raises
        ------
        InvalidValue
            If a time is not finite or lies outside [0, end_time].
        """
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise fail("t", "a time in s or an array of times", t, "give finite numbers") from None
        if isinstance(self.trajectory, NoTrajectory):
            raise InvalidValue(f"t must lie within the motion, but there is none: {self.message}")
        outside = ~((times >= 0.0) & (times <= self.end_time))
        if outside.any():
            raise InvalidValue(
                f"t must be between 0 and the end of the motion, {self.end_time!r} s, got "
                f"{float(times[outside].flat[0])!r}; simulate a longer motion or drop the time"
            )
        # in a long motion only the engagements that contain these times are solved
        return self._at(self.trajectory.around(times), times)

    def within(self, piece: ArrayLike, t: ArrayLike) -> State:
        """State at times within pieces, one-sided at their boundaries.

        Parameters
        ----------
        piece : int or array_like of int
            Index of the piece of each time, of a shape that broadcasts to that of `t`.
        t : array_like
            Times within those pieces [s].

        Raises
        ------
        InvalidValue
            For a piece that the motion does not have.
        """
        times, pieces = np.asarray(t, dtype=float), np.asarray(piece)
        count = self.trajectory.start.size
        if pieces.dtype.kind not in "iu" or ((pieces < 0) | (pieces >= count)).any():
            raise fail("piece", f"whole and from 0 to {count - 1}", piece, "they count from 0")
        return self._state(self.trajectory, np.broadcast_to(pieces, times.shape), times)

    def _at(self, trajectory: Trajectory, times: FloatArray) -> State:
        """State at `times`, which lie within these pieces."""
        pieces = np.searchsorted(trajectory.start, times, side="right") - 1
        return self._state(trajectory, pieces, times)

    def _state(self, trajectory: Trajectory, pieces: np.ndarray, times: FloatArray) -> State:
        """State at `times`, each within the piece of that index."""
        if (whole := trajectory.states_at(pieces, times)) is not None:
            return whole
        escapement, clock = self.escapement, self.escapement.time_unit
        mechanism, owners, flat = escapement.mechanism, pieces.reshape(-1), times.reshape(-1)
        theta, speed = trajectory.states(owners, flat)
        if np.isnan(speed).any():
            self.judge_by(np.nan)
        engagement, sign = trajectory.engagement[owners], trajectory.sign[owners]
        driver_angle = escapement.driver_angle_before(engagement) + np.zeros(theta.size)
        # the sense from the nearer end of the piece into it
        since, until = np.append(trajectory.start, self.end_time)[[owners, owners + 1]]
        inward = np.where(flat - since <= until - flat, 1.0, -1.0)
        table = np.zeros((ROWS, theta.size))
        law, losses = LawTable(*table), table[LOST:]
        phi, delay = engagement * mechanism.follower_step, np.zeros(theta.size)
        for k, pair in enumerate(escapement.pairs):
            here, scene = engagement % len(escapement.pairs) == k, escapement.scenes[k]
            delay[here] = pair.delay
            driver_angle[here] += theta[here] - scene.edges[0]
            engaged = np.where(sign[here] == 0.0, scene.edges[-1], theta[here])
            phi[here] += pair.follower_angle(engaged)
            for side in (1.0, 0.0, -1.0):
                held = here & (sign == side)
                angles, w = theta[held], (speed[held] * clock) ** 2
                part = np.empty((ROWS, angles.size))
                tabulate(scene, angles, inward[held], driver_angle[held], w, side, part)
                table[:, held] = part
        rate, torque = law.rate / clock**2, escapement.torque_unit
        crank = mechanism.crank_radius
        columns: dict[str, FloatArray | None] = {
            "theta": theta + engagement * mechanism.cell_angle + delay,
            "theta_dot": speed,
            "theta_ddot": rate,
            "phi": phi,
            "phi_dot": law.ratio * speed,
            "phi_ddot": law.ratio * rate + law.ratio_slope * speed**2,
            "contact_moment": law.moment * torque,
            "contact_force": None,
            "driver_bearing_reaction": None,
            "follower_bearing_reaction": None,
        }
        if crank is not None:
            columns["contact_force"] = force = law.force * torque / crank
            # both bearings carry the force of the contact and its friction
            reaction = np.abs(force) * np.hypot(1.0, escapement.scene.mu_plus)
            columns["follower_bearing_reaction"] = reaction
            if mechanism.plain_crank:
                columns["driver_bearing_reaction"] = reaction
        shaped: dict[str, Any] = {
            name: None if column is None else column.reshape(times.shape)
            for name, column in columns.items()
        }
        powers = (losses * torque * speed).reshape(len(LOSSES), *times.shape)
        return State(t=times, **shaped, power_lost=dict(zip(LOSSES, powers, strict=True)))

    @cached_property
    def t(self) -> FloatArray:
        """Default grid of times [s]: a hundred even steps per engagement, and all events.

        The exact times of handoffs, reversals and extrema of the driver speed are among
        them, so that the samples show every peak of `theta_dot` in full, and the start of
        every piece; of impacts with clearance the last instant before them too.
        """
        parts = [self._grid() if part is self else part.t for part in self.parts()]
        return parts[0] if len(parts) == 1 else np.unique(np.concatenate(parts))

    def _grid(self) -> FloatArray:
        """The default grid of a motion of one part."""
        starts, peaks = self.trajectory.start, self.extrema.time
        ends = np.concatenate([starts[:1], self.handoff_times, [self.end_time]])
        even = np.linspace(ends[:-1], ends[1:], _SAMPLES, endpoint=False).reshape(-1)
        times = np.concatenate([even, starts, self.reversals.time, peaks, ends[-1:]])
        if (impacts := self.trajectory.impacts) is not None:
            # the states on both sides of a jump
            times = np.concatenate([times, np.nextafter(impacts.time, 0.0)])
        return np.unique(np.minimum(times, self.end_time)) if self.end_time > 0.0 else np.empty(0)

    def parts(self) -> "Iterator[Motion]":
        """A long motion as several parts of some engagements each; a short one is its only part.

        Their times and angles are those of the whole; the end of each is the start of the next.
        """
        for part, some in self.trajectory.parts():
            if part is self.trajectory:
                yield self
                return
            times, speeds = self.handoff_times[some], self.handoff_velocities[some]
            end = self.end_time if some.stop > self.handoff_times.size else float(times[-1])
            yield replace(
                self, trajectory=part, end_time=end, handoff_times=times, handoff_velocities=speeds
            )

    @cached_property
    def samples(self) -> State:
        """State on the default grid `t`."""
        return self.at(self.t)

    theta = _on_grid("theta", "Driver angle from the first dead centre [rad]")
    theta_dot = _on_grid("theta_dot", "Driver speed [rad/s]")
    theta_ddot = _on_grid("theta_ddot", "Driver acceleration [rad/s^2]")
    phi = _on_grid("phi", "Follower angle [rad]")
    phi_dot = _on_grid("phi_dot", "Follower speed [rad/s]")
    phi_ddot = _on_grid("phi_ddot", "Follower acceleration [rad/s^2]")
    contact_moment = _on_grid("contact_moment", "Moment N h on the follower [N m]")

    @property
    def contact_force(self) -> FloatArray | None:
        """Force on the pin on the default grid [N]; None without a crank radius."""
        return self.samples.contact_force

    def to_xarray(self) -> "Dataset":
        """Samples over `t`, handoffs, events and pieces as an `xarray.Dataset`, in SI.

        Names are those of a file of the motion.

        Raises
        ------
        MissingPackage
            When xarray is not installed.
        """
        return as_dataset(self)

    def to_dataframe(self) -> "DataFrame":
        """The samples as a `pandas.DataFrame` in SI, its index `t`; `attrs` has the units.

        Raises
        ------
        MissingPackage
            When pandas is not installed.
        """
        return as_dataframe(self)

    @cached_property
    def ledger(self) -> Ledger:
        """Energy balance from start to end; it closes up to the engine's error.

        If it does not close within 1e-6, `status` becomes NOT_CONVERGED.
        """
        return self.balance()

    def balance(self, progress: Callable[[int, int, int], None] | None = None) -> Ledger:
        """The `ledger`, computed with a progress bar as in `write_motion`."""
        ledger = ledger_of(self, progress)
        vars(self)["ledger"] = ledger
        self.judge_by(ledger.residual)
        return ledger

    def _residual(self) -> float:
        part = next(self.parts(), self)
        return self.ledger.residual if part is self else ledger_of(part).residual

    @property
    def _rtol(self) -> float:
        return self.rtol


def no_motion(escapement: Escapement, engine: str, rtol: float, invalid: str = "") -> Motion:
    """A motion without pieces, and the reason: `invalid`, or else the Painleve limit."""
    message = invalid or painleve_message(escapement) or ""
    none, status = np.empty(0), Status.INVALID if invalid else Status.PAINLEVE
    return Motion(
        escapement,
        engine=engine,
        rtol=rtol,
        trajectory=NoTrajectory(),
        end_time=0.0,
        handoff_times=none,
        handoff_velocities=none,
        status=status,
        message=message,
    )
