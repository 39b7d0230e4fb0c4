"""Contact with a wall over a panel of driver angles.

Twice the kinetic energy, E = (rho + g^2) w, obeys dE/dx = A - B E with `dynamics.law.energy_rates`,
so that with b = int B it is E = exp(-b) (E_left + int A exp(b)). Time is int dtheta/sqrt(w).
A panel is halved until what it leaves out is small; see `gauss`.

Where a row of its solution changes its sign, such as s X at a lift-off, a panel is cut: Newton's
method finds the place, and the panel is solved again up to there.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.dynamics.law import (
    contact,
    dragged_slope,
    energy_rates,
    friction_ratio,
    is_viscous,
    net_torque,
    reduced_inertia,
    root_of,
    wall_state,
)
from escapement.dynamics.load import has_load_curve, load_at
from escapement.dynamics.power_flow import UNKNOWN
from escapement.dynamics.torque import REST, torque_at
from escapement.dynamics.train_losses import within_flow
from escapement.mechanisms.slotted import pose_at, transmission_on
from escapement.numerics.gauss import (
    POINTS,
    N,
    cumulate,
    fill_decay,
    first_change,
    integral,
    root_between,
    series_at,
    tail_of,
    to_powers,
)
from escapement.numerics.jit import inner_jit

SMALLEST = 1e-12
"""A panel of a smaller width [rad] is not halved."""
_SAME = 1e-9
"""Torque through a train that counts as zero where the pin lifts off, over that of the drive."""


_FAILED = Ending.STOPPED, Ending.JAM
"""Endings of a panel without a solution."""


class WallPanel(NamedTuple):
    """A solved panel.

    ending : TOUCHES, where the contact goes on, LIFTED, BARREL_TURNED, LOAD_TURNED or RESTED, where
        it is cut; STOPPED, where the driver stops, or JAM, where J_s is not positive: it has no
        solution then.
    left, width : start and width; width < 0 if the driver turns back.
    w, time : squared speed at its end, and duration. tail : estimate of its error.
    """

    ending: Ending
    left: float
    width: float
    w: float
    time: float
    tail: float


@inner_jit
def _unsolved(ending, left, width):
    """A panel without a solution."""
    return WallPanel(ending=ending, left=left, width=width, w=0.0, time=0.0, tail=1.0)


@inner_jit
def has_failed(panel):
    """Whether a panel has no solution."""
    return panel.ending in _FAILED


@inner_jit
def _kept_at(scene, side, theta, w, ending):
    """s X, a torque through a train, or the energy above that of bodies at rest: what is positive
    up to a panel's end of this kind.
    """
    now = wall_state(theta, w, side, scene)
    if ending == Ending.LIFTED:
        return side * now.moment
    if ending == Ending.RESTED:
        return (scene.rho + now.g * now.g) * w - scene.rho * REST
    q, z = within_flow(now.g, now.k, now.rate, now.pull, w, scene)
    return q if ending == Ending.BARREL_TURNED else z


@inner_jit
def _sample(work, scene, side, left, half):
    """Fill the rows that do not depend on the speed; returns whether J_s is positive throughout."""
    count, g, u, k, radius = work.points, work.g, work.u, work.k, work.radius
    transmission_on(scene.path, left, half, work.nodes, count, g, u, k, radius)
    middle, slope = torque_at(left + half, scene)
    middle, slope, unsound = middle - scene.bearing, slope * half, 0
    for i in range(count & N):
        k[i] = dragged_slope(g[i], k[i], scene)
        work.c[i] = c = friction_ratio(g[i], u[i], radius[i], side, scene)
        work.inverse_inertia[i] = 1.0 / (scene.rho + g[i] * g[i])
        work.pull[i] = middle + slope * work.nodes[i]
        unsound += not reduced_inertia(g[i], c, scene) > 0.0
    if has_load_curve(scene):
        for i in range(count & N):
            work.load[i] = load_at(left + half * (1.0 + work.nodes[i]), side, scene)
    return unsound == 0


@inner_jit
def _solve_energy(work, scene, half, energy):
    """Fill E and w from E at the left end, with drag linear about the speeds in w before.

    Returns E at the right end.
    """
    count, viscous = work.points, is_viscous(scene)
    for i in range(count & N):
        root = np.sqrt(max(work.w[i], 1e-300)) if viscous else 0.0
        c, k, pull, inverse = work.c[i], work.k[i], work.pull[i], work.inverse_inertia[i]
        rates = energy_rates(work.g[i], c, k, pull, inverse, half, root, scene, work.load[i])
        work.gain[i], work.decay[i] = rates[0], rates[1]
    cumulate(work.decay, work.exponent)
    fill_decay(work.exponent, work.alpha, work.gain, count)
    cumulate(work.gain, work.energy)
    for i in range(count & N):
        work.energy[i] = work.alpha[i] * (energy + work.energy[i])
        work.w[i] = work.energy[i] * work.inverse_inertia[i]
    return np.exp(-integral(work.decay, count)) * (energy + integral(work.gain, count))


@inner_jit
def solve_panel(work, scene, side, left, width, w):
    """Solve a panel from the squared speed `w` at its start; `work` then holds the solution."""
    count, half = work.points, 0.5 * width
    if not _sample(work, scene, side, left, half):
        return _unsolved(Ending.JAM, left, width)
    ratio, right = pose_at(scene.path, left)[0], pose_at(scene.path, left + width)[0]
    energy = (scene.rho + ratio * ratio) * w
    viscous, change, at_end = is_viscous(scene), 1.0, 0.0
    for i in range(count & N):
        work.w[i] = energy * work.inverse_inertia[i]
    for _ in range(30):
        for i in range(count & N):
            work.w_before[i] = work.w[i]
        at_end = _solve_energy(work, scene, half, energy)
        if not viscous:
            break
        change = 0.0
        for i in range(N):
            value = work.w[i]
            change = max(change, abs(value - work.w_before[i]) / max(value, 1e-300))
        # where the driver stops, drag that is linear about its speed would grow without bound
        if not change < 1e6:
            return _unsolved(Ending.STOPPED, left, width)
        # Newton's method squares the error, so the next change would be below rounding
        if change <= 1e-7:
            break
    at_end /= scene.rho + right * right
    slowest, greatest = at_end, energy
    for i in range(N):
        slowest, greatest = min(slowest, work.w[i]), max(greatest, work.energy[i])
    if not slowest > 0.0:
        return _unsolved(Ending.STOPPED, left, width)
    for i in range(count & N):
        g, k, pull, squared, load = work.g[i], work.k[i], work.pull[i], work.w[i], work.load[i]
        root = root_of(squared, scene)
        work.slowness[i] = half / np.sqrt(squared)
        work.force[i] = side * contact(g, k, pull, squared, root, scene, load)
        work.net_torque[i] = net_torque(g, work.c[i], k, pull, squared, root, scene, load)
    if scene.flow != UNKNOWN:
        _fill_flow(work, scene)
    tail = tail_of(work.energy, count) / greatest
    tail = max(tail, tail_of(work.slowness, count) * np.sqrt(slowest) / abs(half))
    tail = max(tail, tail_of(work.inverse_inertia, count) * scene.rho)
    time = abs(integral(work.slowness, count))
    return WallPanel(ending=Ending.TOUCHES, left=left, width=width, w=at_end, time=time, tail=tail)


@inner_jit
def _fill_flow(work, scene):
    """Fill the rows of the torques through lossy trains."""
    for i in range(N):
        g, k, pull, w = work.g[i], work.k[i], work.pull[i], work.w[i]
        rate = work.net_torque[i] / reduced_inertia(g, work.c[i], scene)
        work.barrel_torque[i], work.load_torque[i] = within_flow(g, k, rate, pull, w, scene)


@inner_jit
def width_after(found, tail):
    """Width to try behind a panel, which has a tail of about the one that a panel may have."""
    return found.width * min(2.0, (tail / found.tail) ** (1.0 / N))


@inner_jit
def next_panel(work, scene, side, theta, w, width, limit, tail, lifts):
    """Solve the panel from a driver angle towards a limit, as wide as its `tail` may be.

    `width` is the width to try first, infinite where none is known. With `lifts` the panel ends
    where the pin lifts off. In any case it ends where power in a train turns back.
    """
    span = limit - theta
    if abs(width) < np.inf and not abs(width) < 0.9 * abs(span):
        width = span
    elif abs(width) > 0.5 * abs(span):
        width = 0.5 * span
    found = solve_panel(work, scene, side, theta, width, w)
    # a tail that is NaN counts as large
    while has_failed(found) or not found.tail <= tail:
        if abs(width) < SMALLEST:
            break
        width *= 0.5
        found = solve_panel(work, scene, side, theta, width, w)
    if has_failed(found):
        return found
    if lifts:
        found = _cut(work, scene, side, found, w, work.force, Ending.LIFTED)
    # without inertia behind it the power of a train keeps its direction
    if scene.flow != UNKNOWN and scene.barrel > 0.0 and scene.barrel_efficiency != 1.0:
        found = _cut(work, scene, side, found, w, work.barrel_torque, Ending.BARREL_TURNED)
    if scene.flow != UNKNOWN and scene.load_train > 0.0 and scene.load_train_efficiency != 1.0:
        found = _cut(work, scene, side, found, w, work.load_torque, Ending.LOAD_TURNED)
    return found


@inner_jit
def slowed(work, scene, side, panel, w):
    """The panel, or its part up to where viscous drag alone has slowed the bodies to rest."""
    for i in range(N):
        work.above_rest[i] = work.energy[i] - scene.rho * REST
    return _cut(work, scene, side, panel, w, work.above_rest, Ending.RESTED)


@inner_jit
def flow_behind(panel, flow, ends):
    """The flow of power behind a panel in a flow; unknown where the panel `ends` at a break."""
    if panel.ending == Ending.BARREL_TURNED:
        return flow + (1.0 if flow == 0.0 or flow == 2.0 else -1.0)
    if panel.ending == Ending.LOAD_TURNED:
        return flow + (2.0 if flow < 2.0 else -2.0)
    return UNKNOWN if ends else flow


@inner_jit
def _first_dip(work, values):
    """Points x between which a row first becomes zero that is positive at all points; 2 for the
    second one if it stays positive."""
    to_powers(values, work.series)
    for k in range(N):
        work.series_slope[k] = (k + 1) * work.series[k + 1] if k + 1 < N else 0.0
    for i in range(1, N - 1):
        if values[i] <= values[i - 1] and values[i] <= values[i + 1]:
            low, high = POINTS[i - 1], POINTS[i + 1]
            least = root_between(work.series_slope, POINTS[i], low, high, True)[0]
            if series_at(work.series, least) < 0.0:
                return (low if least < POINTS[i] else POINTS[i]), least
    return 1.0, 2.0


@inner_jit
def _cut(work, scene, side, panel, w, values, ending):
    """The panel, or its part up to where a row first becomes zero, which then has this ending."""
    if has_failed(panel):
        return panel
    theta, width, found = panel.left, panel.width, panel
    at_end = _kept_at(scene, side, theta + width, panel.w, ending)
    # without a load the force and the power of its train become zero at the same angle
    at_end += _SAME if panel.ending == Ending.LIFTED else 0.0
    low, high = first_change(values, 1.0, at_end)
    if high > 1.0 and ending != Ending.LIFTED:
        low, high = _first_dip(work, values)
    if high > 1.0:
        return panel
    to_powers(values, work.series)
    x, slope = root_between(work.series, 0.5 * (low + high), low, high, False)
    slope *= 2.0 / width
    width *= 0.5 * (1.0 + x)
    for _ in range(8):
        found = solve_panel(work, scene, side, theta, width, w)
        more = -_kept_at(scene, side, theta + width, found.w, ending) / slope
        # the motion itself depends on the lift-off by the cube of its error
        if has_failed(found) or not abs(more) > 1e-11 or abs(more) > 0.1 * abs(width):
            break
        width += more
    return WallPanel(
        ending=ending, left=theta, width=width, w=found.w, time=found.time, tail=found.tail
    )
