"""The reference engine: SciPy's solve_ivp in the time domain.

Each smooth piece is integrated on its own with a fixed side of the slot, from
one break of the mechanism to the next or to the pin reversal before it. Time is
measured in units of sqrt(I_f/torque), so the tolerance means the same thing for
a watch and a turret. The state carries the friction loss, so that the energy
ledger is an independent check.

solve_ivp looks at its event functions at the ends of steps only and misses two
crossings inside one; every piece is therefore searched again on its dense output.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from escapement._jit import jit
from escapement.dynamics import (
    acceleration,
    bend,
    contact,
    contact_moment,
    critical_friction,
    side_at,
)
from escapement.dynamics import tabulate as tabulate_motion
from escapement.mechanisms._slotted import transmission_at
from escapement.model import Escapement, FloatArray
from escapement.motion import Events, Extrema, Motion, no_motion, stall_message
from escapement.status import MESSAGES, Status

_PER_STEP = 8  # looks per solver step when searching the dense output for crossings
_TIGHTER = 0.02  # local tolerance over the one asked for: errors add up over a run
_FLOOR = 2.3e-14  # solve_ivp clips a smaller rtol with a warning
_CEILING = 1e-9  # with longer steps a solver leaps over the narrow peak of 1/J near the limit


@jit(allocates=True)
def _derivative(x, y, path, sign, rho, mu, load):
    """Right-hand side for y = (theta, theta_dot, friction loss) in natural units."""
    out = np.empty(3)
    g, u, dg = transmission_at(path, y[0])
    w = y[1] * y[1]
    out[0] = y[1]
    out[1] = acceleration(g, u, dg, w, sign, rho, mu, load)
    out[2] = abs(bend(sign, mu) * u * contact_moment(g, u, dg, w, sign, rho, mu, load)) * y[1]
    return out


@dataclass
class _Pieces:
    """Growing trajectory: one dense solution per piece (None while locked)."""

    clock: float
    torque: float
    start: Any = field(default_factory=list)
    engagement: Any = field(default_factory=list)
    sign: Any = field(default_factory=list)
    friction_loss: Any = field(default_factory=list)
    solution: list[Any] = field(default_factory=list)
    reversals: Any = None
    extrema: Any = None

    def add(self, x: float, engagement: int, sign: float, loss: float, solution: Any) -> None:
        self.start.append(x * self.clock)
        self.engagement.append(engagement)
        self.sign.append(sign)
        self.friction_loss.append(loss * self.torque)
        self.solution.append(solution)

    def freeze(self) -> None:
        for name in ("start", "engagement", "sign", "friction_loss"):
            kind = int if name == "engagement" else float
            setattr(self, name, np.array(getattr(self, name), dtype=kind))

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece."""
        y = self.solution[piece](t / self.clock)
        return y[0], y[1] / self.clock


@dataclass(frozen=True)
class _Free:
    """Driver turning alone under the torque: exact."""

    x: float
    theta: float
    speed: float
    rho: float

    def __call__(self, x: FloatArray) -> FloatArray:
        s = x - self.x
        theta = self.theta + s * (self.speed + s / (2.0 * self.rho))
        return np.array([theta, self.speed + s / self.rho, 0.0 * s])


