"""The flat parts of a mechanism, each relative to its own axis, in metres, and their inertia.

A part has its final size: the kerf of a cutter is added by the export.
"""

import math
from dataclasses import replace
from functools import singledispatch
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.spoken import spoken_length
from escapement.mechanisms import EllipticalPlanetary, GearDriven, Geneva, Outlines, Runaway
from escapement.mechanisms.escape_wheel import EscapeWheel
from escapement.mechanisms.protocol import checked
from escapement.model.escapement import Inertia
from escapement.outlines.bores import bore, hole
from escapement.outlines.curves import Curve
from escapement.outlines.fits import Fits
from escapement.outlines.fixtures import base_plate, coupon, dowel_centres, foot, pin_and_washer
from escapement.outlines.gaps import outside, segments_of
from escapement.outlines.gears import EllipticalOutline, GearDrivenOutline, pitch_curve
from escapement.outlines.geneva import GenevaOutline
from escapement.outlines.meshed import elliptical_teeth, toothed_gears
from escapement.outlines.part import Part, link
from escapement.outlines.touching import PLATE, edges_of, pallet_centres, plate

_FIXTURES = "dowel_radius", "washer_radius", "screw_radius", "coupon_step"
_SPECIAL = "pin_fit", "locking_radius", "clearance", "teeth", *_FIXTURES
_USED: dict[type, tuple[str, ...]] = {
    Geneva: ("pin_fit", "locking_radius", *_FIXTURES),
    GearDriven: ("pin_fit", "clearance"),
    EllipticalPlanetary: ("clearance", "teeth"),
    Runaway: ("pin_fit",),
}
"""Which of the special fits a kind of mechanism has a use for; other kinds have none."""
_WALL = 0.07  # around pins and shafts, in the mechanism's unit of length
_SHAFT = 0.12


@singledispatch
def _parts(mechanism: Any, fits: Fits) -> list[Part]:
    raise InvalidValue(
        f"{mechanism.kind} has no parts that could be drawn; "
        "choose a kind with bodies, such as geneva or runaway"
    )


def parts_of(mechanism: Any, fits: Fits | None = None) -> tuple[Part, ...]:
    """The flat parts of a mechanism, in metres, each about its own axis.

    Parameters
    ----------
    mechanism : Mechanism
        One with bodies, with its size and the radius of its pins, and without errors of its parts.
    fits : Fits, optional
        Default: holes with the size of their pins and shafts.

    Returns
    -------
    tuple of Part
        A Geneva wheel has "driver", "locking-disc", "follower" and "plate", and, where
        `fits` asks for them, "pin" and "washer", "base" and four times "foot", and "coupon". A
        gear-driven one has "follower", "pin-disc", "carrier", "planet" and "fixed-gear",
        elliptical gears have "driven", "driving", "sun", "planet" and "carrier", and an escape
        wheel has "wheel", "verge" and, unless they are pins, "entry-pallet" and "exit-pallet".

    Raises
    ------
    InvalidValue
        If the size or the radius of the pins is missing, a hole leaves no wall, or a fit has no
        effect on this kind of mechanism.
    """
    fits = fits or Fits()
    known = _parts.dispatch(type(mechanism)) is not _parts.dispatch(object)
    for name in _SPECIAL:
        unused = name not in _USED.get(type(mechanism), ())
        if known and unused and (value := getattr(fits, name)):
            own = "give that of the wheel" if mechanism.takes_clearance else "leave it out"
            remedy = own if name == "clearance" else "leave it out"
            rule = f"0 for {mechanism.kind} parts, which do not need it"
            raise validate.fail(name, rule, value, remedy)
    found = _parts(checked(mechanism), fits)
    for part in found:
        part.check()
    return tuple(found)


def outline_of(mechanism: Any, fits: Fits) -> GenevaOutline | GearDrivenOutline | EllipticalOutline:
    """The bodies of a mechanism, in their final size."""
    if isinstance(mechanism, EllipticalPlanetary):
        gears = toothed_gears(mechanism, fits.teeth, fits.clearance)
        driven, driving = gears["driven"], gears["driving"]
        if driven is None or driving is None:
            return EllipticalOutline(mechanism)
        teeth = elliptical_teeth(mechanism, fits.teeth) or 0
        return EllipticalOutline(mechanism, (driven, driving), teeth)
    size, _ = _sized(mechanism)
    if isinstance(mechanism, GearDriven):
        return GearDrivenOutline(mechanism, fits.clearance)
    outline = GenevaOutline(mechanism, exaggerate=0.0)
    if fits.locking_radius:
        outline = _with_locking(outline, fits.locking_radius, size)
    outline.driver_shaft = fits.driver_shaft_radius / size or outline.driver_shaft
    outline.follower_shaft = fits.follower_shaft_radius / size or outline.follower_shaft
    return outline


