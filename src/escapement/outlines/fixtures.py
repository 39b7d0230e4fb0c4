"""What a Geneva wheel needs to be put together: dowels, washers, a base plate, a test of fits."""

import math

import numpy as np

from escapement.base import validate
from escapement.base.spoken import spoken_length
from escapement.outlines.bores import hole
from escapement.outlines.curves import ComplexArray, Curve, chain
from escapement.outlines.fits import Fits
from escapement.outlines.gaps import outside, segments_of
from escapement.outlines.part import Part

_SIZES = range(-2, 3)  # steps from the nominal size of the holes and slots of a coupon
_PITCH = 8e-3  # least distance of neighbours on a coupon, where their sizes are engraved [m]


def dowel_centres(discs: list[Part], pins: int, side: float, fits: Fits) -> ComplexArray:
    """Centres of two dowels that hold all of these discs, mirrored about the line to pin 0.

    They are as far apart as walls that are as wide as a dowel allow. With a single pin both stand
    behind the axis, so that the discs fit together in one position only.
    """
    turn = np.linspace(2.0 / 3.0, 1.0, 81)[:, None] * math.pi / pins
    out = float(np.abs(discs[-1].edge.corners).max())
    points = (side * out * np.linspace(0.0, 1.0, 121) * np.exp(1j * turn)).ravel()
    room = np.abs(points.imag)
    for disc in discs:
        room = np.minimum(room, -outside(segments_of([disc.edge, *disc.holes]), points)[0])
    good = room >= 3.0 * fits.dowel_radius
    if not good.any():
        rule = f"at most {spoken_length(room.max() / 3.0)}, so that walls of its diameter"
        raise validate.fail(
            "dowel_radius", f"{rule} remain", spoken_length(fits.dowel_radius),
            "choose a thinner dowel, or a larger wheel")  # fmt: skip
    best = points[np.argmax(np.where(good, np.abs(points.imag), -1.0))]
    return np.array([best, best.conjugate()])


def base_plate(apart: float, radii: tuple[float, float], axes: list[Curve], screw: float) -> Part:
    """A plate under both wheels, with a screw in each corner beside them.

    radii : of follower and driver, which turn about 0 and `apart`. axes : holes of their shafts.
    screw : radius of a screw hole.
    """
    left = -max(radii[0], radii[1] - apart)
    right, high = max(radii[0], apart + radii[1]), max(radii)
    corners = [left - 1j * high, right - 1j * high, right + 1j * high, left + 1j * high]
    edge = chain(corners, np.zeros(4)).grown(3.0 * screw)
    screws = (Curve.circle(screw, at).reversed() for at in corners)
    return Part("base", edge, (*axes, *screws), axes=(0.0, apart, *corners))


def foot(screw: float) -> Part:
    """A foot under a corner of the base plate."""
    return Part("foot", Curve.circle(3.0 * screw), (Curve.circle(screw).reversed(),))


def pin_and_washer(pin: float, room: float, fits: Fits) -> list[Part]:
    """The outline of a pin, and the washer that keeps the follower on it.

    room : from the pin's axis to the shaft of the follower, which the washer passes [m].
    """
    inner, radius = hole(pin, 0.0, fits.pin_fit, "pin"), fits.washer_radius
    least = abs(complex(inner.corners[0]))
    if not least < radius < room:
        low, high = (spoken_length(size) for size in (least, room))
        rule = f"between {low} and {high} here, to hold the wheel and to pass its shaft"
        raise validate.fail("washer_radius", rule, spoken_length(radius), "choose another")
    return [Part("pin", Curve.circle(pin)), Part("washer", Curve.circle(radius), (inner,))]


def coupon(pin: float, half_slot: float, contact: float, fits: Fits) -> Part:
    """A plate with five pin holes and five slots, a step from size to size, the chosen one third.

    pin, contact : radii of the pin and of what touches the slot. half_slot : half the slot's width.
    """
    most = min(pin + 0.5 * fits.pin_fit, half_slot)
    if not fits.coupon_step < most:
        rule = f"less than {spoken_length(most)}, half a pin hole or slot"
        size = spoken_length(fits.coupon_step)
        raise validate.fail("coupon_step", rule, size, "choose less")
    pitch = max(_PITCH, 4.0 * (contact + half_slot))
    # a pin hole with a slot above it, and what either has more than the chosen size
    pairs = [(complex((k + 2.5) * pitch, pitch), k * fits.coupon_step) for k in _SIZES]
    holes = [hole(pin, at, fits.pin_fit + step, "pin") for at, step in pairs]
    notes = [(at - (0.4 + 0.8j) * pitch, 2.0 * pin + fits.pin_fit + step) for at, step in pairs]
    notes += [(at - (0.4 - 0.5j) * pitch, 2.0 * half_slot + step) for at, step in pairs]
    corners, turns = [0.0, 5.0 * pitch, (5.0 + 3.0j) * pitch], [0.0] * 3
    for at, step in reversed(pairs):
        half = half_slot + 0.5 * step
        mouth, end = at + 2j * pitch, at + 1.25j * pitch
        corners += [mouth + half, end + half, end - half, mouth - half]
        turns += [0.0, -math.pi, 0.0, 0.0]
    edge = chain([*corners, 3j * pitch], [*turns, 0.0])
    return Part("coupon", edge, tuple(holes), axes=(), notes=tuple(notes))
