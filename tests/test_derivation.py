"""The equation of motion derived from the Lagrangian, against Meyer (1973).

Nothing here starts from the equation it proves: the left side is the Euler-Lagrange expression of
Meyer's kinetic energy (eq. 1-16), friction enters by virtual power, and the moment on the follower
comes from the follower's own equation of motion. `test_real_derivation` compares the kernels.
"""

import sympy as sp

time, theta = sp.symbols("t theta", real=True)
speed, accel = sp.symbols("theta_dot theta_ddot", real=True)
driver, follower, torque = sp.symbols("I_d I_f tau", positive=True)
load, mu, sign = sp.symbols("M_f mu s", real=True)
ratio, slide, ratio_slope = sp.symbols("g u g_prime", real=True)  # g, |u| and g' at one angle
a = sp.symbols("a", positive=True)

bent = ratio + sign * mu * slide  # p_s
reduced = driver + follower * ratio * bent  # J_s


def follower_moment():
    """N R from the follower's equation N R - M_f = I_f phi_ddot, phi_dot = g theta_dot."""
    return follower * (ratio * accel + ratio_slope * speed**2) + load


def motion_residual():
    """Euler-Lagrange expression less the generalised torque; zero along the motion."""
    angle, g = sp.Function("theta")(time), sp.Function("g")
    rate = angle.diff(time)
    kinetic = (driver + follower * g(angle) ** 2) * rate**2 / 2
    inertial = kinetic.diff(rate).diff(time) - kinetic.diff(angle)
    inertial = inertial.doit().subs(angle.diff(time, 2), accel).subs(rate, speed)
    inertial = inertial.subs(angle, theta).doit()
    inertial = inertial.subs(g(theta).diff(theta), ratio_slope).subs(g(theta), ratio)
    # Per unit of theta_dot: friction mu |N| |R'| = mu s (N R) |u|, load M_f g.
    return inertial - (torque - sign * mu * slide * follower_moment() - load * ratio)


def geneva():
    """Transmission of an external wheel from the pin's position."""
    phi = sp.atan(sp.sin(theta) / (a - sp.cos(theta)))  # Meyer 1-6
    radius = sp.sqrt(1 + a**2 - 2 * a * sp.cos(theta))
    g = sp.simplify(phi.diff(theta))
    return g, sp.simplify(radius.diff(theta) / radius), sp.simplify(g.diff(theta))


def vanishes(expression):
    """Identity in cos theta and a, once sin^2 is gone."""
    c, s = sp.symbols("c s")
    rational = sp.together(expression.subs({sp.sin(theta): s, sp.cos(theta): c}))
    assert not rational.has(theta)
    numerator = sp.expand(sp.numer(rational))
    return sp.rem(numerator, s**2 + c**2 - 1, s).expand() == 0


def test_equation_of_motion():
    claimed = reduced * accel + bent * (follower * ratio_slope * speed**2 + load) - torque
    assert sp.expand(motion_residual() - claimed) == 0


def test_transmission_is_meyers():
    g, u, dg = geneva()
    square = 1 + a**2 - 2 * a * sp.cos(theta)
    assert vanishes(g - (a * sp.cos(theta) - 1) / square)  # 1-7
    assert vanishes(dg - a * (1 - a**2) * sp.sin(theta) / square**2)  # 1-8
    assert vanishes(u - a * sp.sin(theta) / square)


def test_meyers_equation_is_recovered():
    """Meyer 1-18/1-19 with |x| = S x, S = s sign(sin theta), and no load."""
    side = sp.symbols("sigma")  # sign(sin theta)
    square = 1 + a**2 - 2 * a * sp.cos(theta)
    lead = a * sp.cos(theta) - 1
    big_a = driver / follower + lead**2 / square**2
    big_b = a * (1 - a**2) * sp.sin(theta) * lead / square**3
    big_c = mu * a**2 * sp.sin(theta) ** 2 * (1 - a**2) / square**3
    big_d = mu * a * sp.sin(theta) * lead / square**2
    big_e = torque / follower
    inside = big_c * speed**2 + big_d * accel
    meyer = big_a * accel + big_b * speed**2 + sign * side * inside - big_e
    g, u, dg = geneva()
    values = {ratio: g, slide: side * u, ratio_slope: dg, load: 0}
    assert vanishes(motion_residual().subs(values) / follower - meyer)
    # What Meyer encloses in bars is mu u N R / I_f, so its sign is s sign(sin theta).
    moment = follower_moment().subs({ratio: g, ratio_slope: dg, load: 0})
    assert vanishes(inside - mu * u * moment / follower)