def _with_locking(outline: GenevaOutline, radius: float, size: float) -> GenevaOutline:
    """The bodies with another radius of the locking arcs [m]; InvalidValue if it is impossible."""
    low = size * abs(outline.mechanism.centre_distance - outline.rim_radius)
    high = size * (1.0 - outline.half_slot)
    rule = f"between {spoken_length(low)} and {spoken_length(high)} here"
    remedy = "choose another, or leave it out"
    if outline.mechanism.continuous:
        rule, remedy = "0 for a wheel without a dwell", "leave it out, or choose fewer pins"
    elif low < radius < high:
        chosen = GenevaOutline(outline.mechanism, lock_radius=radius / size)
        if chosen.locking_edge:
            return chosen
        rule = "such that the hollows for the wheel leave some of the locking disc"
    raise validate.fail("locking_radius", rule, spoken_length(radius), remedy)


@_parts.register
def _(mechanism: Geneva, fits: Fits) -> list[Part]:
    size, pin = _sized(mechanism)
    outline: Any = outline_of(mechanism, fits)
    axis = size * outline.driver_shaft
    shaft = bore(axis, fits)
    centres = (size * (outline.pin_centres(0.0) - mechanism.centre_distance)).tolist()
    pins = [hole(pin, centre, fits.pin_fit, "pin") for centre in centres]
    lock = outline.locking_edge
    marks: tuple[Curve, ...] = (lock.moved(size),) if lock else ()
    edge = Curve.circle(size * outline.crank_disc_radius)
    found = [Part("driver", edge, (shaft, *pins), marks, (0.0, *centres))]
    if lock:
        # the crescent of an internal wheel does not reach the axis: it is fastened to the driver
        found.append(Part("locking-disc", marks[0], () if mechanism.internal else (shaft,)))
    if fits.dowel_radius:
        found = _with_dowels(found, outline, fits)
    wheel = [curve.moved(size) for curve in outline.follower_edges]
    follower_shaft = size * outline.follower_shaft
    centre = () if mechanism.internal else (bore(follower_shaft, fits),)
    # an internal wheel is a ring; its edge that faces the driver is a hole
    found.append(Part("follower", wheel[-1], (*wheel[:-1], *centre)))
    plate = link("plate", size * mechanism.centre_distance, follower_shaft or axis, axis, fits)
    return [*found, plate, *_fixtures(outline, plate, fits)]


def _with_dowels(discs: list[Part], outline: GenevaOutline, fits: Fits) -> list[Part]:
    """Driver and locking disc with the holes of the dowels that hold them together."""
    if len(discs) < 2:
        rule, size = "0 for a wheel without a locking disc", spoken_length(fits.dowel_radius)
        raise validate.fail("dowel_radius", rule, size, "leave it out")
    pins = int(outline.mechanism.pins or 1)
    centres = dowel_centres(discs, pins, outline.side, fits).tolist()
    holes = [hole(fits.dowel_radius, at, fits.pin_fit, "pin") for at in centres]
    return [
        disc._replace(holes=(*disc.holes, *holes), axes=(*disc.axes, *centres)) for disc in discs
    ]


def _fixtures(outline: GenevaOutline, plate: Part, fits: Fits) -> list[Part]:
    """Washers, base plate with feet, and coupon, as far as they are asked for."""
    size, pin = _sized(outline.mechanism)
    found, pins = list[Part](), int(outline.mechanism.pins or 1)
    if fits.washer_radius:
        room = outline.slot_end - outline.follower_shaft
        found += pin_and_washer(pin, size * room, fits) * pins
    if fits.screw_radius:
        radii = size * outline.follower_radius, size * outline.crank_disc_radius
        apart = size * outline.mechanism.centre_distance
        found.append(base_plate(apart, radii, [*plate.holes], fits.screw_radius))
        found += [foot(fits.screw_radius)] * 4
    if fits.coupon_step:
        contact = size * outline.mechanism.contact_radius
        found.append(coupon(pin, size * outline.half_slot, contact, fits))
    return found


