"""The equation of motion derived from the Lagrangian, against Meyer (1973) and the kernels.

Nothing here starts from the equation it proves: the left side is the Euler-Lagrange expression of
Meyer's kinetic energy (eq. 1-16), friction enters by virtual power, and the moment on the follower
comes from the follower's own equation of motion.
"""

import numpy as np
import pytest
import sympy as sp

from escapement.dynamics import law as dynamics
from escapement.mechanisms.path import Path
from escapement.model.scene import Scene
from random_drives import from_python

time, theta = sp.symbols("t theta", real=True)
speed, accel = sp.symbols("theta_dot theta_ddot", real=True)
driver, follower, torque = sp.symbols("I_d I_f tau", positive=True)
load, mu, sign = sp.symbols("M_f mu s", real=True)
ratio, slide, ratio_slope = sp.symbols("g u g_prime", real=True)  # g, |u| and g' at one angle
a, rho, tangent = sp.symbols("a rho T", positive=True)

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


def geneva(kind=1):
    """Transmission from the pin's position: kind 1 external, -1 internal."""
    phi = sp.atan(sp.sin(theta) / (a - kind * sp.cos(theta)))  # Meyer 1-6
    radius = sp.sqrt(1 + a**2 - 2 * kind * a * sp.cos(theta))
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


def test_contact_moment_knows_neither_friction_nor_its_sign():
    (solved,) = sp.solve(motion_residual(), accel)
    moment = sp.simplify(follower_moment().subs(accel, solved) * reduced)
    inertial = driver * (follower * ratio_slope * speed**2 + load)
    assert sp.expand(moment - inertial - follower * ratio * torque) == 0
    assert not sp.expand(moment).has(mu, sign)


def test_energy_equation_of_one_piece():
    """With w = theta_dot^2 and theta_ddot = w'/2: J_s w'/2 + I_f p_s g' w = tau - p_s M_f."""
    w, slope = sp.symbols("w w_prime")
    residual = sp.expand(motion_residual()).subs(speed**2, w).subs(accel, slope / 2)
    claimed = reduced * slope / 2 + follower * bent * ratio_slope * w - torque + bent * load
    assert sp.expand(residual - claimed) == 0


def test_friction_acts_at_the_arm_of_the_slot():
    """Meyer's arm c sin phi of the friction force is |R'|: virtual power and his figure 6 agree."""
    square = 1 + a**2 - 2 * a * sp.cos(theta)
    arm = a * sp.sin(theta) / sp.sqrt(square)  # Meyer 1-11, crank radius 1
    assert sp.simplify(sp.sqrt(square).diff(theta) - arm) == 0


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


def test_two_rotating_vectors_give_the_slope():
    """C = P e^(i a theta) + Q e^(i b theta): phi'' = u (a + b - 2 g)."""
    p, q, first, second = sp.symbols("P Q a_1 b_1", real=True)
    x = p * sp.cos(first * theta) + q * sp.cos(second * theta)
    y = p * sp.sin(first * theta) + q * sp.sin(second * theta)
    square = x**2 + y**2
    g = (x * y.diff(theta) - y * x.diff(theta)) / square
    u = (x * x.diff(theta) + y * y.diff(theta)) / square
    assert sp.simplify(sp.numer(sp.together(g.diff(theta) - u * (first + second - 2 * g)))) == 0


@pytest.mark.parametrize("kind", [1, -1], ids=["external", "internal"])
def test_geneva_identities(kind):
    g, u, dg = geneva(kind)
    assert vanishes(dg + kind * (1 + 2 * kind * g) * u)
    # 1/(a^2 - 1) = tan^2(pi/n) for a = 1/sin(pi/n)
    assert vanishes(u**2 - (1 + 2 * kind * g) / (a**2 - 1) + g**2)
    n = sp.symbols("n", positive=True)
    assert sp.simplify(1 / (1 / sp.sin(sp.pi / n) ** 2 - 1) - sp.tan(sp.pi / n) ** 2) == 0


def test_painleve_limit_is_a_root_of_the_cubic():
    """Stationarity of ((rho + g^2)/(g u))^2 with u^2 = T (1 + 2 g) - g^2."""
    g = sp.symbols("g", positive=True)
    square = tangent * (1 + 2 * g) - g**2
    limit = ((rho + g**2) / g) ** 2 / square
    cubic = tangent * g**3 + (tangent + 2 * rho) * g**2 - 3 * rho * tangent * g - rho * tangent
    expected = 2 * (rho + g**2) * cubic / (g**3 * square**2)
    assert sp.simplify(limit.diff(g) - expected) == 0


