"""One step of the Radau IIA method of five stages, of order 9, for two coordinates.

The accelerations F_i at the nodes c_i of a step h are those of the law at the states to which
they lead,

    V_i = v + h sum_j a_ij F_j,        Q_i = q + h sum_j a_ij V_j.

Newton's method finds them, with the Jacobian at the start of the step. The eigenvalues lambda of
the matrix a_ij split its equations into pairs with the matrix 1 - h lambda J_v - (h lambda)^2 J_q.
The method is L-stable: hard walls, their damping and sticking friction do not make steps short.
The error is estimated by an embedded method of order 5, h gamma (f - P(0)), where P is the
polynomial through the F_i and f the acceleration at the start. Within the step P is used as the
acceleration.

The law is that of the class of `case`, a named tuple, which has three kernels: ``rates(case, y,
mode, out)`` writes the rates of a state, ``frequency(case, y, mode)`` is that of its fastest
swing, and ``left(case, y, mode, out, goal)``, with these rates, is positive before an event.

Source: Hairer and Wanner (1996), Solving Ordinary Differential Equations II, IV.5 and IV.8.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from escapement.dynamics.compliance import LOST, STATE, WALLS
from escapement.numerics.by_type import kernel_of_case
from escapement.numerics.jit import inner_jit

rates, frequency, left = map(kernel_of_case, ("rates", "frequency", "left"))

STAGES = 5
_POINTS = legendre.legroots([*[0.0] * (STAGES - 1), -1.0, 1.0])
NODES = 0.5 * (_POINTS + 1.0)
POWERS = np.linalg.inv(np.vander(NODES, STAGES, increasing=True))
"""Matrix from values at the nodes to the coefficients of the polynomial through them."""
MATRIX = np.vander(NODES, STAGES + 1, increasing=True)[:, 1:] / np.arange(1.0, STAGES + 1) @ POWERS
_values, _vectors = np.linalg.eig(MATRIX)
_kept = np.argsort(_values.imag)[STAGES // 2 :]
ROOTS = _values[_kept]
"""The real eigenvalue, and one of each conjugate pair."""
GAMMA = float(ROOTS[0].real)
APART = np.ascontiguousarray(np.linalg.inv(_vectors)[_kept])
TOGETHER = _vectors[:, _kept] * np.array([1.0, *[2.0] * (STAGES // 2)])
"""Matrix from values at the nodes to their components along eigenvectors, and the real part of its
inverse."""

_MOST_ITERATIONS = 8
_FARTHEST = 2.0
"""How many times longer a step may be than the one whose polynomial gives its first guess."""
_EXACT = 0.01
"""Newton's method ends when its error is this share of the tolerance."""
_EXACT_SPEED = 2e-15
ROUNDING = 4e-16
"""An event is located where its number is as near to zero as this."""
_SLOW = 0.1
"""Below this speed [sqrt(torque/I_f)] the error is no longer relative to the speed."""


class StepMemory(NamedTuple):
    """Arrays that a step reads and fills.

    stages : rates at the start, which the caller gives, and at the nodes, shape (1 + STAGES,
        STATE).
    end : the state after the step.
    flow : F, shape (STAGES, 2). series : its polynomial P, by powers of the time over `span`.
    span : length of the step to which that polynomial belongs, 0 if there is none, and the time
        in it at which the next step starts.
    tries : number of steps that were tried.
    spare, parts : memory of an iteration. slopes : J, shape (2, 4). inverses : inverses of the
        small matrices.
    """

    stages: NDArray[np.float64]
    end: NDArray[np.float64]
    flow: NDArray[np.float64]
    series: NDArray[np.float64]
    span: NDArray[np.float64]
    tries: NDArray[np.int64]
    spare: NDArray[np.float64]
    parts: NDArray[np.complex128]
    slopes: NDArray[np.float64]
    inverses: NDArray[np.complex128]


@inner_jit(allocates=True)
def workspace():
    """Memory for a step."""
    pairs = ROOTS.size
    return StepMemory(
        stages=np.empty((1 + STAGES, STATE)),
        end=np.empty(STATE),
        flow=np.empty((STAGES, 2)),
        series=np.empty((STAGES, 2)),
        span=np.zeros(2),
        tries=np.zeros(1, np.int64),
        spare=np.empty((STAGES, 2)),
        parts=np.empty((pairs, 2), np.complex128),
        slopes=np.empty((2, 4)),
        inverses=np.empty((pairs, 4), np.complex128),
    )