@_parts.register
def _(mechanism: GearDriven, fits: Fits) -> list[Part]:
    fewer = {"unused_lobes": mechanism.unused_lobes, "through_centre": mechanism.through_centre}
    for name, value in fewer.items():
        if value:
            rule = f"{type(value)()} in drawings of parts"
            raise validate.fail(name, rule, value, "choose another number of lobes")
    size, pin = _sized(mechanism)
    outline = GearDrivenOutline(mechanism, fits.clearance)
    if not outline.half_slot < mechanism.widest_pin:
        most = 2.0 * size * (mechanism.widest_pin - mechanism.contact_radius)
        rule = f"less than {spoken_length(most)}, where neighbouring slots meet"
        raise validate.fail(
            "clearance", rule, spoken_length(fits.clearance), "choose less, or thinner pins"
        )
    arm, inner = mechanism.arm_over_fixed, outline.slot_end - outline.half_slot
    axis = fits.driver_shaft_radius or size * min(_SHAFT, 0.5 * outline.planet_radius, 0.5 * arm)
    follower_shaft = fits.follower_shaft_radius or size * min(_SHAFT, 0.5 * inner)
    turns = np.exp(2j * np.pi * np.arange(mechanism.pins) / mechanism.pins)
    centres = (size * arm * turns).tolist()
    pins = [hole(pin, centre, fits.pin_fit, "pin") for centre in centres]
    shaft, centre = bore(axis, fits), bore(follower_shaft, fits)
    bearing = hole(follower_shaft, 0.0, fits.shaft_fit, "shaft")
    wheel = [curve.moved(size) for curve in outline.wheel_edges()]
    disc = Curve.circle(size * (arm + outline.pin_radius + _WALL))
    return [
        Part("follower", wheel[-1], (*wheel[:-1], *((centre,) if outline.inward else ()))),
        Part("pin-disc", disc, (shaft, *pins), axes=(0.0, *centres)),
        link("carrier", size * mechanism.carrier_over_fixed, follower_shaft, axis, fits),
        Part("planet", Curve.circle(size * outline.planet_radius), (shaft,), toothed=True),
        Part("fixed-gear", Curve.circle(size), (bearing,), toothed=True),
    ]


@_parts.register
def _(mechanism: EllipticalPlanetary, fits: Fits) -> list[Part]:
    least = _SHAFT * mechanism.planet_radius
    radii = fits.follower_shaft_radius or least, fits.driver_shaft_radius or least
    axis, shaft = (bore(radius, fits) for radius in radii)
    bearing = hole(radii[0], 0.0, fits.shaft_fit, "shaft")
    driving, driven = (
        pitch_curve(1e3 * oval.semi_major_axis, oval.eccentricity).moved(1e-3)
        for oval in mechanism.pitch_ellipses
    )
    gears = [
        ("driven", driven, axis),
        ("driving", driving, shaft),
        ("sun", Curve.circle(mechanism.sun_radius), bearing),
        ("planet", Curve.circle(mechanism.planet_radius), shaft),
    ]
    cut = toothed_gears(mechanism, fits.teeth, fits.clearance)
    # a gear that is drawn without its teeth is only engraved
    found = [
        Part(name, cut[name] or pitch, (hole,), toothed=cut[name] is None)
        for name, pitch, hole in gears
    ]
    return [*found, link("carrier", mechanism.centre_distance, *radii, fits)]


