"""Figures of merit: the numbers that a designer reads off a motion.

The terminal figures are those of the cycle that repeats itself. Rise and settling
time compare the extrema of the motion from its start with that cycle, and
`rise_time_63` and `rise_time_98` its handoffs.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from operator import attrgetter
from typing import Any

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.base.text import Shown
from escapement.base.units import printed
from escapement.dynamics.batch_spread import BatchSpread
from escapement.dynamics.energy_balance import Judged, JudgedResult
from escapement.dynamics.figure_table import FIGURES, OF_MOTOR, PEAKS, TRANSIENT
from escapement.dynamics.motion import Motion
from escapement.dynamics.motor_figures import motor_figures
from escapement.dynamics.trajectory import Extrema
from escapement.mechanisms.protocol import FloatArray
from escapement.model.materials import NEEDED as STRESSES
from escapement.model.materials import pin_stresses
from escapement.numerics import search

RISE_BAND = 0.02
"""A rise is over at the first extremum this close to its terminal value [-]."""
SETTLING_BAND = 0.01
"""A motion is settled when every later extremum is this close [-]."""
FALL_63, FALL_98 = math.exp(-1.0), 0.02
"""Shares of the first deviation at which `rise_time_63` and `rise_time_98` are read [-]."""
LEAST_RATIO = 1e-9
"""A deviation of the handoff speed below this is lost in rounding [-]."""
MAX_ENGAGEMENTS = 1_000_000
"""A rise or settling time beyond this many engagements is not given."""
BOUNDLESS = 1e-12
"""Relative gain of w in an engagement below which a table's ratio is constant to rounding [-].
Then no loss in the gears grows with the speed, and no terminal speed exists."""

_NAN = math.nan
_NEAREST = 1e-9
"""The search for a peak begins this close to the ends of a piece, relative to its length."""


def _part(of: str, meaning: str) -> cached_property[float]:
    """A figure that is computed together with others, which an attribute holds by their names."""
    part = cached_property(lambda figures: float(getattr(figures, of)[part.attrname]))
    part.__doc__ = meaning
    return part


class _OfApproach:
    """A figure of the motion that leads to the cycle, computed with the others when it is read."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, figures: Any, owner: type | None = None) -> Any:
        if figures is None:
            return _NAN  # the default of the field
        own = vars(figures)
        if own["approach"] is not None:
            (speed, motion), own["approach"] = own["approach"], None
            rise, settled = read_transient(motion, figures)
            falls = fall_times(motion, speed, figures.motion)
            own.update(zip(TRANSIENT, (rise, *falls, settled), strict=True))
        return own[self.name]

    def __set__(self, figures: Any, value: float) -> None:
        vars(figures)[self.name] = value


