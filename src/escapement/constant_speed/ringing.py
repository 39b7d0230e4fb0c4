"""The ringing of a load on an elastic shaft that an indexing drive turns, compiled.

The wheel's motion is given, so the load's is exact without coupling: x, the angle of the load less
that of the wheel, obeys x'' + 2 zeta nu x' + nu^2 x = -g'(theta), with the driver angle as time
and nu the load's frequency over the driver's. With lambda = nu (-zeta + i sqrt(1 - zeta^2)) the
complex z = x' - conj(lambda) x obeys

    z' = lambda z - g',    x = Im z/Im lambda

which is solved on panels by Gauss' rule, exactly but for g'. After the index z turns and decays
freely, and |z|/Im lambda is the amplitude that is left.
"""

from typing import NamedTuple

import numpy as np

from escapement.mechanisms.slotted import pose_at, transmission_on
from escapement.numerics.gauss import POINTS, WEIGHTS, N
from escapement.numerics.jit import inner_jit, jit
from escapement.numerics.roots import newton_in_bracket

_MOST_PHASE = 0.5  # rad by which the load may swing on half a panel
_FOUND = 1e-7  # rad, a step of Newton's method after which the next one would be rounding
_WIDEST = 0.1  # rad, half the width of a panel


class Ringing(NamedTuple):
    """How a load rings, at rest before the index; angles in rad.

    deflection_max, deflection_max_angle : greatest magnitude of x, and the driver angle at which
        it is reached, which may lie behind the exit.
    residual_amplitude : amplitude that is left at the end of the index.
    """

    deflection_max: float
    deflection_max_angle: float
    residual_amplitude: float


NO_RINGING = Ringing(*3 * (float("nan"),))
"""Of a load on a rigid shaft."""


@inner_jit
def _advance(path, pose, left, right, z, decay):
    """z at `right` from that at `left`: exact for g' a polynomial times the free swing.

    `pose` has four rows of N numbers to work with.
    """
    half, (g, u, dg, radius) = 0.5 * (right - left), pose
    transmission_on(path, left, half, POINTS, g.size, g, u, dg, radius)
    total, whole = 0.0 + 0.0j, np.exp(decay * half)
    for i in range(N // 2):
        # the points lie symmetrically about the middle
        swing = np.exp(decay * (half * POINTS[i]))
        total -= WEIGHTS[i] * (dg[i] / swing + dg[N - 1 - i] * swing)
    return whole * (z * whole + half * total)


@inner_jit
def _speed(z, decay):
    """x' of z."""
    return z.real + decay.real * z.imag / decay.imag


@jit(allocates=True)
def deflections(path, edges, frequency, damping, theta):
    """x at ascending driver angles, of the free swing where they are behind the index."""
    decay = frequency * (-damping + 1j * np.sqrt(1.0 - damping * damping))
    found = np.empty(theta.size)
    z, at, j, pose = 0.0 + 0.0j, edges[0], 1, np.empty((4, N))
    for i in range(theta.size):
        while j < edges.size and edges[j] <= theta[i]:
            z, at, j = _over(path, pose, at, edges[j], z, decay), edges[j], j + 1
        if j < edges.size:
            z = _over(path, pose, at, theta[i], z, decay)
        else:
            z = z * np.exp(decay * (theta[i] - at))
        at = theta[i]
        found[i] = z.imag / decay.imag
    return found


@inner_jit
def _over(path, pose, start, end, z, decay):
    """z at `end`, over as many panels as that needs."""
    width = min(_WIDEST, _MOST_PHASE / abs(decay))
    count = max(1, int(np.ceil(0.5 * (end - start) / width)))
    for k in range(count):
        left, right = (
            start + (end - start) * (k / count),
            start + (end - start) * ((k + 1) / count),
        )
        z = _advance(path, pose, left, right, z, decay)
    return z


@jit(allocates=True)
def ringing(path, edges, frequency, damping):
    """How the load rings.

    Parameters
    ----------
    path : Path of the mechanism.
    edges : driver angles between which g' is smooth, from entry to exit, ascending [rad].
    frequency : angular frequency of the load on its shaft over the driver's speed; > 0.
    damping : share of critical damping, at least 0 and below 1.

    Returns
    -------
    Ringing
    """
    decay = frequency * (-damping + 1j * np.sqrt(1.0 - damping * damping))
    width = min(_WIDEST, _MOST_PHASE / abs(decay))
    weights, pose, inner = np.empty(N, np.complex128), np.empty((4, N)), np.empty((4, N))
    g, u, dg, radius = pose
    z, top, top_angle = 0.0 + 0.0j, 0.0, edges[0]
    for j in range(edges.size - 1):
        count = max(1, int(np.ceil((edges[j + 1] - edges[j]) / (2.0 * width))))
        step = (edges[j + 1] - edges[j]) / count
        swing = np.exp(decay * step)
        for i in range(N):
            weights[i] = 0.5 * step * WEIGHTS[i] * np.exp(decay * (0.5 * step * (1.0 - POINTS[i])))
        for k in range(count):
            left = edges[j] + k * step
            right = edges[j + 1] if k == count - 1 else edges[j] + (k + 1) * step
            transmission_on(path, left, 0.5 * step, POINTS, weights.size, g, u, dg, radius)
            after = z * swing
            for i in range(N):
                after -= weights[i] * dg[i]
            turns = _speed(z, decay) * _speed(after, decay) < 0.0
            # a swing of at most a radian adds less than this to the values at its ends
            nearly = 1.3 * max(abs(z.imag), abs(after.imag)) / decay.imag
            if turns and nearly > top:
                at, inside = _turn(path, inner, left, right, z, after, decay)
                size = abs(inside.imag / decay.imag)
                if size > top:
                    top, top_angle = size, at
            z = after
    # in the free swing x' is zero where z (Im lambda - i Re lambda) is imaginary
    phase = np.arctan2(
        z.imag * decay.imag - z.real * decay.real, z.real * decay.imag + z.imag * decay.real
    )
    later = ((0.5 * np.pi - phase) % np.pi) / decay.imag
    swung = abs((z * np.exp(decay * later)).imag / decay.imag)
    if swung > top:
        top, top_angle = swung, edges[-1] + later
    return Ringing(top, top_angle, abs(z) / decay.imag)


@inner_jit
def _turn(path, pose, left, right, z, after, decay):
    """Where x' changes its sign on a panel, by Newton's method, and z there."""
    first, last, low, high = _speed(z, decay), _speed(after, decay), left, right
    theta, found = left + (right - left) * first / (first - last), z
    for _ in range(60):
        found = _advance(path, pose, left, theta, z, decay)
        speed, size = _speed(found, decay), decay.real**2 + decay.imag**2
        _g, _u, dg, _radius = pose_at(path, theta)
        bend = 2.0 * decay.real * speed - size * found.imag / decay.imag - dg
        guess, low, high = newton_in_bracket(theta, speed, bend, low, high, first < 0.0)
        step = abs(guess - theta)
        theta = guess
        if step <= _FOUND:
            break
    return theta, found
