"""The energy equation solved on a panel, for one side of the slot.

Twice the kinetic energy, E = (rho + g^2) w, obeys on a panel with side s

    dE/dx = A - B E                   (`dynamics.law.energy_rates`)

so E = alpha E_left + beta with b = int B, alpha = exp(-b) and beta = alpha int A/alpha. Two
quadratures solve it for every energy at the left end. A start from rest, or from nearly no
speed, is solved on a panel over the square root of the angle instead.
"""

import numpy as np

from escapement.dynamics.law import (
    energy_rates,
    friction_ratio,
    is_ideal,
    is_viscous,
    reduced_inertia,
    signed_loss,
)
from escapement.dynamics.load import has_load_curve, load_at
from escapement.dynamics.torque import depends_on_speed, fall_after, is_constant
from escapement.engines.energy.panels import (
    UNSOLVED,
    copy_end,
    evaluate_at,
    fill_inertia,
    finish_geometry,
    may_change,
    points_of,
    pull_at,
    solution_of,
)
from escapement.engines.energy.sampling import friction_ratio_at, net_torque_at
from escapement.numerics.gauss import (
    POINTS,
    SERIES,
    N,
    cumulate,
    exponentials,
    fill_decay,
    integral,
    tail_of,
)
from escapement.numerics.jit import inner_jit
from escapement.numerics.known import where_known

# The error of b is compared with at least the decay that this value instead of int 2 |u| g'
# dtheta would give: next to a stop of a mechanism without slots the true decay is smaller, and
# the values of a table there are rounding errors.
LEAST_DECAY = 1e-9
# The sums over the Gauss points have this relative rounding error.
ROUNDING = 1e-15
# A panel over which B has a greater integral than this is halved without evaluating its tail.
STEEPEST = 20.0
# Newton's method for viscous drag squares its error in each of so many steps at most.
MOST_STEPS = 40
# A squared speed that is not positive counts as this one.
TINY = 1e-200


@inner_jit
def solve_side(scene, work, panel, side, energy):
    """Solve dE/dx = A - B E on a panel for the side s of the slot, where that is not done yet.

    With viscous drag the equation is not linear, and its solution belongs to one E at the left
    end, `energy`. It is then solved again by Newton's method, linearised about the last solution,
    until the solution does not change any more.
    """
    solution = solution_of(panel, side)
    viscous = is_viscous(scene)
    pull, known = panel.entry.pull, not viscous and solution.tail != UNSOLVED
    if known and (solution.pull == pull or shift(solution, pull, points_of(work))):
        return
    # the first solution is without viscous drag
    fill_friction_ratio(scene, work, panel, solution, side)
    guess_roots(work, panel, energy, scene)
    for _ in range(MOST_STEPS):
        solve_linear(scene, work, panel, solution, side)
        if not viscous:
            return
        if refresh_roots(scene, work, panel, solution, energy) < 1e-14:
            solve_again(scene, work, panel, solution, side)
            return
    solution.tail = 1.0


@inner_jit
def shift(solution, pull, count):
    """Adapt a solution to another pull at the left end; returns whether this is possible.

    beta is linear in the pull if that keeps its slope. For a pull of another size the equation is
    solved again, so that beta keeps its relative accuracy.
    """
    more = pull - solution.solved_pull
    if abs(more) > 0.5 * abs(solution.solved_pull):
        return False
    for i in range(count & N):
        solution.beta[i] = solution.solved[i] + more * solution.share[i]
    solution.beta_end = solution.solved_end + more * solution.share_end
    solution.pull = pull
    return True


@where_known("pace", lambda pull, driver_angle, root, scene: (pull, 0.0))
def tangent(pull, driver_angle, root, scene):
    """The pull at a speed and its slope there, from the pull at rest."""
    fall, slope = fall_after(driver_angle, root, scene)
    return pull - scene.gain * fall, -scene.gain * slope


@where_known("pace", lambda work, panel, energy, scene: None)
def guess_roots(work, panel, energy, scene):
    """Begin Newton's method with the E of the left end where the torque depends on the speed."""
    if scene.pace > 0.0:
        for i in range(N):
            work.root[i] = np.sqrt(energy * panel.inverse_inertia[i])


@inner_jit
def solve_again(scene, work, panel, solution, side):
    """Solve with the final roots: E is exact already, but b depends on them to first order."""
    slowest = work.root[0]
    for i in range(N):
        slowest = min(slowest, work.root[i])
    # with the tiny roots behind a stop the solution would hide that the driver stops
    if slowest > np.sqrt(TINY):
        solve_linear(scene, work, panel, solution, side)


