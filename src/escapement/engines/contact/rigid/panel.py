"""Contact with a wall over a panel of driver angles.

Twice the kinetic energy, E = (rho + g^2) w, obeys dE/dx = A - B E with `dynamics.law.energy_rates`,
so that with b = int B it is E = exp(-b) (E_left + int A exp(b)). Time is int dtheta/sqrt(w).
A panel is halved until what it leaves out is small; see `gauss`.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import (
    bend,
    contact,
    dragged_slope,
    energy_rates,
    is_viscous,
    net_torque,
    reduced_inertia,
    root_of,
)
from escapement.dynamics.torque import REST, torque_at
from escapement.dynamics.train_losses import UNKNOWN, within_flow
from escapement.mechanisms.slotted import pose_at, transmission_on
from escapement.numerics.gauss import (
    POINTS,
    N,
    cumulate,
    fill_decay,
    integral,
    root_between,
    series_at,
    tail_of,
    to_powers,
)
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

_ROWS = (
    *("g", "u", "slope", "radius", "bend", "inverse", "pull", "decay", "gain", "b", "energy"),
    *("w", "slow", "net", "places", "x", "q", "z"),
)
G, U, SLOPE, RADIUS, BEND, INVERSE, PULL, DECAY, GAIN, B, ENERGY = _ROWS[:11]
W, SLOW, NET, PLACES, X, Q, Z = _ROWS[11:]
"""Rows of the workspace: values at the Gauss points. PLACES are those points, NET the torque that
accelerates the driver, SLOW is dt/dx and SLOPE the k of `dynamics`. X is s X; Q and Z are the
torques through lossy trains, positive while the power flows the same way."""
# fields of a record do not overlap, so that loops over them become vector code
WORKSPACE = record_dtype(dict.fromkeys(_ROWS, (np.float64, N)))
GOES_ON, LIFTS, TURNS_BARREL, TURNS_LOAD, RESTS, STOPS, JAMS = range(7)
"""How a panel ends: while the contact lasts, at a lift-off, where power in the barrel's train
or in that of the load turns back, where bodies that nothing drives count as at rest, where the
driver stops, or where J_s is not positive."""
SMALLEST = 1e-12
"""A panel of a smaller width [rad] is not halved."""
_SAME = 1e-9
"""Torque through a train that counts as zero where the pin lifts off, over that of the drive."""


class Panel(NamedTuple):
    """A solved panel.

    code : how it ends. left, width : start and width; width < 0 if the driver turns back.
    w, time : squared speed at its end, and duration. tail : estimate of its error.
    """

    code: int
    left: float
    width: float
    w: float
    time: float
    tail: float


@inner_jit
def law_at(scene, side, theta, w):
    """s X and theta_ddot in contact with a wall, and whether J_s is positive."""
    g, u, dg, radius = pose_at(scene.path, theta)
    k, c = dragged_slope(g, dg, scene), bend(g, u, radius, side, scene)
    pull, root = torque_at(theta, scene)[0] - scene.bearing, root_of(w, scene)
    inertia = reduced_inertia(g, c, scene)
    rate = net_torque(g, c, k, pull, w, root, scene) / inertia
    return side * contact(g, k, pull, w, root, scene), rate, inertia > 0.0


@inner_jit
def _kept_at(scene, side, theta, w, code):
    """s X, a torque through a train, or the energy above that of bodies at rest: what is positive
    up to a panel's end with this code.
    """
    force, rate, _sound = law_at(scene, side, theta, w)
    if code == LIFTS:
        return force
    g, _u, dg, _radius = pose_at(scene.path, theta)
    if code == RESTS:
        return (scene.rho + g * g) * w - scene.rho * REST
    pull = torque_at(theta, scene)[0] - scene.bearing
    q, z = within_flow(g, dragged_slope(g, dg, scene), rate, pull, w, scene)
    return q if code == TURNS_BARREL else z


@inner_jit
def _sample(work, scene, side, left, half, count):
    """Fill the rows that do not depend on the speed; returns whether J_s is positive throughout."""
    g, u, k, radius = work[G], work[U], work[SLOPE], work[RADIUS]
    transmission_on(scene.path, left, half, work[PLACES], count, g, u, k, radius)
    middle, slope = torque_at(left + half, scene)
    middle, slope, unsound = middle - scene.bearing, slope * half, 0
    for i in range(count & N):
        k[i] = dragged_slope(g[i], k[i], scene)
        work[BEND][i] = c = bend(g[i], u[i], radius[i], side, scene)
        work[INVERSE][i] = 1.0 / (scene.rho + g[i] * g[i])
        work[PULL][i] = middle + slope * work[PLACES][i]
        unsound += not reduced_inertia(g[i], c, scene) > 0.0
    return unsound == 0


@inner_jit
def _solve_energy(work, scene, half, energy, count):
    """Fill E and w from E at the left end, with drag linear about the speeds in w before.

    Returns E at the right end.
    """
    viscous = is_viscous(scene)
    for i in range(count & N):
        root = np.sqrt(max(work[W][i], 1e-300)) if viscous else 0.0
        c, k, pull, inverse = work[BEND][i], work[SLOPE][i], work[PULL][i], work[INVERSE][i]
        rates = energy_rates(work[G][i], c, k, pull, inverse, half, root, scene)
        work[GAIN][i], work[DECAY][i] = rates[0], rates[1]
    cumulate(work[DECAY], work[B])
    fill_decay(work[B], work[SLOW], work[GAIN], count)
    cumulate(work[GAIN], work[ENERGY])
    for i in range(count & N):
        work[ENERGY][i] = work[SLOW][i] * (energy + work[ENERGY][i])
        work[W][i] = work[ENERGY][i] * work[INVERSE][i]
    return np.exp(-integral(work[DECAY], count)) * (energy + integral(work[GAIN], count))


@inner_jit
def solve_panel(work, scene, side, left, width, w, count):
    """Solve a panel from the squared speed `w` at its start; `work` then holds the solution."""
    half = 0.5 * width
    if not _sample(work, scene, side, left, half, count):
        return Panel(JAMS, left, width, 0.0, 0.0, 1.0)
    ratio, right = pose_at(scene.path, left)[0], pose_at(scene.path, left + width)[0]
    energy = (scene.rho + ratio * ratio) * w
    viscous, change, at_end = is_viscous(scene), 1.0, 0.0
    for i in range(count & N):
        work[W][i] = energy * work[INVERSE][i]
    for _ in range(30):
        for i in range(count & N):
            work[X][i] = work[W][i]
        at_end = _solve_energy(work, scene, half, energy, count)
        if not viscous:
            break
        change = 0.0
        for i in range(N):
            value = work[W][i]
            change = max(change, abs(value - work[X][i]) / max(value, 1e-300))
        # where the driver stops, drag that is linear about its speed would grow without bound
        if not change < 1e6:
            return Panel(STOPS, left, width, 0.0, 0.0, 1.0)
        # Newton's method squares the error, so the next change would be below rounding
        if change <= 1e-7:
            break
    at_end /= scene.rho + right * right
    slowest, greatest = at_end, energy
    for i in range(N):
        slowest, greatest = min(slowest, work[W][i]), max(greatest, work[ENERGY][i])
    if not slowest > 0.0:
        return Panel(STOPS, left, width, 0.0, 0.0, 1.0)
    for i in range(count & N):
        g, k, pull, speed = work[G][i], work[SLOPE][i], work[PULL][i], work[W][i]
        root = root_of(speed, scene)
        work[SLOW][i] = half / np.sqrt(speed)
        work[X][i] = side * contact(g, k, pull, speed, root, scene)
        work[NET][i] = net_torque(g, work[BEND][i], k, pull, speed, root, scene)
    if scene.flow != UNKNOWN:
        _fill_flow(work, scene)
    tail = tail_of(work[ENERGY], count) / greatest
    tail = max(tail, tail_of(work[SLOW], count) * np.sqrt(slowest) / abs(half))
    tail = max(tail, tail_of(work[INVERSE], count) * scene.rho)
    return Panel(GOES_ON, left, width, at_end, abs(integral(work[SLOW], count)), tail)


@inner_jit
def _fill_flow(work, scene):
    """Fill the rows of the torques through lossy trains."""
    for i in range(N):
        g, k, pull, w = work[G][i], work[SLOPE][i], work[PULL][i], work[W][i]
        rate = work[NET][i] / reduced_inertia(g, work[BEND][i], scene)
        work[Q][i], work[Z][i] = within_flow(g, k, rate, pull, w, scene)


@inner_jit
def width_after(found, tail):
    """Width to try behind a panel, which has a tail of about the one that a panel may have."""
    return found.width * min(2.0, (tail / found.tail) ** (1.0 / N))


@inner_jit
def next_panel(work, scene, side, theta, w, width, limit, tail, lifts, count):
    """Solve the panel from a driver angle towards a limit, as wide as its `tail` may be.

    `width` is the width to try first, infinite where none is known. With `lifts` the panel ends
    where the pin lifts off. In any case it ends where power in a train turns back.
    """
    span = limit - theta
    if abs(width) < np.inf and not abs(width) < 0.9 * abs(span):
        width = span
    elif abs(width) > 0.5 * abs(span):
        width = 0.5 * span
    found = solve_panel(work, scene, side, theta, width, w, count)
    # a tail that is NaN counts as large
    while found.code != GOES_ON or not found.tail <= tail:
        if abs(width) < SMALLEST:
            break
        width *= 0.5
        found = solve_panel(work, scene, side, theta, width, w, count)
    if found.code != GOES_ON:
        return found
    if lifts:
        found = _ended(work, scene, side, found, w, work[X], LIFTS, count)
    # without inertia behind it the power of a train keeps its direction
    if scene.flow != UNKNOWN and scene.barrel > 0.0 and scene.barrel_efficiency != 1.0:
        found = _ended(work, scene, side, found, w, work[Q], TURNS_BARREL, count)
    if scene.flow != UNKNOWN and scene.load_train > 0.0 and scene.load_train_efficiency != 1.0:
        found = _ended(work, scene, side, found, w, work[Z], TURNS_LOAD, count)
    return found


@inner_jit
def slowed(work, scene, side, panel, w, count):
    """The panel, or its part up to where viscous drag alone has slowed the bodies to rest."""
    for i in range(N):
        work[Q][i] = work[ENERGY][i] - scene.rho * REST
    return _ended(work, scene, side, panel, w, work[Q], RESTS, count)


@inner_jit
def flow_behind(panel, flow, ends):
    """The flow of power behind a panel in a flow; unknown where the panel `ends` at a break."""
    if panel.code == TURNS_BARREL:
        return flow + (1.0 if flow == 0.0 or flow == 2.0 else -1.0)
    if panel.code == TURNS_LOAD:
        return flow + (2.0 if flow < 2.0 else -2.0)
    return UNKNOWN if ends else flow


@inner_jit
def _first_change(values, at_end):
    """Places between which a row first becomes zero; they are equal where it stays positive."""
    low = -1.0
    for i in range(N):
        if not values[i] > 0.0:
            return low, POINTS[i]
        low = POINTS[i]
    return low, 1.0 if not at_end > 0.0 else low


@inner_jit
def _first_dip(work, values):
    """As `_first_change`, of a row that is positive at all points but may not be between two."""
    to_powers(values, work[B])
    for k in range(N):
        work[DECAY][k] = (k + 1) * work[B][k + 1] if k + 1 < N else 0.0
    for i in range(1, N - 1):
        if values[i] <= values[i - 1] and values[i] <= values[i + 1]:
            low, high = POINTS[i - 1], POINTS[i + 1]
            least = root_between(work[DECAY], POINTS[i], low, high, True)[0]
            if series_at(work[B], least) < 0.0:
                return (low if least < POINTS[i] else POINTS[i]), least
    return 1.0, 1.0


@inner_jit
def _ended(work, scene, side, panel, w, values, code, count):
    """The panel, or its part up to where a row first becomes zero, which ends with a code."""
    if panel.code >= STOPS:
        return panel
    theta, width, found = panel.left, panel.width, panel
    at_end = _kept_at(scene, side, theta + width, panel.w, code)
    # without a load the force and the power of its train become zero at the same place
    at_end += _SAME if panel.code == LIFTS else 0.0
    low, high = _first_change(values, at_end)
    if low == high and code != LIFTS:
        low, high = _first_dip(work, values)
    if low == high:
        return panel
    to_powers(values, work[B])
    x, slope = root_between(work[B], 0.5 * (low + high), low, high, False)
    slope *= 2.0 / width
    width *= 0.5 * (1.0 + x)
    for _ in range(8):
        found = solve_panel(work, scene, side, theta, width, w, count)
        more = -_kept_at(scene, side, theta + width, found.w, code) / slope
        # the motion itself depends on the lift-off by the cube of its error
        if found.code != GOES_ON or not abs(more) > 1e-11 or abs(more) > 0.1 * abs(width):
            break
        width += more
    return Panel(code, theta, width, found.w, found.time, found.tail)