# NaN is not equal to itself, so two would never compare equal
@dataclass(frozen=True, eq=False, repr=False)
class Figures(JudgedResult, Shown):
    """Figures of merit of an escapement; NaN where there is none.

    Those from acceleration_max to reversal_angles need samples of the terminal
    engagement and are computed when they are first asked for, and so are rise and settling times
    of bodies with outlines.

    velocity_max, velocity_min : extremes of the terminal driver speed [rad/s].
    velocity_mean : cell angle over period [rad/s].
    period : time of one terminal engagement, dwell included [s]; with imperfect parts the mean
        over the engagements after which pins and slots meet again.
    run_time : time of the number of turns that a study gives [s]; NaN without one, or if the driver
        stops before.
    rise_time : first velocity extremum within 2 % of its terminal value [s]. It jumps, by
        half an engagement or so, where a change of the design brings an earlier extremum
        into the band or takes one out. An impact that takes less than 1e-4 of the speed is no
        extremum.
    settling_time : first extremum after which every engagement's extremes are within 1 % [s]; it
        jumps in the same way.
    rise_time_63, rise_time_98 : times at which the deviation of the handoff speed from its
        terminal value at the same handoff of the cycle has fallen to 1/e and to 0.02 of that at
        the start [s], see `fall_times`. They do not jump.
    handoff_velocity : driver speed at the terminal handoff [rad/s].
    contraction : factor by which the cycle shrinks a small deviation of the squared handoff
        speed from its terminal value [-]; of pallets that by which a pitch, of clocks a full
        swing, shrinks the deviation that lasts longest.
    acceleration_max, follower_acceleration_max : greatest magnitudes over the
        terminal cycle [rad/s^2].
    contact_moment_max : greatest magnitude of the moment on the follower [N m].
    contact_force_max : greatest magnitude of the force on the pin [N]; NaN
        without a crank radius.
    rubbing_max : greatest product of the force on the pin and its sliding speed [W].
    pressure_max to pressure_speed_max : see `model.materials.pin_stresses`; NaN without a
        `pin_length`.
    pin_load_frequency : how often each pin is loaded [1/s].
    speed_dip, motor_torque_max, motor_torque_rms, motor_stall_share : with a motor, see
        `motor_figures.motor_figures`; without one NaN.
    energy_residual : energy unaccounted for over the terminal cycle, as a share of the work [-].
    reversal_angles : pin reversals of the terminal cycle, from dead centre [rad].
    last_reversal_angle : the last of them; NaN where there is none [rad].
    critical_friction : Painleve limit; at and above it no motion exists [-].
    jam_margin : 1 - friction/critical_friction, 0 or less where the mechanism jams [-].
    uniqueness_friction : friction at and above which the motion is not unique [-].
    beats, beat_error : durations of these engagements, and the longest minus the shortest [s].
    blow_max : greatest energy lost in an impact [J], friction during the impulse included.
    motion : the terminal cycle, one engagement or all of these, None where there is none.
    approach : of bodies with outlines, the speed at the start [rad/s] and the motion from there,
        until a rise or settling time is read.
    spread : scatter of engagements that never repeat, otherwise None. Velocities and period are
        then means.
    status, message : outcome, and its reason in a sentence. The energy balance of the cycle decides
        on them when they are first read.
    """

    _most = 600

    velocity_max: float = _NAN
    velocity_min: float = _NAN
    velocity_mean: float = _NAN
    period: float = _NAN
    run_time: float = _NAN
    rise_time: _OfApproach = _OfApproach()
    settling_time: _OfApproach = _OfApproach()
    rise_time_63: _OfApproach = _OfApproach()
    rise_time_98: _OfApproach = _OfApproach()
    handoff_velocity: float = _NAN
    contraction: float = _NAN
    critical_friction: float = _NAN
    uniqueness_friction: float = _NAN
    jam_margin: float = _NAN
    motion: Motion | None = field(default=None, repr=False)
    approach: tuple[float, Motion] | None = field(default=None, repr=False)
    spread: BatchSpread | None = None
    status: Judged = Judged(Status.OK)  # noqa: RUF009 - the descriptor of the field
    message: Judged = Judged(MESSAGES[Status.OK])  # noqa: RUF009

    def having(self, **found: Any) -> "Figures":
        """A copy with other fields, on whose status the energy balance has not decided.

        `replace` would read the status, and thus decide on that of the copy as well.
        """
        mine, made = vars(self), object.__new__(Figures)
        vars(made).update({name: mine[name] for name in _FIELDS}, **found)
        return made

    @property
    def _units(self) -> dict[str, str]:  # type: ignore[override]
        return {name: printed(figure.kind, "SI") for name, figure in FIGURES.items()}

    @property
    def velocity_average_published(self) -> float:
        """(max + min)/2, the average terminal velocity of Meyer's thesis [rad/s]."""
        return (self.velocity_max + self.velocity_min) / 2.0

    @cached_property
    def _peaks(self) -> dict[str, float]:
        found = [_NAN] * len(PEAKS) if self.motion is None else find_peaks(self.motion)
        return dict(zip(PEAKS, found, strict=True))

    acceleration_max = _part("_peaks", "Greatest driver acceleration [rad/s^2].")
    follower_acceleration_max = _part("_peaks", "Greatest follower acceleration [rad/s^2].")
    contact_moment_max = _part("_peaks", "Greatest moment on the follower [N m].")
    contact_force_max = _part("_peaks", "Greatest force on the pin [N].")
    rubbing_max = _part("_peaks", "Greatest product of force on the pin and sliding speed [W].")

    @cached_property
    def _stresses(self) -> dict[str, float]:
        if self.motion is None or not self.motion.escapement.pin_length:
            return dict.fromkeys(STRESSES, _NAN)
        owner = self.motion.escapement
        numbers = owner.settings | owner.mechanism.lengths
        return pin_stresses(self.contact_force_max, self.rubbing_max, numbers)

    pressure_max = _part("_stresses", "Greatest pressure between pin and wall [Pa].")
    pin_bending_max = _part("_stresses", "Greatest bending stress of the pin [Pa].")
    pin_shear_max = _part("_stresses", "Greatest mean shear stress of the pin [Pa].")
    pressure_speed_max = _part("_stresses", "Greatest pressure times speed [W/m^2].")

    @property
    def pin_load_frequency(self) -> float:
        """How often each pin is loaded [1/s]; NaN without slots."""
        if self.motion is None or not self.motion.escapement.mechanism.slots:
            return _NAN
        wheel: Any = self.motion.escapement.mechanism
        return float(1.0 / (wheel.pins * self.period))

    @cached_property
    def _motor(self) -> dict[str, float]:
        none = dict.fromkeys(OF_MOTOR, _NAN)
        return none if self.motion is None else motor_figures(self.motion)

    speed_dip = _part("_motor", "Greatest less least driver speed, over the greatest [-].")
    motor_torque_max = _part("_motor", "Greatest torque of the motor [N m].")
    motor_torque_rms = _part("_motor", "Effective torque of the motor [N m].")
    motor_stall_share = _part("_motor", "Greatest torque over that at rest [-].")

    @property
    def beats(self) -> tuple[float, ...]:
        """Time of each engagement of the cycle in turn, from handoff to handoff [s]."""
        times = () if self.motion is None else np.diff(self.motion.handoff_times, prepend=0.0)
        return tuple(np.asarray(times).tolist())

    @property
    def beat_error(self) -> float:
        """Greatest minus least of the beats [s]."""
        return max(self.beats) - min(self.beats) if self.beats else _NAN

    @property
    def blow_max(self) -> float:
        """Greatest energy lost in an impact of the cycle [J].

        It is all that both bodies lose during the impulse. Friction along the wall is part of it,
        and mostly the greater part.
        """
        return _NAN if self.motion is None else float(self.motion.impacts.energy.max(initial=0.0))

    @property
    def energy_residual(self) -> float:
        """Energy unaccounted for, as a share of the work [-].

        If it is above 1e-6, `status` is NOT_CONVERGED.
        """
        return _NAN if self.motion is None else self.motion.ledger.residual

    def _residual(self) -> float:
        return 0.0 if self.motion is None else self.energy_residual

    @property
    def _rtol(self) -> float:
        return 0.0 if self.motion is None else self.motion.rtol

    @property
    def reversal_angles(self) -> tuple[float, ...]:
        """Pin reversals, from dead centre [rad]."""
        if self.motion is None:
            return ()
        reversals, cell = self.motion.reversals, self.motion.escapement.mechanism.cell_angle
        return tuple((reversals.theta - reversals.engagement * cell).tolist())

    @property
    def last_reversal_angle(self) -> float:
        """The last pin reversal, from dead centre [rad]; NaN where there is none."""
        return max(self.reversal_angles, default=_NAN)

    def as_dict(self) -> dict[str, Any]:
        """All figures by name, with the published average after the mean."""
        return {name: getattr(self, name) for name in _NAMES}


