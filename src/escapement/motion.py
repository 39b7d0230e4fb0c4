"""A motion as a piecewise solution, whichever engine computed it.

Within a piece one side of the slot carries the force and the transmission is
analytic. The engine supplies position and speed. Acceleration, follower motion
and contact moment follow from the equation of motion (PHYSICS.md 2), so they are
computed when they are asked for.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from escapement.dynamics import drive, tabulate
from escapement.errors import InvalidValue
from escapement.mechanisms.slotted import radius
from escapement.model import Escapement, FloatArray
from escapement.painleve import painleve_message
from escapement.status import Status
from escapement.trajectory import Events, Extrema, NoTrajectory, Trajectory
from escapement.validate import fail

_SAMPLES = 100  # per engagement on the default grid: a curve over a full page looks smooth


@dataclass(frozen=True)
class State:
    """Driver, follower and contact at the times `t`: arrays of one shape.

    t [s]; theta, phi [rad]; theta_dot, phi_dot [rad/s]; theta_ddot, phi_ddot
    [rad/s^2]; contact_moment N R [N m], > 0 where the driver pushes the
    follower forward; contact_force N [N], None without a crank radius.
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


@dataclass(frozen=True)
class Ledger:
    """Where the work of the drive went over a motion [J].

    work = kinetic + load + friction, up to `residual`, which is a share of the work or
    of the kinetic energy at the start, whichever is greater.
    """

    work: float
    kinetic: float
    load: float
    friction: float
    residual: float


def stall_message(angle: float, engagement: int) -> str:
    """Message of a motion that stops at `angle` [rad] of an engagement, counted from 0."""
    return (
        f"the mechanism stalls {np.degrees(angle):.3f} degrees from dead centre of engagement "
        f"{engagement + 1}: the drive cannot carry the load torque"
    )