def random_states(count=400, seed=1973):
    """g, signed u, g', w, sign, rho, mu, load; both signs of each, J_s clear of zero."""
    rng = np.random.default_rng(seed)
    g, u, dg = rng.normal(size=(3, count)) * np.array([[2.0], [1.0], [5.0]])
    w, r = 10.0 ** rng.uniform(-4, 3, count), 10.0 ** rng.uniform(-4, 3, count)
    limit = (r + g**2) / np.abs(g * u)
    friction = rng.uniform(0, 0.95, count) * np.minimum(limit, 2.0)
    return g, u, dg, w, rng.choice([-1.0, 1.0], count), r, friction, rng.normal(size=count)


def terms(expression):
    """Sum of the magnitudes of a polynomial's terms: the scale its rounding error has."""
    return sum(abs(term) for term in sp.Add.make_args(sp.expand(expression)))


def compare(kernel, expression, arguments, states):
    """Kernel against a SymPy quotient, to 1e-12 of the terms that cancel in it."""
    numerator, denominator = sp.fraction(sp.together(expression))
    scale = terms(numerator) / abs(denominator)
    scale *= terms(denominator) / abs(denominator)
    exact = sp.lambdify(arguments, expression, "numpy")
    size = sp.lambdify(arguments, scale, "numpy")
    found = np.array([kernel(*state) for state in zip(*states, strict=True)])
    assert (np.abs(found - exact(*states)) <= 1e-12 * size(*states)).all()


@pytest.fixture(scope="module")
def dimensionless():
    """Acceleration and moment solved from the residual, units I_f = tau = 1, u with its sign."""
    signed, w = sp.symbols("u_signed w", real=True)
    units = {follower: 1, torque: 1, driver: rho, slide: sp.Abs(signed)}
    (solved,) = sp.solve(motion_residual(), accel)
    moment = sp.simplify(follower_moment().subs(accel, solved))
    acceleration, moment, inertia = (
        x.subs(units).subs(speed, sp.sqrt(w)) for x in (solved, moment, reduced)
    )
    return {
        "acceleration": acceleration,
        "moment": moment,
        "contact": sp.simplify(moment * inertia),
        "state": (ratio, signed, ratio_slope, w, sign, rho, mu, load),
        "contact_state": (ratio, ratio_slope, w, rho, load),
    }


def scene(rho, mu_plus, mu_minus, load, *, table=False):
    nothing, numbers = np.empty(0), (rho, mu_plus, mu_minus, load)
    path = np.zeros(11)  # a slot through the axis: the kernels read its distance
    absent = (0.0,) * (len(Scene._fields) - 7 - len(numbers))
    constant = np.array([0.0, 0.0, 1.0]), 0.0, np.zeros(1), np.zeros(1)
    found = Scene(Path(table, path), nothing, 0.0, *constant, *numbers, *absent)
    trains = {"barrel_efficiency": 1.0, "load_train_efficiency": 1.0}
    return found._replace(gain=1.0, flow=-1.0, **trains)


def test_kernels_follow_the_lagrangian(dimensionless):
    states = random_states()
    g, _, dg, w, _, r, _, m = states
    bend, net_torque = from_python(dynamics.friction_ratio), from_python(dynamics.net_torque)
    inertia, contact_of = from_python(dynamics.reduced_inertia), from_python(dynamics.contact)

    def acceleration(g, u, dg, w, s, rho, mu, load):
        here = scene(rho, mu, mu, load)
        c = bend(g, u, 1.0, s, here)
        return net_torque(g, c, dg, 1.0, w, 0.0, here) / inertia(g, c, here)

    def moment(g, u, dg, w, s, rho, mu, load):
        here = scene(rho, mu, mu, load)
        return contact_of(g, dg, 1.0, w, 0.0, here) / inertia(g, bend(g, u, 1.0, s, here), here)

    def contact(g, dg, w, rho, load):
        return contact_of(g, dg, 1.0, w, 0.0, scene(rho, 0.0, 0.0, load))

    kernels = {"acceleration": acceleration, "moment": moment}
    for name, kernel in kernels.items():
        compare(kernel, dimensionless[name], dimensionless["state"], states)
    compare(contact, dimensionless["contact"], dimensionless["contact_state"], (g, dg, w, r, m))


def test_a_mesh_divides_by_its_efficiency_what_it_passes_on_and_multiplies_what_comes_back():
    bend = from_python(dynamics.friction_ratio)
    for eta in (0.3, 0.87, 1.0):
        mesh = scene(1.0, 1.0 / eta - 1.0, 1.0 - eta, 0.0, table=True)
        for g in (1e-9, 0.7, 6.0):
            assert g + bend(g, g, 1.0, 1.0, mesh) == pytest.approx(g / eta, rel=1e-15)
            assert g + bend(g, g, 1.0, -1.0, mesh) == pytest.approx(g * eta, rel=1e-15)