@inner_jit
def prepare(y, mode, case, work):
    """Compute the Jacobian at a state whose rates are known."""
    start, probe, found = work.stages[0], work.end, work.stages[1]
    for k in range(4):
        probe[0], probe[1], probe[2], probe[3] = y[0], y[1], y[2], y[3]
        probe[k] += 1e-9 if k < 2 else 1e-9 + 1e-3 * case.joint.slip
        rates(case, probe, mode, found)
        for i in range(2):
            work.slopes[i, k] = (found[2 + i] - start[2 + i]) / (probe[k] - y[k])


@inner_jit
def _invert(h, work):
    """Compute the inverses of the small matrices of a step."""
    slopes, inverses = work.slopes, work.inverses
    for m in range(ROOTS.size):
        g = h * ROOTS[m]
        a = 1.0 - g * (slopes[0, 2] + g * slopes[0, 0])
        b = -g * (slopes[0, 3] + g * slopes[0, 1])
        c = -g * (slopes[1, 2] + g * slopes[1, 0])
        d = 1.0 - g * (slopes[1, 3] + g * slopes[1, 1])
        over = 1.0 / (a * d - b * c)
        inverses[m, 0], inverses[m, 1] = d * over, -b * over
        inverses[m, 2], inverses[m, 3] = -c * over, a * over


@inner_jit
def _guess(h, work):
    """First guess of F: the polynomial of the step before, or the acceleration at the start."""
    flow, series, ratio = work.flow, work.series, h / work.span[0]
    for k in range(2):
        for i in range(STAGES):
            flow[i, k] = work.stages[0, 2 + k]
            if ratio <= _FARTHEST:
                x = work.span[1] + NODES[i] * ratio
                value = 0.0
                for power in range(STAGES - 1, -1, -1):
                    value = value * x + series[power, k]
                flow[i, k] = value


@inner_jit
def _evaluate(y, h, mode, case, work):
    """Compute the rates at the nodes that follow from F; the last node is the end of the step."""
    stages, flow, end = work.stages, work.flow, work.end
    for i in range(STAGES):
        v = w = 0.0
        for j in range(STAGES):
            v += MATRIX[i, j] * flow[j, 0]
            w += MATRIX[i, j] * flow[j, 1]
        work.spare[i, 0], work.spare[i, 1] = y[2] + h * v, y[3] + h * w
    for i in range(STAGES):
        p = q = 0.0
        for j in range(STAGES):
            p += MATRIX[i, j] * work.spare[j, 0]
            q += MATRIX[i, j] * work.spare[j, 1]
        end[0], end[1] = y[0] + h * p, y[1] + h * q
        end[2], end[3] = work.spare[i, 0], work.spare[i, 1]
        rates(case, end, mode, stages[1 + i])


@inner_jit
def _correct(work):
    """Take one step of Newton's method; returns the greatest change of F."""
    inverses, parts = work.inverses, work.parts
    for m in range(ROOTS.size):
        one = two = 0.0j
        for j in range(STAGES):
            one += APART[m, j] * (work.stages[1 + j, 2] - work.flow[j, 0])
            two += APART[m, j] * (work.stages[1 + j, 3] - work.flow[j, 1])
        parts[m, 0] = inverses[m, 0] * one + inverses[m, 1] * two
        parts[m, 1] = inverses[m, 2] * one + inverses[m, 3] * two
    most = 0.0
    for i in range(STAGES):
        for k in range(2):
            change = 0.0
            for m in range(ROOTS.size):
                change += (TOGETHER[i, m] * parts[m, k]).real
            work.flow[i, k] += change
            # NaN counts as the greatest change
            most = most if abs(change) <= most else abs(change)
    return most


@inner_jit
def _solve(y, h, mode, case, enough, work):
    """Find F up to an error of `enough` in speed; returns whether it was found."""
    last = 0.0
    for iteration in range(_MOST_ITERATIONS):
        _evaluate(y, h, mode, case, work)
        change = h * _correct(work)
        if change <= 0.1 * enough:
            break
        if iteration > 0:
            rate = change / last
            if not rate < 1.0:
                return change <= enough
            if change * rate <= enough * (1.0 - rate):
                break
        last = change
    else:
        return False
    _evaluate(y, h, mode, case, work)
    return True


