"""heyoka: Taylor series of adaptive order, compiled for the equation, with terminal events.

It is set up to be as fast as possible: integrators are built and compiled once per tolerance and
reset for each run, fast-math is on (a quarter faster and no less accurate here), and the functions
called at events touch only arrays. Events use the integrator's own polynomials, so they cost no
accuracy.

`prepare` states the problem in time, as for all other solvers. `prepare_angle` gives heyoka the
package's own formulation, w = theta_dot^2 over the driver angle, in which only the reversal has to
be found: the difference shows how much of the speed is due to the formulation.
"""

from typing import Any

import heyoka as hy
import numpy as np

from escapement.benchmark.problems import Problem, TimedRun, pieces_of
from escapement.mechanisms.protocol import FloatArray

_FOREVER = 1e6  # natural units; an event ends the run


def prepare(problem: Problem, rtol: float) -> TimedRun:
    """A run of `problem` at a tolerance, in time."""
    approach, push, follow = (parameters[2] for parameters, _start, _end in pieces_of(problem))
    end = problem.numbers[3]
    times, speeds = np.empty(problem.engagements), np.empty(problem.engagements)
    done = 0

    def arrive(integrator: Any, sense: int) -> bool:
        """Reverse the sliding at dead centre; at the handoff store it and start again."""
        nonlocal done
        if parameters[1] == 0.0:
            parameters[0], parameters[1] = push, end
            return True
        times[done], speeds[done] = integrator.time, state[1]
        done += 1
        state[0] = -end
        parameters[0], parameters[1] = approach, 0.0
        return done < problem.engagements

    def reverse(integrator: Any, sense: int) -> bool:
        parameters[0] = follow
        return True

    integrator = _in_time(problem, rtol, arrive, reverse)
    state, parameters = integrator.state, integrator.pars

    def run() -> tuple[FloatArray, FloatArray]:
        nonlocal done
        done = 0
        _restart(integrator, [-end, 0.0], [approach, 0.0])
        integrator.propagate_until(_FOREVER)
        return times[:done] * problem.clock, speeds[:done] / problem.clock

    return run


def prepare_angle(problem: Problem, rtol: float) -> TimedRun:
    """The same over the driver angle, except from rest to the first dead centre."""
    approach, push, follow = (parameters[2] for parameters, _start, _end in pieces_of(problem))
    end = problem.numbers[3]
    times, squares = np.empty(problem.engagements), np.empty(problem.engagements)

    def reverse(integrator: Any, sense: int) -> bool:
        parameters[0] = follow
        return True

    def stop(integrator: Any, sense: int) -> bool:
        return False

    start = _in_time(problem, rtol, stop, reverse)
    w, time = hy.make_vars("w", "time")
    force, inertia, contact = _motion(problem, hy.time, w)
    integrator = hy.taylor_adaptive(
        [(w, 2.0 * force / inertia), (time, w**-0.5)],
        [1.0, 0.0],
        pars=[approach],
        t_events=[_falling(contact, reverse)],
        tol=rtol,
        fast_math=True,
    )
    state, parameters = integrator.state, integrator.pars

    def run() -> tuple[FloatArray, FloatArray]:
        _restart(start, [-end, 0.0], [approach, 0.0])
        start.propagate_until(_FOREVER)
        _restart(integrator, [start.state[1] ** 2, start.time], [push])
        for k in range(problem.engagements):
            if k > 0:
                integrator.time = -end
                parameters[0] = approach
                integrator.propagate_until(0.0)
            parameters[0] = push
            integrator.reset_cooldowns()
            integrator.propagate_until(end)
            squares[k] = state[0]
            times[k] = state[1]
        return times * problem.clock, np.sqrt(squares) / problem.clock

    return run


def _in_time(problem: Problem, rtol: float, arrive: Any, reverse: Any) -> Any:
    """Integrator of theta and theta_dot; par[1] is the angle of the event `arrive`."""
    theta, speed = hy.make_vars("theta", "speed")
    force, inertia, contact = _motion(problem, theta, speed * speed)
    return hy.taylor_adaptive(
        [(theta, speed), (speed, force / inertia)],
        [0.0, 0.0],
        pars=[0.0, 0.0],
        t_events=[_falling(hy.par[1] - theta, arrive), _falling(contact, reverse)],
        tol=rtol,
        fast_math=True,
    )


def _motion(problem: Problem, theta: Any, w: Any) -> tuple[Any, Any, Any]:
    """Force and inertia of the driver, and the contact function, as symbols; as in `problems`.

    par[0] is the signed friction.
    """
    a, rho, _, _ = problem.numbers
    n = a * hy.cos(theta) - 1.0
    q = a * a - 1.0
    length = (q + 2.0) - 2.0 * a * hy.cos(theta)
    slide = a * hy.sin(theta)
    p = n + hy.par[0] * slide
    square = length * length
    inertial = q * slide * w
    force = square * length + p * inertial
    inertia = length * (rho * square + n * p)
    return force, inertia, n * length - rho * inertial


def _falling(expression: Any, callback: Any) -> Any:
    """Terminal event where an expression falls through zero."""
    return hy.t_event(expression, callback=callback, direction=hy.event_direction.negative)


def _restart(integrator: Any, state: list[float], parameters: list[float]) -> None:
    integrator.time = 0.0
    integrator.state[:] = state
    integrator.pars[:] = parameters
    integrator.reset_cooldowns()