@inner_jit
def keep_share(scene, work, panel, solution, count):
    """Keep what `shift` needs of a solution just found: beta, and its derivative by the pull.

    A unit of the pull adds 2 theta' (rho + g^2)/J to A.
    """
    for i in range(N):
        g = panel.g[i]
        inertia = reduced_inertia(g, solution.friction_ratio[i], scene)
        work.gain[i] = 2.0 * panel.dtheta_dx[i] * (scene.rho + g * g) / inertia / solution.alpha[i]
    cumulate(work.gain, solution.share)
    for i in range(count & N):
        solution.solved[i] = solution.beta[i]
        solution.share[i] *= solution.alpha[i]
    solution.solved_end = solution.beta_end
    solution.share_end = solution.alpha_end * integral(work.gain, count)
    solution.solved_pull = panel.entry.pull


@inner_jit
def refresh_roots(scene, work, panel, solution, energy):
    """Linearise viscous drag about the present solution from E = `energy` at the left end.

    Returns the square of the greatest relative change of a speed, which is about the error of E.
    A speed that is not positive, as behind a stop, counts as a tiny one.
    """
    change = 0.0
    for i in range(N):
        w = (solution.alpha[i] * energy + solution.beta[i]) * panel.inverse_inertia[i]
        root = np.sqrt(max(w, TINY))
        change = max(change, abs(root - work.root[i]) / root)
        work.root[i] = root
    return change * change


@inner_jit(merged=True)
def fill_friction_ratio(scene, work, panel, solution, side):
    """Fill the row of c = p - g, and that of roots with zeros."""
    if is_viscous(scene):
        for i in range(N):
            work.root[i] = 0.0
    if is_ideal(scene):
        friction = signed_loss(side, scene)
        for i in range(points_of(work) & N):
            solution.friction_ratio[i] = friction * abs(panel.u[i])
        return
    for i in range(N):
        solution.friction_ratio[i] = friction_ratio(
            panel.g[i], panel.u[i], panel.radius[i], side, scene
        )


@inner_jit
def solve_linear(scene, work, panel, solution, side):
    """Solve dE/dx = A - B E on a panel, viscous drag being linear about the row of roots."""
    count, left_pull = points_of(work), panel.entry.pull
    # until beta is known its row holds (rho + g^2)/J
    if is_viscous(scene):
        for i in range(N):
            g, c, k, inverse = (
                panel.g[i],
                solution.friction_ratio[i],
                panel.dg[i],
                panel.inverse_inertia[i],
            )
            dtheta_dx, root, load = panel.dtheta_dx[i], work.root[i], panel.load[i]
            pull, slope = tangent(panel.pull[i], panel.turned[i], root, scene)
            rates = energy_rates(g, c, k, pull, inverse, dtheta_dx, root, scene, load, slope)
            work.gain[i], work.decay[i], solution.beta[i] = rates
    else:
        for i in range(count & N):
            g, c, k, inverse = (
                panel.g[i],
                solution.friction_ratio[i],
                panel.dg[i],
                panel.inverse_inertia[i],
            )
            pull, dtheta_dx = pull_at(left_pull, panel.pull, i, scene), panel.dtheta_dx[i]
            rates = energy_rates(g, c, k, pull, inverse, dtheta_dx, 0.0, scene, panel.load[i])
            work.gain[i], work.decay[i], solution.beta[i] = rates
    # J is a difference of nearly equal terms near the Painleve limit: its rounding error is
    # amplified by (rho + g^2)/J, and no finer panel makes it smaller
    noise = ROUNDING * (1.0 + integral(solution.beta, count))
    total = integral(work.decay, count)
    # b = int B from the left end to each point, and alpha = exp(-b)
    cumulate(work.decay, solution.b)
    fill_decay(solution.b, solution.alpha, work.gain, count)
    # beta = alpha int A/alpha
    source = integral(work.gain, count)
    cumulate(work.gain, solution.beta)
    for i in range(count & N):
        solution.beta[i] *= solution.alpha[i]
    alpha = exponentials(total)[0] if abs(total) <= SERIES else np.exp(-total)
    solution.alpha_end, solution.beta_end, solution.b_end = alpha, alpha * source, total
    solution.noise = noise * max(1.0, abs(total))
    solution.pull = panel.entry.pull
    if not is_constant(scene):
        keep_share(scene, work, panel, solution, count)
    solution.tail = _tail(scene, panel, solution, side, count)