@inner_jit
def _short(k, work):
    """Rate of a number at the start of a step less the value of the step's polynomial there."""
    found = work.stages[0, k]
    for j in range(STAGES):
        found -= POWERS[0, j] * work.stages[1 + j, k]
    return found


@inner_jit
def _error(h, swing, scale, work):
    """Error of a step: of speeds, of angles times `swing`, and of energies over `scale`."""
    g, slopes, inverses = h * GAMMA, work.slopes, work.inverses
    p, q, v, w = g * _short(0, work), g * _short(1, work), g * _short(2, work), g * _short(3, work)
    v += g * (slopes[0, 0] * p + slopes[0, 1] * q)
    w += g * (slopes[1, 0] * p + slopes[1, 1] * q)
    # with the matrix of the step, stiff components hardly count
    v, w = (
        inverses[0, 0].real * v + inverses[0, 1].real * w,
        inverses[0, 2].real * v + inverses[0, 3].real * w,
    )
    p, q = swing * (p + g * v), swing * (q + g * w)
    lost, walls = g * _short(LOST, work) / scale, g * _short(WALLS, work) / scale
    return np.sqrt((p * p + q * q + v * v + w * w + lost * lost + walls * walls) / 6.0)


@inner_jit
def attempt(y, h, mode, case, rtol, work):
    """Take a step to `work.end`; returns its error over the tolerance, inf if it fails."""
    work.tries[0] += 1
    scale = _SLOW + max(abs(y[2]), abs(y[3]))
    swing = frequency(case, y, mode)
    _invert(h, work)
    _guess(h, work)
    work.span[0] = 0.0
    if not _solve(y, h, mode, case, max(_EXACT * rtol, _EXACT_SPEED) * scale, work):
        return np.inf
    for k in range(4, STATE):
        gain = 0.0
        for i in range(STAGES):
            gain += MATRIX[STAGES - 1, i] * work.stages[1 + i, k]
        work.end[k] = y[k] + h * gain
    for power in range(STAGES):
        for k in range(2):
            value = 0.0
            for j in range(STAGES):
                value += POWERS[power, j] * work.flow[j, k]
            work.series[power, k] = value
    work.span[0], work.span[1] = h, 0.0
    error = _error(h, swing, scale, work) / (rtol * scale)
    return error if error == error else np.inf


@inner_jit
def go_on(y, work):
    """Make the end of the last step the start of the next one."""
    for k in range(STATE):
        y[k], work.stages[0, k] = work.end[k], work.stages[STAGES, k]
    work.span[1] = 1.0


@inner_jit
def growth(error):
    """Factor on the length of a step with this error, for that of the next one."""
    return min(max(0.9 * error ** (-1.0 / 6.0), 0.2), 6.0) if error > 0.0 else 6.0


@inner_jit
def locate(y, h, mode, case, rtol, work, goal):
    """Length of the step that ends at an event within it, by false position (Illinois).

    It is 0 if a step of the search fails. `goal` says which event it is.
    """
    low, high, length = 0.0, h, h
    at_high = left(case, work.end, mode, work.stages[STAGES], goal)
    at_low = left(case, y, mode, work.stages[0], goal)
    # a step that begins at an event is halved until its end is past the event
    at_low, last = at_low if at_low > 100.0 * ROUNDING else 0.0, 0
    for _ in range(100):
        length = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < length < high:
            length = 0.5 * (low + high)
        # if no double lies between both ends, the step ends at the first one past the event
        done = high - low <= 1e-15 * h or not low < length < high
        length = high if done else length
        if attempt(y, length, mode, case, rtol, work) == np.inf:
            return 0.0
        value = left(case, work.end, mode, work.stages[STAGES], goal)
        if done or abs(value) <= ROUNDING:
            break
        if value > 0.0:
            low, at_low = length, value
            at_high = 0.5 * at_high if last == 1 else at_high
            last = 1
        else:
            high, at_high = length, value
            at_low = 0.5 * at_low if last == -1 else at_low
            last = -1
    return length


@inner_jit
def within(x, h, start, series, y):
    """Fill y[:4] with the state at the share x of a step of length h that begins at `start`."""
    for k in range(2):
        speed = distance = 0.0
        for power in range(STAGES - 1, -1, -1):
            speed = speed * x + series[power, k] / (power + 1)
            distance = distance * x + series[power, k] / ((power + 1) * (power + 2))
        y[2 + k] = start[2 + k] + h * x * speed
        y[k] = start[k] + h * x * (start[2 + k] + h * x * distance)
