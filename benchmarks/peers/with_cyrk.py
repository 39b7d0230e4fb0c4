"""CyRK: compiled Runge-Kutta solvers (cysolve), called from a compiled loop.

Its Numba interface has no events, so they are located here, in the way that made it fastest: the
solver integrates to the time at which the same piece ended in the engagement before, and Newton's
iteration then finds the event, with a short integration for each iterate. If that time is far from
the event, the iteration starts at the last step before the event. No dense output is needed, and an
event is as accurate as a step.
"""

import math
from collections.abc import Callable

import numba
import numpy as np
from CyRK import cyjit, nbsolve2_ivp

from escapement.benchmark.problems import Problem, derivative, pieces_of, reversal
from escapement.mechanisms.protocol import FloatArray

METHODS = ("DOP853", "Vern8")

_CLOSE = 1e-2  # share of a piece from which Newton's iteration may start
_LAST = 1e-8  # share below which two Taylor terms are exact

# The solver is given as a function pointer of the running process. A kernel with such a pointer
# cannot be cached on disk, so the package's own decorator cannot be used.
compiled = numba.njit(error_model="numpy", nogil=True)
_rates = compiled(derivative)
_contact = compiled(reversal)


@cyjit
def _derivative(dy, t, y, parameters):
    dy[0], dy[1] = _rates(t, y, parameters[0], parameters[1], parameters[2])


@compiled
def _remaining(target, theta, speed, parameters):
    """Positive before the event: angle left, or contact force if the event is a reversal (NaN)."""
    if target == target:
        return target - theta
    return _contact(0.0, (theta, speed), parameters[0], parameters[1], parameters[2])


@compiled
def _time_to_go(target, theta, speed, parameters):
    """Newton's estimate of the time to the event."""
    a, rho, kappa = parameters
    value = _remaining(target, theta, speed, parameters)
    rate = _rates(0.0, (theta, speed), a, rho, kappa)[1]
    if target == target:
        return 2.0 * value / (speed + math.sqrt(max(speed * speed + 2.0 * rate * value, 0.0)))
    step = 1e-6
    ahead = _contact(0.0, (theta + step * speed, speed + step * rate), a, rho, kappa)
    behind = _contact(0.0, (theta - step * speed, speed - step * rate), a, rho, kappa)
    return -2.0 * step * value / (ahead - behind)


@compiled
def _to_event(address, method, tolerance, y, parameters, target, guess):
    """Advance y to the event that ends its piece; returns the time it took."""
    elapsed, going = 0.0, guess
    for _ in range(100):
        solved = nbsolve2_ivp(
            address, (0.0, going), y, method, None, False, parameters, tolerance, tolerance
        )
        times, states = solved.t, solved.y
        k = times.size - 1
        going = _time_to_go(target, states[0, k], states[1, k], parameters)
        if not abs(going) <= _CLOSE * guess:
            width = guess
            while k > 0 and _remaining(target, states[0, k], states[1, k], parameters) < 0.0:
                k -= 1
                width = times[k + 1] - times[k]
            going = _time_to_go(target, states[0, k], states[1, k], parameters)
            going = going if 0.0 < going < width else 0.5 * width
        elapsed += times[k]
        y[0], y[1] = states[0, k], states[1, k]
        solved.free()
        if abs(going) <= _LAST * guess:
            break
    rate = _rates(0.0, y, parameters[0], parameters[1], parameters[2])[1]
    y[0] += going * (y[1] + 0.5 * going * rate)
    y[1] += going * rate
    return elapsed + going


@compiled
def _engagements(address, method, tolerance, parameters, starts, targets, out):
    """Fill out[0] and out[1] with handoff times and speeds."""
    y = np.zeros(2)
    rho, end = parameters[0, 1], targets[2]
    guesses = np.full(3, 0.3 * math.sqrt(end * (rho + 1.0)))
    now = 0.0
    for k in range(out.shape[1]):
        for i in range(3):
            if starts[i] == starts[i]:
                y[0] = starts[i]
            spent = _to_event(address, method, tolerance, y, parameters[i], targets[i], guesses[i])
            guesses[i] = spent
            now += spent
        out[0, k] = now
        out[1, k] = y[1]


def prepare(
    problem: Problem, rtol: float, method: str
) -> Callable[[], tuple[FloatArray, FloatArray]]:
    """A run of `problem` at a tolerance by one of its methods."""
    # None becomes NaN
    columns = zip(*pieces_of(problem), strict=True)
    parameters, starts, targets = (np.array(column, dtype=float) for column in columns)
    address = _derivative.address
    out = np.empty((2, problem.engagements))

    def run() -> tuple[FloatArray, FloatArray]:
        _engagements(address, method, rtol, parameters, starts, targets, out)
        return out[0] * problem.clock, out[1] / problem.clock

    return run