_FIELDS = tuple(field.name for field in fields(Figures))
_NAMES = (*FIGURES, "beats", "reversal_angles", "status", "message")


def fall_times(motion: Motion, start: float, cycle: Motion) -> tuple[float, float]:
    """`rise_time_63` and `rise_time_98` [s] of a motion.

    They are the times at which |v - v_terminal|/|v_0 - v_terminal| has fallen to 1/e and to
    0.02. At time 0 it is 1, at each handoff v is the speed there, and in between its
    logarithm is linear in time. v_terminal is the speed at the same handoff of the terminal
    cycle; with imperfect parts each handoff of a cycle has its own. Motions do not cross, so the
    deviation falls from handoff to handoff; if it rises, the first time counts. Values below 1e-9
    count as 1e-9, because their digits are lost.

    Parameters
    ----------
    motion : Motion
        The motion, from its start on.
    start : float
        Speed at the first pin entry [rad/s].
    cycle : Motion
        The terminal cycle: one engagement, or all of a pattern.

    Returns
    -------
    float, float
        0 where the motion starts at the terminal speed, to within the motion's rtol; NaN
        where it ends too early.
    """
    terminal = np.append(cycle.handoff_velocities[-1], cycle.handoff_velocities)
    speeds = np.append(start, motion.handoff_velocities)
    # the terminal cycle begins as it ends
    turns = np.arange(speeds.size - 1) % (terminal.size - 1) + 1
    deviation = np.abs(speeds - terminal[np.append(0, turns)])
    if deviation[0] <= motion.rtol * terminal[0]:
        return 0.0, 0.0
    depth = -np.log(np.maximum(deviation / deviation[0], LEAST_RATIO))
    times = np.append(0.0, motion.handoff_times)
    return _passed(-math.log(FALL_63), depth, times), _passed(-math.log(FALL_98), depth, times)