@_parts.register
def _(mechanism: EscapeWheel, fits: Fits) -> list[Part]:
    size, pins = mechanism.wheel_radius, isinstance(mechanism, Runaway) and mechanism.pin_radius
    wheel, *_ = edges_of(mechanism.driver_chains, mechanism.driver_fold)
    pallets = [edge.moved(size) for edge in edges_of(mechanism.follower_chains)]
    radii = (
        fits.driver_shaft_radius or _SHAFT * size,
        fits.follower_shaft_radius or 0.5 * PLATE * size,
    )
    shaft, axis = (bore(radius, fits) for radius in radii)
    found = [Part("wheel", wheel.moved(size), (shaft,))]
    centres = [size * centre for centre in pallet_centres(mechanism)]
    edge = plate(mechanism, max(PLATE, 2.0 * radii[1] / size)).moved(size)
    if pins:
        holes = [hole(float(pins), centre, fits.pin_fit, "pin") for centre in centres]
        return [*found, Part("verge", edge, (axis, *holes), axes=(0.0, *centres))]
    if fits.pin_fit:
        rule, got = "0 for flat pallets", spoken_length(fits.pin_fit)
        raise validate.fail("pin_fit", rule, got, "leave it out")
    names = ("entry-pallet", "exit-pallet")
    cut = [
        Part(name, pallet.moved(by=-centre), axes=())
        for name, pallet, centre in zip(names, pallets, centres, strict=True)
    ]
    return [*found, Part("verge", edge, (axis,), tuple(pallets)), *cut]


@_parts.register
def _(mechanism: Outlines, fits: Fits) -> list[Part]:
    size, found = mechanism.crank_radius, list[Part]()
    bodies = {
        "driver": edges_of(mechanism.driver_chains, mechanism.driver_fold),
        "follower": edges_of(mechanism.follower_chains, mechanism.follower_fold),
    }
    for name, outline in bodies.items():
        radius = getattr(fits, f"{name}_shaft_radius")
        edges = [edge.moved(size) for edge in outline]
        holes = tuple(edge for edge in edges if edge.moments.area < 0.0)
        whole = [edge for edge in edges if edge.moments.area > 0.0]
        shaft = (bore(radius, fits),) if radius else ()
        solid = len(whole) == 1 and outside(segments_of(whole), np.zeros(1, complex))[0] < 0.0
        if shaft and not solid:
            rule, got = "0 for a body without material at its axis", spoken_length(radius)
            raise validate.fail(f"{name}_shaft_radius", rule, got, "leave it out")
        for number, edge in enumerate(whole):
            cut = (*holes, *shaft) if len(whole) == 1 else ()
            found.append(Part(f"{name}-{number}" if len(whole) > 1 else name, edge, cut))
    return found


def _sized(mechanism: Geneva | GearDriven) -> tuple[float, float]:
    """Unit of length and radius of the pins [m], both of which parts need."""
    unit = "crank_radius" if isinstance(mechanism, Geneva) else "fixed_radius"
    size, pin = mechanism.crank_radius, mechanism.pin_radius
    for name, value in ((unit, size), ("pin_radius", pin)):
        if not value:
            raise validate.fail(name, "given for drawings of parts", value, "give it in m")
    return float(size), float(pin)  # type: ignore[arg-type]


def disc_inertia(
    mechanism: Geneva, thickness: float, density: float, fits: Fits | None = None
) -> Inertia:
    """Inertia of driver and follower of a Geneva wheel, of one material and thickness.

    Parameters
    ----------
    mechanism : Geneva
        As for `parts_of`.
    thickness : float
        Thickness of driver, locking disc and follower [m], > 0.
    density : float
        Density of the material [kg/m^3], > 0.
    fits : Fits, optional
        As for `parts_of`.

    Returns
    -------
    Inertia
        The driver has its locking disc and its pins, which reach through it and the follower.
        Rollers are solid. The inertia of shafts and of everything else that turns with them has
        to be added.
    """
    if not isinstance(checked(mechanism), Geneva):
        raise validate.fail("mechanism", "a Geneva", mechanism, "sum up `parts_of` of others")
    thick = validate.positive("thickness", thickness, "give it in m")
    dense = validate.positive("density", density, "give it in kg/m^3, 7850 for steel")
    # dowels fill their holes
    solid = replace(fits or Fits(), dowel_radius=0.0)
    found = {part.name: part for part in parts_of(mechanism, solid)}
    driver = sum(found[name].inertia(thick, dense) for name in found if name in _DRIVER)
    inner, crank = mechanism.pin_radius, float(mechanism.crank_radius or 0.0)
    for radius in (inner, mechanism.roller_radius or inner):
        mass = math.pi * radius**2 * thick * dense * int(mechanism.pins or 1)
        driver += mass * (crank**2 + 0.5 * radius**2)
    return Inertia(driver, found["follower"].inertia(thick, dense))


_DRIVER = ("driver", "locking-disc")
