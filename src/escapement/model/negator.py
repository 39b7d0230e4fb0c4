"""The torque of a constant-force spring: a curled strip that winds itself from drum to drum.

The strip has been curled to a radius Rn and lies on a storage drum of radius Rs, in the sense of
its curl. It is wound onto the output drum, of radius R, against its curl. Each piece that passes
from the output drum to the storage drum gives back its energy of bending, and the output drum
turns by the piece's length over R. With the stiffness E b t^3/12 of a strip of width b and
thickness t, and curvatures counted from that of the curl, the torque is

    M = E b t^3 R/24 [(1/Rn + 1/R)^2 - (1/Rn - 1/Rs)^2]

which is constant but for the layers on the drums. The last term vanishes where the strip keeps
the radius of its curl on the storage drum.
"""

from escapement.base import validate


def negator_torque(
    width: float,
    thickness: float,
    natural_radius: float,
    output_radius: float,
    storage_radius: float | None = None,
    modulus: float = 200e9,
) -> float:
    """Torque of a constant-force spring on its output drum [N m].

    Parameters
    ----------
    width, thickness : float
        Of the strip [m], > 0.
    natural_radius : float
        Radius to which the free strip curls [m], > 0.
    output_radius : float
        Radius at which the strip lies on the output drum, against its curl [m], > 0.
    storage_radius : float, optional
        Radius at which it lies on the storage drum, which turns freely [m]; at least the natural
        radius, which is the default.
    modulus : float
        Young's modulus of the strip [Pa], > 0; default: steel.

    Returns
    -------
    float
        The torque while strip is left on the output drum. N turns of this drum, the layers
        apart, need a strip of the length 2 pi N output_radius.

    Raises
    ------
    InvalidValue
        When a number breaks its rule.

    Notes
    -----
    The strip bends elastically, like a beam: the greatest stress, modulus thickness/2 times
    (1/natural_radius + 1/output_radius), must stay below its strength. A wide strip cannot curve
    across and is stiffer, by up to a tenth. Friction in bearings and between layers is left out.

    Source: F. A. Votta, The Theory and Design of Long-Deflection Constant-Force Spring Elements,
    Trans. ASME 74 (1952), 439-450; A. M. Wahl, Mechanical Springs (1963), which Meyer (1973)
    cites for the neg'ator spring of his Appendix C. The last term is that of the same balance
    of energy for a wider storage drum.
    """
    b = validate.positive("width", width, "give the width of the strip in m")
    t = validate.positive("thickness", thickness, "give the thickness of the strip in m")
    curl = validate.positive("natural_radius", natural_radius, "give the curl of the strip in m")
    drum = validate.positive("output_radius", output_radius, "give the output drum's radius in m")
    e = validate.positive("modulus", modulus, "give Young's modulus in Pa, 200e9 for steel")
    store = curl
    if storage_radius is not None:
        store = validate.positive("storage_radius", storage_radius, "give its radius in m")
    if store < curl:
        rule = f"at least the natural_radius, {curl!r} m"
        remedy = "on a smaller drum the strip lies at its natural radius"
        raise validate.fail("storage_radius", rule, storage_radius, remedy)
    bent, stored = 1.0 / curl + 1.0 / drum, 1.0 / curl - 1.0 / store
    return e * b * t**3 / 24.0 * drum * (bent - stored) * (bent + stored)
