"""The kernel of Meyer's program: his MIMIC cards and the run time beneath them.

The thesis describes the run time as a fourth-order Runge-Kutta method that
compares one full step with two half steps and keeps the relative error below
5e-6. It leaves two things open, which are interpreted as follows.

- The delay line records the acceleration at the end of each accepted step and
  interpolates linearly. No step is longer than the delay, so the stages of a
  step never ask for a value that is not yet there.
- Error control halves a step down to DELAY/1024. Only jumps, where the sign switches or the cell
  wraps, need such short steps. If a run takes mostly such steps, its equation has broken down: at
  the Painleve limit A+S*D reaches zero.

Neither interpretation changes a printed digit. Over all 49 runs, fixed steps of 5 or 1 us, steps
of up to 25 or 500 us and a tolerance of 1e-8 change terminal maxima by at most 0.07 rad/s and
periods by 2 us; a line of 100 places changes nothing. Even fixed steps of 25 us change them by no
more than 0.44 rad/s and 8 us.
"""

import numpy as np

from escapement.numerics.jit import jit

PI = 3.1416
CELL = 1.5708  # MOD(THETA,1.5708) for all three mechanisms, the four-pin cell
ROW = 0.0005  # DT: time between printed rows [s]
DELAY = ROW / 10.0  # TDL(2DX,DT/10.,100.) [s]
TOLERANCE = 5e-6  # relative, full step against two half steps
SHORTEST = DELAY / 1024.0
CROWDED = 100.0  # most steps per DELAY over a row; a jump costs about ten
_LINE = 4096  # places of the delay line: more than SHORTEST steps in one DELAY


@jit
def _acceleration(run, theta, v, old2dx):
    """2DX and PHIDOT, cards G to S and LGT.

    With g = 1/sin(pi/n), the squared pin distance l, the transmission h/l and the sliding
    i/l of the listing, a to e are the factors of Meyer's eq. 1-19: a = rho + (h/l)^2,
    b = (h/l) slope, c = mu (i/l) slope, d = mu (i/l) (h/l); s is the sign of F.
    """
    n, mu, rho, e, x0 = run
    # the next pin takes over after 90 degrees in every wheel
    x = np.fmod(theta, CELL) + x0
    g = 1.0 / np.sin(PI / n)
    length = 1.0 + g * g - 2.0 * g * np.cos(x)
    ratio, sliding = (g * np.cos(x) - 1.0) / length, g * np.sin(x) / length
    slope = sliding * (1.0 - g * g) / length
    # the true sign depends on the acceleration that it determines, so an older one is used
    force = mu * sliding * (slope * v * v + ratio * old2dx)
    arm = ratio + (-mu if force < 0.0 else mu) * sliding
    return (e - arm * slope * v * v) / (rho + arm * ratio), ratio * v


@jit
def _delayed(times, values, last, time):
    """Recorded acceleration at `time`; before the start, the one at the start."""
    if time <= 0.0:
        return values[0]
    k = last - 1
    # the requested time is at most a few steps back
    while times[k % _LINE] > time:
        k -= 1
    t0, t1 = times[k % _LINE], times[(k + 1) % _LINE]
    v0, v1 = values[k % _LINE], values[(k + 1) % _LINE]
    return v0 + (v1 - v0) * (time - t0) / (t1 - t0)


@jit
def _step(run, line, last, t, theta, v, a1, h):
    """One fourth-order Runge-Kutta step: the two INT cards."""
    times, values = line
    old = _delayed(times, values, last, t + 0.5 * h - DELAY)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(run, theta + 0.5 * h * v, v2, old)[0]
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(run, theta + 0.5 * h * v2, v3, old)[0]
    old = _delayed(times, values, last, t + h - DELAY)
    v4 = v + h * a3
    a4 = _acceleration(run, theta + h * v3, v4, old)[0]
    theta_end = theta + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
    v_end = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return theta_end, v_end, _acceleration(run, theta_end, v_end, old)[0]


@jit(allocates=True)
def run_listing(run, interval, out):
    """Fill out[rows, 4], zero at first, with theta, theta_dot, theta_ddot and phi_dot.

    run : number of slots, friction, driver inertia and torque over the follower's inertia,
        and X0. Returns the number of rows filled: fewer than requested after a breakdown.
    """
    times, values = np.zeros(_LINE), np.zeros(_LINE)
    line = (times, values)
    last = 0
    t = theta = v = 0.0
    # cards SMT: at rest, and about to speed up, friction brakes
    a = _acceleration(run, 0.0, 0.0, 1.0)[0]
    values[0] = out[0, 2] = a
    step = DELAY
    for row in range(1, out.shape[0]):
        end = row * interval
        # after a breakdown steps stay so short that the row would never end
        attempts = 4.0 * CROWDED + CROWDED * interval / DELAY
        while t < end:
            attempts -= 1.0
            if attempts < 0.0 or not np.isfinite(v):
                return row
            h = min(step, end - t)
            # one full step against two halves of it
            _, v_full, _ = _step(run, line, last, t, theta, v, a, h)
            half = 0.5 * h
            th, vh, ah = _step(run, line, last, t, theta, v, a, half)
            th, vh, ah = _step(run, line, last, t + half, th, vh, ah, half)
            error = abs(vh - v_full) / max(abs(vh), 1.0)
            if error > TOLERANCE and h > SHORTEST:
                step = half
                continue
            # a step that is cut at the row ends on it, without rounding
            t = end if h == end - t else t + h
            theta, v, a = th, vh, ah
            last += 1
            times[last % _LINE], values[last % _LINE] = t, a
            if 32.0 * error < TOLERANCE:  # a doubled step multiplies the error by 32
                step = min(2.0 * step, DELAY)
        out[row, 0], out[row, 1], out[row, 2] = theta, v, a
        out[row, 3] = _acceleration(run, theta, v, a)[1]
    return out.shape[0]