@dataclass
class _Run:
    """One simulation in natural units, advanced piece by piece."""

    path: FloatArray
    rho: float
    mu: tuple[float, float]
    load: float
    cell: float
    clock: float
    options: dict[str, Any]
    horizon: float
    pieces: _Pieces
    x: float = 0.0
    theta: float = 0.0
    speed: float = 0.0
    engagement: int = 0
    rising: float = 0.0
    reversals: list[tuple[float, ...]] = field(default_factory=list)
    extrema: list[tuple[float, ...]] = field(default_factory=list)
    stalled: bool = False

    def at_horizon(self) -> bool:
        return self.x >= self.horizon

    def side(self) -> float:
        g, _, dg = transmission_at(self.path, self.theta)
        return side_at(g, dg, self.speed**2, self.rho, self.load)

    def engage(self, end: float) -> None:
        """Advance to the break at `end`, through any reversals."""
        sign = self.side()
        while self.theta < end and not (self.stalled or self.at_horizon()):
            if self._piece(end, sign):
                self.reversals.append((self.engagement, self.x, self.theta, self.speed))
                sign = -sign

    def _piece(self, end: float, sign: float) -> bool:
        """Integrate one smooth piece; True if it ends in a pin reversal."""
        path, rho, mu, load = self.path, self.rho, self.mu, self.load
        arguments = (path, sign, rho, mu, load)
        if self.speed <= 0.0:
            start = _derivative(0.0, np.array([self.theta, 0.0, 0.0]), *arguments)
            if start[1] <= 0.0:
                self.stalled = True
                if not self.pieces.start:
                    still = _Free(self.x, self.theta, 0.0, np.inf)
                    self.pieces.add(self.x, self.engagement, sign, 0.0, still)
                return False

        def arrive(x: float, y: FloatArray, *_: Any) -> float:
            return y[0] - end

        def reverse(x: float, y: FloatArray, *_: Any) -> float:
            g, _u, dg = transmission_at(path, y[0])
            return contact(g, dg, y[1] * y[1], rho, load)

        def stop(x: float, y: FloatArray, *_: Any) -> float:
            return y[1]

        events: Any = (arrive, reverse, stop)
        for event, direction in zip(events, (1.0, -sign, -1.0), strict=True):
            event.terminal = True
            event.direction = direction
        # a trial step may leave the domain: its NaN makes the solver take a shorter one
        with np.errstate(all="ignore"):
            solved = solve_ivp(
                _derivative,
                (self.x, self.horizon),
                [self.theta, self.speed, 0.0],
                events=events,
                dense_output=True,
                args=arguments,
                **self.options,
            )
        if solved.status < 0:
            raise RuntimeError(f"solve_ivp gave up: {solved.message}")
        stopped_by = [times.size > 0 for times in solved.t_events]
        last = solved.t[-1]
        grid = _refine(solved.t)
        angle, speed = solved.sol(grid)[:2]
        table = np.empty((4, grid.size))
        tabulate_motion(path, angle, speed**2, sign, rho, mu, load, table)
        force = rho * (table[1] * speed**2 + load) + table[0]
        force[0] = sign * abs(force[0])  # a start on the reversal itself is not one

        def force_at(x: float) -> float:
            y = solved.sol(x)
            return reverse(x, y)

        reversed_here = stopped_by[1]
        hidden = _crossings(force_at, grid[:-1], force[:-1])
        if hidden:
            last, reversed_here = hidden[0], True
        self._record_extrema(solved.sol, grid, table[2], last, arguments)
        y = solved.sol(last)
        self.pieces.add(self.x, self.engagement, sign, y[2], solved.sol)
        self.x, self.theta, self.speed = last, float(y[0]), float(y[1])
        if stopped_by[0] and not reversed_here:
            self.theta = end
        self.stalled = stopped_by[2] and not reversed_here
        return reversed_here

    def _record_extrema(
        self, sol: Any, grid: FloatArray, rate: FloatArray, last: float, arguments: Any
    ) -> None:
        """Extrema of the speed within a piece and on its first corner."""
        kept = grid <= last

        def rate_at(x: float) -> float:
            return float(_derivative(x, sol(x), *arguments)[1])

        self._corner(rate[0])
        for x in _crossings(rate_at, grid[kept], rate[kept]):
            y = sol(x)
            self._extremum(x, float(y[0]), float(y[1]), self.rising > 0.0)
            self.rising = -self.rising
        self.rising = np.sign(rate_at(last)) or self.rising

    def _corner(self, rate: float) -> None:
        """An extremum where the acceleration jumps through zero."""
        now = np.sign(rate)
        if now * self.rising < 0.0:
            self._extremum(self.x, self.theta, self.speed, self.rising > 0.0)
        self.rising = now or self.rising

    def _extremum(self, x: float, theta: float, speed: float, maximum: bool) -> None:
        self.extrema.append((self.engagement, x, theta, speed, maximum))

    def dwell(self, end: float) -> None:
        """Turn free to the end of the cell: constant acceleration, closed form."""
        self._corner(1.0 / self.rho)
        angle = end - self.theta
        arrival = np.sqrt(self.speed**2 + 2.0 * angle / self.rho)
        length = 2.0 * angle / (self.speed + arrival)
        self.pieces.add(
            self.x, self.engagement, 0.0, 0.0, _Free(self.x, self.theta, self.speed, self.rho)
        )
        if self.x + length > self.horizon:
            self.x = self.horizon
            return
        self.x, self.theta, self.speed = self.x + length, end, float(arrival)