@dataclass(eq=False)  # a frozen one takes longer to make than an engagement takes to solve
class Motion:
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
        End of each completed engagement [s] and the driver speed there [rad/s].
    status, message : Status, str
        How it ended, and the reason in a sentence.
    """

    escapement: Escapement
    engine: str
    rtol: float
    trajectory: Trajectory
    end_time: float
    handoff_times: FloatArray
    handoff_velocities: FloatArray
    status: Status
    message: str

    @property
    def reversals(self) -> Events:
        """Every pin reversal, located exactly."""
        return self.trajectory.reversals

    @property
    def extrema(self) -> Extrema:
        """Every extremum of the driver speed, corners at handoffs included."""
        return self.trajectory.extrema

    def at(self, t: ArrayLike) -> State:
        """State at any times within the motion [s].

        On the boundary of two pieces the later one is taken, where the contact
        moment and the acceleration jump.

        Raises
        ------
        InvalidValue
            Where a time is not finite or lies outside [0, end_time].
        """
        if np.ma.is_masked(t):
            raise fail("t", "free of masked values", t, "give those that count alone")
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise fail("t", "a time in s or an array of times", t, "give finite numbers") from None
        if self.trajectory.start.size == 0:
            raise InvalidValue(f"t must lie within the motion, but there is none: {self.message}")
        outside = ~((times >= 0.0) & (times <= self.end_time))
        if outside.any():
            raise InvalidValue(
                f"t must be between 0 and the end of the motion, {self.end_time!r} s, got "
                f"{float(times[outside].flat[0])!r}; simulate a longer motion or drop the time"
            )
        pieces = np.searchsorted(self.trajectory.start, times, side="right") - 1
        return self._state(pieces, times)

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
        return self._state(np.broadcast_to(pieces, times.shape), times)

    def _state(self, pieces: np.ndarray, times: FloatArray) -> State:
        """State at `times`, each within the piece of that index."""
        escapement, clock = self.escapement, self.escapement.time_unit
        mechanism, owners = escapement.mechanism, pieces.reshape(-1)
        theta, speed = self._driver(owners, times.reshape(-1))
        engagement, sign = self.trajectory.engagement[owners], self.trajectory.sign[owners]
        # in a dwell (sign 0) g = g' = 0: I_d theta_ddot = tau
        g, dg, moment = np.zeros((3, theta.size))
        torque = drive(escapement.scene) * escapement.torque
        rate = np.full(theta.size, torque / escapement.inertia.driver)
        for side in (1.0, -1.0):
            held = sign == side
            angles = theta[held]
            table = np.empty((5, angles.size))
            tabulate(escapement.scene, angles, (speed[held] * clock) ** 2, side, table)
            g[held], dg[held], moment[held] = table[0], table[1], table[3] * escapement.torque
            rate[held] = table[2] / clock**2
        engaged = np.where(sign == 0.0, mechanism.breaks[-1], theta)
        crank = getattr(mechanism, "crank_radius", None)
        force = None if crank is None else moment / (crank * radius(mechanism.path, engaged))
        columns = {
            "theta": theta + engagement * mechanism.cell_angle,
            "theta_dot": speed,
            "theta_ddot": rate,
            "phi": engagement * mechanism.follower_step + mechanism.follower_angle(engaged),
            "phi_dot": g * speed,
            "phi_ddot": g * rate + dg * speed**2,
            "contact_moment": moment,
        }
        shaped = {name: column.reshape(times.shape) for name, column in columns.items()}
        forces = None if force is None else force.reshape(times.shape)
        return State(t=times, **shaped, contact_force=forces)

    def _driver(self, pieces: np.ndarray, t: FloatArray) -> FloatArray:
        """Driver angle in the cell [rad] and speed [rad/s]; shape (2, t)."""
        found = np.empty((2, t.size))
        # the trajectory is asked once for all times within a piece
        order = np.argsort(pieces, kind="stable")
        firsts = np.flatnonzero(np.diff(pieces[order], prepend=-1))
        for first, last in pairwise([*firsts.tolist(), t.size]):
            chosen = order[first:last]
            found[:, chosen] = self.trajectory.state(pieces[chosen[0]], t[chosen])
        return found

    @cached_property
    def t(self) -> FloatArray:
        """Default grid of times [s]: a hundred even ones an engagement, and all events.

        The exact times of handoffs, reversals and extrema of the driver speed are among
        them, so that the samples show every peak of `theta_dot` in full.
        """
        ends = np.concatenate([[0.0], self.handoff_times, [self.end_time]])
        even = np.linspace(ends[:-1], ends[1:], _SAMPLES, endpoint=False).reshape(-1)
        times = np.concatenate([even, self.reversals.time, self.extrema.time, ends[-1:]])
        return np.unique(np.minimum(times, self.end_time)) if self.end_time > 0.0 else np.empty(0)

    @cached_property
    def samples(self) -> State:
        """State on the default grid `t`."""
        return self.at(self.t)

    @property
    def theta(self) -> FloatArray:
        """Driver angle from the first dead centre on the default grid [rad]."""
        return self.samples.theta

    @property
    def theta_dot(self) -> FloatArray:
        """Driver speed on the default grid [rad/s]."""
        return self.samples.theta_dot

    @property
    def theta_ddot(self) -> FloatArray:
        """Driver acceleration on the default grid [rad/s^2]."""
        return self.samples.theta_ddot

    @property
    def phi(self) -> FloatArray:
        """Follower angle on the default grid [rad]."""
        return self.samples.phi

    @property
    def phi_dot(self) -> FloatArray:
        """Follower speed on the default grid [rad/s]."""
        return self.samples.phi_dot

    @property
    def phi_ddot(self) -> FloatArray:
        """Follower acceleration on the default grid [rad/s^2]."""
        return self.samples.phi_ddot

    @property
    def contact_moment(self) -> FloatArray:
        """Moment N R on the follower on the default grid [N m]."""
        return self.samples.contact_moment

    @property
    def contact_force(self) -> FloatArray | None:
        """Force on the pin on the default grid [N]; None without a crank radius."""
        return self.samples.contact_force

    @cached_property
    def ledger(self) -> Ledger:
        """Energy balance from start to end; it closes up to the engine's error."""
        escapement = self.escapement
        if self.trajectory.start.size == 0:
            return Ledger(0.0, 0.0, 0.0, 0.0, 0.0)
        ends = self.at([0.0, self.end_time])
        driver, follower = escapement.inertia.driver, escapement.inertia.follower
        energies = (driver * ends.theta_dot**2 + follower * ends.phi_dot**2) / 2.0
        work = escapement.torque * (ends.theta[1] - ends.theta[0])
        load = escapement.load_work(ends.phi[1] - ends.phi[0])
        friction = float(self.trajectory.friction_loss.sum())
        kinetic = float(energies[1] - energies[0])
        scale = max(work, float(energies[0]))
        residual = (work - kinetic - load - friction) / scale if scale > 0.0 else 0.0
        return Ledger(float(work), kinetic, float(load), friction, float(residual))


def no_motion(escapement: Escapement, engine: str, rtol: float) -> Motion:
    """The result at or above the Painleve limit: a motion without pieces, and the reason."""
    message = painleve_message(escapement.mechanism, escapement.inertia, escapement.friction)
    none, status = np.empty(0), Status.PAINLEVE
    return Motion(escapement, engine, rtol, NoTrajectory(), 0.0, none, none, status, message or "")
