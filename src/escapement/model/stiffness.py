"""Stiffness of a pin on the wall of its slot, from material, radius and width."""

import math

from escapement.base import validate


def contact_stiffness(
    force: float,
    *,
    radius: float,
    width: float,
    modulus: float,
    poisson: float = 0.3,
    wall_modulus: float | None = None,
    wall_poisson: float | None = None,
    depth: float | None = None,
) -> float:
    """Stiffness of a cylindrical pin on a flat wall [N/m].

    In a line contact the approach is not a power of the force. Pin and wall approach each other by

        P (1 - nu_1^2)/(pi E_1) [2 ln(4 R/a) - 1]
        + P (1 - nu_2^2)/(pi E_2) [2 ln(2 h/a) - nu_2/(1 - nu_2)]

    with the force P by width and a = sqrt(4 P R/(pi E*)), half the width of the contact. The
    stiffness is the force over this approach. It depends on the force only through a
    logarithm: ten times the force makes it about a fifth greater, so a typical force is enough.

    Parameters
    ----------
    force : float
        Typical force of the contact [N], > 0.
    radius, width : float
        Radius R of the pin, and the length along its axis over which it touches the wall [m].
    modulus, poisson : float
        Young's modulus [Pa] and Poisson's ratio [-] of the pin.
    wall_modulus, wall_poisson : float, optional
        Young's modulus [Pa] and Poisson's ratio [-] of the wall; by default those of the pin.
    depth : float, optional
        Distance h behind the wall over which it is compressed [m]; by default the pin's diameter.

    Returns
    -------
    float
        Stiffness [N/m]. A steel pin of radius 1 mm on 2 mm of steel wall has 6e7 N/m at
        10 N; the pin's bending and the play of its bearings make a real joint softer.

    Raises
    ------
    InvalidValue
        If a number breaks its rule, or the contact is wider than a tenth of the radius, for
        which Hertz's theory of a narrow contact no longer holds.

    Source: Johnson (1985), Contact Mechanics, section 5.6, eqs. 5.57 and 5.58. Plane strain,
    elastic and without friction.
    """
    given = {"force": force, "radius": radius, "width": width, "modulus": modulus}
    given["wall_modulus"] = modulus if wall_modulus is None else wall_modulus
    given["depth"] = 2.0 * radius if depth is None else depth
    given = {name: validate.positive(name, value, "give it in SI") for name, value in given.items()}
    ratios = {"poisson": poisson, "wall_poisson": poisson if wall_poisson is None else wall_poisson}
    for name, value in ratios.items():
        if not 0.0 <= validate.number(name, value) <= 0.5:
            raise validate.fail(name, "between 0 and 0.5", value, "0.3 fits metals")
    load = force / width
    wall_nu = ratios["wall_poisson"]
    pin, wall = (1.0 - poisson**2) / modulus, (1.0 - wall_nu**2) / given["wall_modulus"]
    half = math.sqrt(4.0 * load * radius * (pin + wall) / math.pi)
    if not half < 0.1 * min(radius, given["depth"]):
        rule = "so small that the contact is narrow compared with radius and depth"
        raise validate.fail("force", rule, force, "give a smaller force or a wider contact")
    approach = pin * (2.0 * math.log(4.0 * radius / half) - 1.0)
    approach += wall * (2.0 * math.log(2.0 * given["depth"] / half) - wall_nu / (1.0 - wall_nu))
    return math.pi * width / approach