def simulate(
    escapement: Escapement,
    *,
    engagements: int | None,
    duration: float | None,
    initial_speed: float,
    rtol: float,
    atol: float | None,
    method: str,
    max_step: float,
) -> Motion:
    """Motion by solve_ivp; arguments are validated by `escapement.simulate`."""
    mechanism, clock = escapement.mechanism, escapement.time_unit
    rho = escapement.inertia_ratio
    if escapement.friction >= critical_friction(mechanism, escapement.inertia):
        return no_motion(escapement, "ivp", rtol)
    pieces = _Pieces(clock, escapement.torque)
    entry, end = mechanism.breaks[0], mechanism.breaks[0] + mechanism.cell_angle
    local = min(max(rtol * _TIGHTER, _FLOOR), _CEILING)
    fast = np.sqrt(2.0 * mechanism.cell_angle / (rho + 1.0))
    floor = (
        [local * 1e-2, local * 1e-2 * fast, local]
        if atol is None
        else [atol, atol * clock, atol / escapement.torque]
    )
    run = _Run(
        mechanism.path,
        rho,
        escapement.loss,
        escapement.load_ratio,
        mechanism.cell_angle,
        clock,
        {"rtol": local, "atol": floor, "method": method, "max_step": max_step / clock},
        np.inf if duration is None else duration / clock,
        pieces,
        theta=entry,
        speed=initial_speed * clock,
    )
    handoffs: list[tuple[float, float]] = []
    while not (run.stalled or run.at_horizon()):
        run.theta = entry
        for stop in mechanism.breaks[1:]:
            run.engage(stop)
        if run.stalled or run.at_horizon():
            break
        if end > mechanism.breaks[-1] + 1e-12:  # a dwell of one rounding error is none
            run.dwell(end)
            if run.at_horizon():
                break
        handoffs.append((run.x, run.speed))
        run.engagement += 1
        if run.engagement == engagements:
            break
    pieces.freeze()
    status, message = Status.OK, MESSAGES[Status.OK]
    if run.stalled:
        status = Status.STALL
        message = stall_message(run.theta, run.engagement)
    return _assemble(
        escapement, rtol, pieces, run.x, handoffs, run.reversals, run.extrema, status, message
    )


def _assemble(
    escapement: Escapement,
    rtol: float,
    pieces: _Pieces,
    x: float,
    handoffs: list[tuple[float, float]],
    reversals: list[tuple[float, ...]],
    extrema: list[tuple[float, ...]],
    status: Status,
    message: str,
) -> Motion:
    """From natural units to SI."""
    clock, cell = pieces.clock, escapement.mechanism.cell_angle

    def columns(rows: list[tuple[float, ...]], width: int) -> list[Any]:
        table = np.array(rows, dtype=float).reshape(-1, width).T
        index = table[0].astype(int)
        return [index, table[1] * clock, table[2] + index * cell, table[3] / clock, *table[4:]]

    times, speeds = np.array(handoffs, dtype=float).reshape(-1, 2).T
    peaks = columns(extrema, 5)
    pieces.reversals = Events(*columns(reversals, 4))
    index, time, theta, speed, maximum = peaks
    pieces.extrema = Extrema(index, time, theta, speed, maximum.astype(bool))
    return Motion(
        escapement,
        "ivp",
        rtol,
        pieces,
        x * clock,
        times * clock,
        speeds / clock,
        status,
        message,
    )


def _refine(times: FloatArray) -> FloatArray:
    """Solver steps with evenly spaced looks inside each."""
    inner = np.arange(_PER_STEP) / _PER_STEP
    looks = times[:-1, None] + np.diff(times)[:, None] * inner
    return np.append(looks.reshape(-1), times[-1])


def _crossings(function: Any, x: FloatArray, f: FloatArray) -> list[float]:
    """All roots of `function` given its values f at x, ascending.

    Where |f| has a local minimum without a change of sign the minimum itself is
    looked up, so that a pair of close roots is not lost.
    """
    x, f = _with_dips(function, x, f)
    changes = np.nonzero(f[:-1] * f[1:] < 0.0)[0]
    roots = [
        brentq(function, x[i], x[i + 1], xtol=1e-300, rtol=1e-15)
        if function(x[i]) * function(x[i + 1]) < 0.0
        else x[i]  # two reversals within rounding of each other: back at once
        for i in changes
    ]
    return [float(r) for r in roots]


def _with_dips(function: Any, x: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Samples, with the minimum of |f| added wherever f nearly turns back at zero."""
    size = np.abs(f)
    inner = np.nonzero(
        (size[1:-1] <= size[:-2])
        & (size[1:-1] <= size[2:])
        & (f[:-2] * f[1:-1] > 0.0)
        & (f[1:-1] * f[2:] > 0.0)
        & (size[1:-1] < 0.1 * size.max(initial=0.0))
    )[0]
    for i in inner[::-1] + 1:
        sense = np.sign(f[i])
        dip = minimize_scalar(
            lambda s, sense=sense: sense * function(s),
            bounds=(x[i - 1], x[i + 1]),
            method="bounded",
            options={"xatol": 1e-12 * (x[i + 1] - x[i - 1])},
        )
        if dip.fun < 0.0:
            at = np.searchsorted(x, dip.x)
            x, f = np.insert(x, at, dip.x), np.insert(f, at, sense * dip.fun)
    return x, f