def _passed(level: float, depth: FloatArray, times: FloatArray) -> float:
    """Time at which a depth, linear between given times, first reaches a level; or NaN."""
    below = np.flatnonzero(depth >= level)
    if not below.size:
        return _NAN
    two = slice(below[0] - 1, below[0] + 1)
    return float(np.interp(level, depth[two], times[two]))


def cycle_figures(cycle: Motion) -> dict[str, Any]:
    """Figures of a cycle that starts at the terminal speed."""
    speeds = np.concatenate([cycle.extrema.theta_dot, cycle.at([0.0, cycle.end_time]).theta_dot])
    period = float(cycle.end_time / cycle.handoff_times.size)
    return {
        "velocity_max": float(speeds.max()),
        "velocity_min": float(speeds.min()),
        "velocity_mean": float(cycle.escapement.mechanism.cell_angle / period),
        "period": period,
        "handoff_velocity": float(cycle.handoff_velocities[-1]),
    }


def read_figures(
    base: Figures,
    cycle: Motion,
    contraction: float,
    initial_speed: float,
    follow: Callable[[int], Motion],
    longest: int,
) -> Figures:
    """The figures of merit, from the terminal cycle and a motion that leads to it.

    Parameters
    ----------
    base : Figures
        Those that need no motion, and the message.
    cycle, contraction : as `Figures` has them.
    initial_speed : float
        Speed at the first pin entry [rad/s].
    follow, longest : callable, int
        The motion from there over a number of engagements, and how many to follow at most.
    """
    # status and message are judged when they are read, so that the result is made only once
    found = cycle_figures(cycle) | {"contraction": contraction, "motion": cycle}
    size, start = len(cycle.escapement.pairs), initial_speed / found["handoff_velocity"]
    count = transient_length(abs(contraction) ** (1.0 / size), start)
    count = count if size == 1 else size * (2 + count // size)
    while count <= longest:
        motion = follow(count)
        rise, settled = read_transient(motion, replace(base, **found))
        falls = fall_times(motion, initial_speed, cycle)
        times: dict[str, Any] = dict(zip(TRANSIENT, (rise, *falls, settled), strict=True))
        if not any(map(math.isnan, times.values())) or motion.handoff_times.size < count:
            return replace(base, **found, **times)
        count *= 2
    most, result = f"{longest:_}".replace("_", " "), replace(base, **found)
    why = f"these figures take more than {most} engagements and are not given"
    result.add_notes(f"{why}: {', '.join(TRANSIENT)}")
    return result


def read_transient(motion: Motion, figures: Figures) -> tuple[float, float]:
    """Rise and settling time [s] of a motion that has reached its terminal cycle.

    A time is NaN where the motion is too short to show it.
    """
    extrema = motion.extrema
    terminal = np.where(extrema.maximum, figures.velocity_max, figures.velocity_min)
    extremes, size = _extremes(extrema), len(motion.escapement.pairs)
    if size > 1:
        # each engagement of a pattern converges to its own extremes, those of the last round
        kinds = np.array([extrema.engagement % size, extrema.maximum])
        last = extremes[extrema.engagement[extremes] >= motion.handoff_times.size - size]
        final = np.full((size, 2), _NAN)
        final[tuple(kinds[:, last])] = extrema.theta_dot[last]
        terminal = final[tuple(kinds)]
    # an impact may stop the driver, which then has no least speed to compare with
    scale = np.maximum(np.abs(terminal), LEAST_RATIO * figures.velocity_max)
    error = np.abs(extrema.theta_dot - terminal) / scale
    risen = np.nonzero(error <= RISE_BAND)[0]
    unsettled = np.nonzero(error[extremes] > SETTLING_BAND)[0]
    settled = extremes[unsettled[-1] + 1 :] if unsettled.size else extremes
    return (
        float(extrema.time[risen[0]]) if risen.size else _NAN,
        float(extrema.time[settled[0]]) if settled.size else _NAN,
    )


def transient_length(contraction: float, start: float) -> int:
    """Number of cycles after which the deviation is far below the settling band.

    `start` is the initial over the terminal speed. Each cycle multiplies the deviation of w by
    the contraction.
    """
    rate = math.log(min(max(contraction, 1e-4), 1.0 - 1e-12))
    return 8 + math.ceil((math.log(1e-4) - 2.0 * math.log(max(start, 1.0))) / rate)


def _extremes(extrema: Extrema) -> np.ndarray:
    """Indices of the extrema that are the greatest or the least of their engagement.

    Other extrema converge to other limits and are not comparable with the terminal extremes. An
    extremum on a handoff belongs to the engagement that begins there.
    """
    heights = np.where(extrema.maximum, extrema.theta_dot, -extrema.theta_dot)
    order = np.lexsort((-heights, extrema.maximum, extrema.engagement))
    kinds = np.column_stack([extrema.engagement, extrema.maximum])[order]
    return np.sort(order[np.unique(kinds, axis=0, return_index=True)[1]])


def find_peaks(motion: Motion) -> list[float]:
    """Greatest accelerations of driver and follower, contact moment, force, and force times speed.

    They are magnitudes over all pieces, one-sided at their boundaries. The last two are NaN
    without a crank radius.
    """
    # one engine computes them itself; the motion of the other is sampled
    found = motion.trajectory.peaks
    if found is None:
        return _sampled_peaks(motion)
    # that with yielding walls does not tell how the pin slides
    *others, force, rubbing = [*found.max(axis=1).tolist(), _NAN][:5]
    crank = motion.escapement.mechanism.crank_radius
    return [*others, _NAN, _NAN] if crank is None else [*others, force / crank, rubbing]


def _sampled_peaks(motion: Motion) -> list[float]:
    """The same from states of the motion."""
    read: list[Callable[[Any], Any]] = [
        attrgetter(name) for name in ("theta_ddot", "phi_ddot", "contact_moment")
    ]
    if motion.escapement.mechanism.crank_radius is not None:
        read.append(attrgetter("contact_force"))
        if friction := float(motion.escapement.scene.mu_plus):
            read.append(lambda states: states.power_lost["friction"] / friction)
    bounds = np.append(motion.trajectory.start, motion.end_time)
    pieces = np.arange(bounds.size - 1)[:, None]
    grid = _first_grid(motion, pieces, bounds)
    first, tops = motion.within(pieces, grid), []
    for one in read:

        def size_at(times: FloatArray, one: Any = one) -> FloatArray:
            return np.asarray(np.abs(one(motion.within(pieces, times))))

        values, _times = search.peaks(size_at, grid, np.abs(np.asarray(one(first))))
        tops.append(float(values.max()))
    # without friction the states do not tell how the pin slides
    return [*tops, _NAN, _NAN][:5]


def _first_grid(motion: Motion, pieces: np.ndarray, bounds: np.ndarray) -> FloatArray:
    """Times within each piece, close enough that no peak is missed; one row for each piece.

    A light driver's acceleration peaks within an angle of sqrt(rho) of the ends of a
    piece, and a slow driver passes much of the angle in little of the time. Hence the
    times are even in time and in angle, and ever closer towards both ends.
    """
    ends = np.geomspace(_NEAREST, 0.25, 48)
    shares = np.unique(np.concatenate([np.linspace(0.0, 1.0, 129), ends, 1.0 - ends]))
    low, high = bounds[:-1, None], bounds[1:, None]
    by_time = low + (high - low) * shares
    theta = motion.within(pieces, by_time).theta
    angles = theta[:, :1] + (theta[:, -1:] - theta[:, :1]) * shares
    by_angle = np.array(list(map(np.interp, angles, theta, by_time)))
    return np.sort(np.concatenate([by_time, by_angle], axis=1), axis=1)
