"""The energy equation solved on a panel, for one side of the slot.

Twice the kinetic energy, E = (rho + g^2) w, obeys on a panel with side s

    dE/dx = A - B E                   (`dynamics.energy_rates`)

so E = alpha E_left + beta with alpha = exp(-int B), beta = alpha int A/alpha:
two quadratures, whatever the energy at the left end.
"""

import numpy as np

from escapement.dynamics import bend, energy_rates
from escapement.engines.energy.gauss import N, cumulate, tail_of, whole
from escapement.engines.energy.panels import points_of, solution_of
from escapement.jit import inner_jit

LEAST = 1e-9  # of |u| g' by angle: less is lost next to a stop, or is a table's rounding
ROUNDING = 1e-15  # relative error of the sums; J is a difference and loses digits to it
STEEPEST = 20.0  # decay over a panel beyond which it is halved unseen
SERIES = 0.7  # greatest exponent of the power series below


@inner_jit
def _exponentials(b):
    """exp(-b) and exp(b) for |b| <= SERIES, by their power series: vector code."""
    y = b * b
    z = y * y
    even = 1.0 + y * (1.0 / 2.0) + (1.0 / 24.0 + y * (1.0 / 720.0)) * z
    last = 1.0 / 40320.0 + y * (1.0 / 3628800.0)
    last += (1.0 / 479001600.0 + y * (1.0 / 87178291200.0)) * z
    even += last * (z * z)
    odd = 1.0 + y * (1.0 / 6.0) + (1.0 / 120.0 + y * (1.0 / 5040.0)) * z
    last = 1.0 / 362880.0 + y * (1.0 / 39916800.0)
    last += (1.0 / 6227020800.0 + y * (1.0 / 1307674368000.0)) * z
    odd = (odd + last * (z * z)) * b
    return even - odd, even + odd


@inner_jit
def _decay(solution, gain, count):
    """Fill alpha = exp(-b) at the points, and divide the gain by it."""
    large = 0
    for i in range(count & N):
        large += abs(solution.b[i]) > SERIES
    if large > 0:
        for i in range(N):
            solution.alpha[i] = np.exp(-solution.b[i])
            gain[i] /= solution.alpha[i]
        return
    for i in range(count & N):
        falling, growing = _exponentials(solution.b[i])
        solution.alpha[i] = falling
        gain[i] *= growing


@inner_jit
def solve_side(scene, work, panel, side):
    """Solve the energy equation on a panel for one side of the slot."""
    solution = solution_of(panel, side)
    count = points_of(work)
    for i in range(count & N):
        gain, decay, share = energy_rates(
            panel.g[i], panel.u[i], panel.dg[i], panel.inverse[i], panel.step[i], side, scene
        )
        work.gain[i], work.decay[i] = gain, decay
        solution.beta[i] = share
    # J is a difference near the Painleve limit: finer panels cannot help below this
    noise = ROUNDING * (1.0 + whole(solution.beta, count))
    total = whole(work.decay, count)
    cumulate(work.decay, solution.b)
    _decay(solution, work.gain, count)
    source = whole(work.gain, count)
    cumulate(work.gain, solution.beta)
    for i in range(count & N):
        solution.beta[i] *= solution.alpha[i]
    alpha = _exponentials(total)[0] if abs(total) <= SERIES else np.exp(-total)
    solution.alpha_end, solution.beta_end, solution.b_end = alpha, alpha * source, total
    solution.noise = noise * max(1.0, abs(total))
    solution.tail = _tail(scene, panel, solution, side, count)


@inner_jit
def _tail(scene, panel, solution, side, count):
    """Size of the last coefficients of a solution: 0 below its rounding, 1 where it is useless."""
    middle, last = N // 2, N - 1
    total = solution.b_end
    # next to a cycle that hardly loses, what is lost has to be accurate by itself
    lost = max(abs(total), max(abs(solution.b[middle]), abs(solution.b[last])))
    lost = max(lost, LEAST * abs(bend(side, scene)) * scene.rho * panel.inverse[middle] ** 2)
    largest = max(abs(solution.beta[last]), abs(solution.beta[middle]))
    tail = tail_of(solution.b, count) / max(lost, 1e-300)
    tail = max(tail, tail_of(solution.alpha, count) / max(1.0, solution.alpha_end))
    tail = max(tail, tail_of(solution.beta, count) / max(largest, 1e-300))
    tail = max(tail, panel.sharp)
    if tail < solution.noise:
        tail = 0.0
    return 1.0 if not tail < 1.0 or abs(total) > STEEPEST else tail
