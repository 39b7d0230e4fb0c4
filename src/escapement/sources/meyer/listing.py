"""The kernel of Meyer's program: his MIMIC cards and the run time beneath them.

The thesis describes the run time as a fourth-order Runge-Kutta method that
compares one full step with two half steps and keeps the relative error below
5e-6. It leaves two things open, read here as follows.

- The delay line records the acceleration at the end of each accepted step and
  interpolates linearly. No step is longer than the delay, so the stages of a
  step never ask for a value that is not yet there.
- Error control halves a step down to DELAY/1024. Only the jumps, where the sign
  switches or the cell wraps, get there. A run that does little else has left
  its equation: at the Painleve limit A+S*D reaches zero.

Neither matters to a printed digit. Over all 49 runs, fixed steps of 5 or 1 us,
steps of up to 25 or 500 us and a tolerance of 1e-8 change terminal maxima by at
most 0.07 rad/s and periods by 2 us; a line of 100 places changes nothing. Even
fixed steps of 25 us change them by no more than 0.44 rad/s and 8 us.
"""

import numpy as np

from escapement.jit import jit

PI = 3.1416
CELL = 1.5708  # MOD(THETA,1.5708) for all three mechanisms, the four-pin cell
ROW = 0.0005  # DT: time between printed rows [s]
DELAY = ROW / 10.0  # TDL(2DX,DT/10.,100.) [s]
TOLERANCE = 5e-6  # relative, full step against two half steps
SHORTEST = DELAY / 1024.0
CROWDED = 100.0  # most steps per DELAY over a row; a jump costs about ten
_LINE = 4096  # places of the delay line: more than SHORTEST steps in one DELAY


@jit
def _acceleration(n, mu, rho, e, x0, theta, v, old2dx):
    """2DX and PHIDOT, cards G to S and LGT; names as in the listing.

    g = 1/sin(pi/n), h = g cos x - 1, i = g sin x, j = 1 - g^2, l = squared pin
    distance; a, b, c, d, e = factors of Meyer's eq. 1-19; s = sign of F.
    """
    # the next pin takes over after 90 degrees, whatever the wheel
    x = np.fmod(theta, CELL) + x0
    g = 1.0 / np.sin(PI / n)
    h = g * np.cos(x) - 1.0
    i = g * np.sin(x)
    j = 1.0 - g * g
    l = 1.0 + g * g - 2.0 * g * np.cos(x)  # noqa: E741
    a = rho + (h * h) / (l * l)
    b = (i * j * h) / (l * l * l)
    c = (i * i * mu * j) / (l * l * l)
    d = (i * mu * h) / (l * l)
    # the true sign needs the acceleration that it decides, so an older one stands in
    s = -1.0 if c * v * v + d * old2dx < 0.0 else 1.0
    return (e - (b + s * c) * v * v) / (a + s * d), h * v / l


@jit
def _first_acceleration(n, mu, rho, e, x0):
    """2DX at t = 0, cards SMT: E/(R+V)."""
    g = 1.0 / np.sin(PI / n)
    p = 1.0 + g * g - 2.0 * g * np.cos(x0)
    q = g * np.cos(x0) - 1.0
    return e / (rho + (q * q) / (p * p) + abs(mu * g * q * np.sin(x0) / (p * p)))


@jit
def _delayed(times, values, last, time):
    """Recorded acceleration at `time`; before the start, the one at the start."""
    if time <= 0.0:
        return values[0]
    k = last
    # the time asked for is at most a few steps back
    while times[k % _LINE] > time:
        k -= 1
    if k == last:
        return values[k % _LINE]
    t0, t1 = times[k % _LINE], times[(k + 1) % _LINE]
    v0, v1 = values[k % _LINE], values[(k + 1) % _LINE]
    return v0 + (v1 - v0) * (time - t0) / (t1 - t0)


@jit
def _step(n, mu, rho, e, x0, line, last, t, theta, v, a1, h):
    """One fourth-order Runge-Kutta step: the two INT cards."""
    times, values = line
    old = _delayed(times, values, last, t + 0.5 * h - DELAY)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(n, mu, rho, e, x0, theta + 0.5 * h * v, v2, old)[0]
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(n, mu, rho, e, x0, theta + 0.5 * h * v2, v3, old)[0]
    old = _delayed(times, values, last, t + h - DELAY)
    v4 = v + h * a3
    a4 = _acceleration(n, mu, rho, e, x0, theta + h * v3, v4, old)[0]
    theta_end = theta + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
    v_end = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return theta_end, v_end, _acceleration(n, mu, rho, e, x0, theta_end, v_end, old)[0]


@jit(allocates=True)
def run_listing(n, mu, rho, e, x0, interval, out):
    """Fill out[rows, 4] with theta, theta_dot, theta_ddot and phi_dot.

    Returns the number of rows filled: fewer than asked for on breakdown.
    """
    times, values = np.zeros(_LINE), np.zeros(_LINE)
    line = (times, values)
    last = 0
    t = theta = v = 0.0
    a = _first_acceleration(n, mu, rho, e, x0)
    values[0] = a
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = 0.0, 0.0, a, 0.0
    step = DELAY
    for row in range(1, out.shape[0]):
        end = row * interval
        # at a breakdown steps stay so short that the row would never end
        attempts = 4.0 * CROWDED + CROWDED * interval / DELAY
        while t < end:
            attempts -= 1.0
            if attempts < 0.0 or not np.isfinite(v):
                return row
            h = min(step, end - t)
            # one full step against two halves of it
            _, v_full, _ = _step(n, mu, rho, e, x0, line, last, t, theta, v, a, h)
            half = 0.5 * h
            th, vh, ah = _step(n, mu, rho, e, x0, line, last, t, theta, v, a, half)
            th, vh, ah = _step(n, mu, rho, e, x0, line, last, t + half, th, vh, ah, half)
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
        out[row, 3] = _acceleration(n, mu, rho, e, x0, theta, v, a)[1]
    return out.shape[0]