@inner_jit(merged=True)
def _tail(scene, panel, solution, side, count):
    """Greatest relative size of the last coefficients of b, alpha, beta and 1/(rho + g^2).

    It is 0 where it is below the rounding error, and 1 where the solution is useless.
    """
    middle, last = N // 2, N - 1
    total = solution.b_end
    # where friction takes little, 1 - alpha fixes the terminal cycle, so b needs digits of its own
    lost = max(abs(total), max(abs(solution.b[middle]), abs(solution.b[last])))
    lost = max(
        lost,
        LEAST_DECAY
        * abs(signed_loss(side, scene))
        * scene.rho
        * panel.inverse_inertia[middle] ** 2,
    )
    # beta starts at zero, so that its size is read at the middle and the last point
    largest = max(abs(solution.beta[last]), abs(solution.beta[middle]))
    tail = tail_of(solution.b, count) / max(lost, 1e-300)
    tail = max(tail, tail_of(solution.alpha, count) / max(1.0, solution.alpha_end))
    tail = max(tail, tail_of(solution.beta, count) / max(largest, 1e-300))
    tail = max(tail, panel.geometry_tail)
    if tail < solution.noise:
        tail = 0.0
    # a NaN fails the comparison and counts as useless
    return 1.0 if not tail < 1.0 or abs(total) > STEEPEST else tail


@inner_jit
def slope_of_w(scene, panel, side, w):
    """dw/dtheta = 2 theta_ddot at the left end of a panel."""
    end = panel.entry
    inertia = reduced_inertia(end.g, friction_ratio_at(end, side, scene), scene)
    return 2.0 * net_torque_at(end, side, w, scene) / inertia


@inner_jit
def lay_out_start(scene, work, panel, offset):
    """Lay out `panel` a second time, over the square root of the angle, in the spare panel.

    From rest w grows in proportion to the angle, so dt/dtheta = 1/sqrt(w) is singular. With
    y = sqrt(offset + (theta - left)/length) the speed is in proportion to y, and dt/dy is
    smooth. The angle at which the speed was zero, y = 0, lies `offset` times the length of
    the panel before its left end.
    """
    start = work.spare
    left, half = panel.left, panel.half
    first, last = np.sqrt(offset), np.sqrt(1.0 + offset)
    for i in range(N):
        y = 0.5 * ((last + first) + (last - first) * POINTS[i])
        # the points in x of the ordinary panel that are Gauss points in y
        work.scratch[i] = 2.0 * (y * y - offset) - 1.0
        # dtheta/dx at these points; the row is free until there is a reversal
        work.slowness_change[i] = 2.0 * half * (last - first) * y
    count = points_of(work)
    start.left, start.half, start.locked = left, half, panel.locked
    evaluate_at(work.scratch, count, start, scene.path)
    copy_end(start.entry, panel.entry)
    copy_end(start.exit, panel.exit)
    # theta' is not constant: it is set behind the call that sets it to the half width
    fill_inertia(start, scene, count)
    finish_geometry(start, scene, count)
    for i in range(N):
        start.dtheta_dx[i] = work.slowness_change[i]
        if may_change(scene):
            start.pull[i] = start.entry.pull + start.slope * half * (1.0 + work.scratch[i])
        if depends_on_speed(scene):
            start.turned[i] = start.entry.turned + half * (1.0 + work.scratch[i])
    if has_load_curve(scene) and not panel.locked:
        for i in range(N):
            start.load[i] = load_at(left + half * (1.0 + work.scratch[i]), 1.0, scene)


@inner_jit
def solve_start(scene, work, panel, side, w, strict):
    """Solve the spare panel in place of `panel`; returns whether it takes that place."""
    slope = slope_of_w(scene, panel, side, w)
    if not slope > 0.0:
        return False
    if panel.geometry_tail > strict:
        # over the square root of the angle g would be rougher still; a tail of 1 has the
        # panel halved
        solution_of(panel, side).tail = 1.0
        return False
    # w = 0 at the distance w/(dw/dtheta) before the left end
    lay_out_start(scene, work, panel, w / (2.0 * slope * panel.half))
    solution_of(work.spare, side).tail = work.spare.geometry_tail
    if work.spare.geometry_tail <= strict:
        solution_of(work.spare, side).tail = UNSOLVED
        solve_side(scene, work, work.spare, side, w * (scene.rho + panel.entry.g**2))
    return True
