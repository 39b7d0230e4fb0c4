"""The problem as plain values: a mechanism, two inertias, losses and a drive."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import cached_property, wraps
from typing import Any, TypeVar, cast

from escapement.base import validate
from escapement.base.lazy import FloatArray, np
from escapement.base.quantity import Choice, Declared, Setting, declared, quantity, setting
from escapement.base.spoken import as_spoken
from escapement.mechanisms.path import Pair, Path, one_pitch
from escapement.mechanisms.protocol import Mechanism, checked
from escapement.mechanisms.wheel_checks import check_lengths
from escapement.model.checks import (
    check_contact,
    check_load,
    check_losses,
    check_outlines,
    check_pin,
    check_speeds,
    check_trains,
    idle_settings,
)
from escapement.model.load_curve import Load, LoadSetting, steps_of
from escapement.model.materials import MATERIALS, MaterialSetting
from escapement.model.motor import Motor
from escapement.model.natural import natural
from escapement.model.scene import Joint, Scene
from escapement.model.torque_curve import MOST_KNOTS, Torque, TorqueCurve
from escapement.model.train import (
    ROLES,
    Train,
    numbers_of_trains,
    referred,
    train_numbers,
    trains_of,
)

T = TypeVar("T")
STRESSES = "Stresses of the pin"
_MATERIAL = f"a name ({', '.join(MATERIALS)}), or modulus in Pa and Poisson's ratio"
CONTACT_LAWS = ("linear", "hunt-crossley")
FRICTION, AIR, CONTACT = "Friction", "Air", "Clearance and contact"
SWINGING = "Spring and weight of the follower"
"""Headings of the groups of numbers."""
MOST_CELLS, SAME_CELLS = 64, 1e-9
"""A torque repeats after so many cells at most, and cells and its period may differ by a share."""


@dataclass(frozen=True, repr=False)
class Inertia(Declared):
    """Moments of inertia about the two axes.

    Parameters
    ----------
    driver : float
        Driver and everything that turns with it [kg m^2], > 0.
    follower : float
        Follower and everything that turns with it [kg m^2], > 0.
    """

    section = "inertia"

    driver: float = field(metadata=quantity(
        "moment of inertia of the driver", "inertia", exclusive=True, name="driver_inertia",
        remedy="give the moment of inertia", note=" and what turns with it"
    ))  # fmt: skip
    follower: float = field(metadata=quantity(
        "moment of inertia of the follower", "inertia", exclusive=True, name="follower_inertia",
        remedy="give the moment of inertia", note=" and what turns with it"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()


def _bearing_friction(body: str) -> dict[str, Any]:
    return quantity(
        f"coefficient of friction of the {body}'s bearing", metavar="MU", slotted=True,
        instead="driver_bearing_torque", remedy="give a coefficient of friction, 0 for none",
        needs=f"{body}_bearing_radius", group=FRICTION,
    )  # fmt: skip


def _bearing_radius(body: str) -> dict[str, Any]:
    return quantity(
        f"radius of the {body}'s journal", "length", slotted=True,
        instead="driver_bearing_torque", remedy="give the radius, 0 for none",
        needs=f"{body}_bearing_friction", group=FRICTION,
    )  # fmt: skip


def _drag(body: str) -> dict[str, Any]:
    return quantity(
        f"drag of the {body} divided by the square of its speed", "drag", metavar="C",
        remedy="give the drag torque divided by the square of the speed, 0 for none",
        scene=f"{body}_drag", group=AIR,
    )  # fmt: skip


def _viscous(body: str) -> dict[str, Any]:
    return quantity(
        f"viscous drag of the {body} divided by its speed", "viscous", metavar="C",
        remedy="give the drag torque divided by the speed, 0 for none",
        scene=f"{body}_viscous", group=AIR,
    )  # fmt: skip


def _of_follower(what: str, unit: str, **rule: Any) -> dict[str, Any]:
    return quantity(what, unit, group=SWINGING, **rule)


def _of_pin(what: str, **rule: Any) -> dict[str, Any]:
    return quantity(
        what, "length", remedy="give the length", slotted=True, instead="efficiency",
        group=STRESSES, **rule,
    )  # fmt: skip


def _material(of: str) -> dict[str, Any]:
    return setting(MaterialSetting(
        long_name=f"material of the {of}, {_MATERIAL}", metavar="NAME", group=STRESSES,
        remedy="name a material, or give two numbers, 206e9,0.3", needs="pin_length",
        slotted=True, instead="efficiency",
    ))  # fmt: skip


@dataclass(frozen=True, repr=False)
class Escapement(Declared):
    """A mechanism with inertia and losses under a driving torque.

    Parameters
    ----------
    mechanism : Mechanism
        Geometry, for example `Geneva(slots=4)`.
    inertia : Inertia
        Moments of inertia [kg m^2].
    torque : float, TorqueCurve or Motor
        Torque on the driver [N m], > 0, at the start of the motion; constant unless there is a
        spring rate. Meyer's "spring rate" K. A `TorqueCurve` gives it over the angle turned, over
        the driver speed, or over both. A `Motor` gives its stall torque and its no-load speed.
    friction : float
        Coefficient of friction between pin and slot [-], >= 0.
    load_torque : float
        Constant torque opposing the follower while it moves [N m], >= 0.
    load_curve : LoadCurve or Unbalance, optional
        Torque on the follower over its angle, in addition to `load_torque`: a curve that repeats
        in a step or a turn, or a weight out of balance.
    efficiency : float
        Share of the power that gears pass on, in either direction [-], in [0.001, 1]. It replaces
        friction in a mechanism without slots; a mechanism with slots has 1.
    driver_bearing_friction, follower_bearing_friction : float
        Coefficient of friction of the journals, which carry the contact force [-].
    driver_bearing_radius, follower_bearing_radius : float
        Radii of the journals [m]. The driver of a gear-driven wheel has none, because its
        bearing carries the force of the mesh as well.
    driver_bearing_torque : float
        Torque of the driver's bearing that does not depend on the contact [N m].
    driver_drag, follower_drag : float
        Drag torque divided by the square of the speed, as in air [N m s^2/rad^2].
    driver_viscous, follower_viscous : float
        Drag torque divided by the speed, as in oil [N m s/rad].
    spring_rate : float
        Torque that a spring loses per driver angle turned since the start of the motion [N
        m/rad], >= 0, until its torque is zero.
    no_load_speed : float, optional
        Speed of a motor at which it gives no torque [rad/s], > 0; at rest it gives `torque`, and
        in between a straight line. By default the torque does not depend on the speed.
    barrel : Train, optional
        Train between a barrel and the driver, or the gearbox of a motor. `torque`, `spring_rate`
        and `no_load_speed` are then those of the barrel, and the angles and speeds of a
        `TorqueCurve` its own.
    load_train : Train, optional
        Train after the follower. `load_torque` then acts on its last shaft.

    follower_spring : float
        Torque of a spring on the follower per angle, of a mechanism whose bodies touch with their
        outlines, such as that of a balance [N m/rad].
    follower_gravity : float
        Greatest torque of the follower's weight, m g l of a pendulum [N m].
    follower_rest_angle : float
        Follower angle at which its spring and its weight give no torque [rad].

    restitution : float
        Ratio of the impulse of rebound to that of compression in an impact [-], in [0, 1).
    stiffness : float
        Force of a wall of the slot divided by the penetration of the pin [N/m]; 0 for rigid
        bodies.
    damping : float, optional
        Force of a wall divided by the speed of penetration [N s/m]. By default linear walls have
        critical damping, 2 sqrt(k m) with the stiffness k and m = I_d I_f/((I_d + I_f) r^2); 0 is
        a wall without damping.
    contact_law : str
        "linear", or "hunt-crossley", whose force grows with the power 1.5 of the penetration.
    slip_speed : float
        Sliding speed below which the friction of a compliant contact fades [m/s].

    pin_length, pin_gap : float
        Length of the pin in its slot, and the gap between driver and slot, for its stresses [m].
    pressure_pin_radius : float
        Radius of the pin for its stresses alone [m]; by default that of the pin or roller.
    pin_material, wheel_material : str or Material
        A name in `MATERIALS`, or Young's modulus [Pa] and Poisson's ratio.

    Lengths can be given only if the mechanism has a size, `crank_radius` or `fixed_radius`.

    Source: Meyer (1973), chapter I; all from the load torque on are extensions.
    """

    mechanism: Mechanism
    inertia: Inertia
    torque: float | TorqueCurve | Motor = field(metadata=setting(Torque(
        long_name="driving torque", unit="torque", exclusive=True, metavar="M",
        note=", or FILE.csv with driver angles turned, speeds or both, and torques",
        remedy="give the constant driving torque"
    )))  # fmt: skip
    friction: float = field(default=0.0, metadata=quantity(
        "coefficient of friction between pin and slot", metavar="MU", slotted=True,
        instead="efficiency", remedy="give a coefficient of friction, 0 for none", group=FRICTION
    ))  # fmt: skip
    load_torque: float = field(default=0.0, metadata=quantity(
        "load torque on the follower", "torque", remedy="give the opposing torque, 0 for none",
        scene="load"
    ))  # fmt: skip
    load_curve: Load | None = field(default=None, metadata=setting(LoadSetting(
        long_name="load over the follower angle", unit="torque", metavar="FILE.csv",
        note=", a file with follower angles and torques",
        remedy="give a LoadCurve or an Unbalance"
    )))  # fmt: skip
    efficiency: float = field(default=1.0, metadata=quantity(
        "share of the power that the mesh passes on", metavar="E", slotted=False,
        instead="friction", minimum=1e-3, maximum=1.0, note=", instead of friction",
        remedy="give a share of 1, 1 for no loss", group=FRICTION
    ))  # fmt: skip
    driver_bearing_friction: float = field(default=0.0, metadata=_bearing_friction("driver"))
    driver_bearing_radius: float = field(default=0.0, metadata=_bearing_radius("driver"))
    follower_bearing_friction: float = field(default=0.0, metadata=_bearing_friction("follower"))
    follower_bearing_radius: float = field(default=0.0, metadata=_bearing_radius("follower"))
    driver_bearing_torque: float = field(default=0.0, metadata=quantity(
        "constant torque of the driver's bearing", "torque",
        remedy="give the resisting torque, 0 for none", scene="bearing", group=FRICTION
    ))  # fmt: skip
    driver_drag: float = field(default=0.0, metadata=_drag("driver"))
    follower_drag: float = field(default=0.0, metadata=_drag("follower"))
    driver_viscous: float = field(default=0.0, metadata=_viscous("driver"))
    follower_viscous: float = field(default=0.0, metadata=_viscous("follower"))
    spring_rate: float = field(default=0.0, metadata=quantity(
        "torque that the spring loses per driver angle", "rate", metavar="K",
        remedy="give the loss of torque per angle, 0 for a constant torque"
    ))  # fmt: skip
    no_load_speed: float | None = field(default=None, metadata=quantity(
        "speed at which a motor gives no torque", "speed", exclusive=True,
        note=", which falls in a straight line from that at rest",
        remedy="give the speed without a load, or leave it out for a constant torque"
    ))  # fmt: skip
    follower_spring: float = field(default=0.0, metadata=_of_follower(
        "torque of a spring on the follower per angle", "rate", metavar="K",
        remedy="give the stiffness, 0 for no spring",
    ))  # fmt: skip
    follower_gravity: float = field(default=0.0, metadata=_of_follower(
        "greatest torque of the follower's weight", "torque", metavar="M",
        remedy="give weight times distance of its centre, 0 for none",
    ))  # fmt: skip
    follower_rest_angle: float = field(default=0.0, metadata=_of_follower(
        "follower angle without a torque of its spring and weight", "degrees", metavar="DEG",
        minimum=-math.inf, remedy="give the angle",
    ))  # fmt: skip

    restitution: float = field(default=0.0, metadata=quantity(
        "ratio of rebound impulse to compression impulse in an impact", maximum=1.0, below=True,
        slotted=True, instead="efficiency", metavar="E", remedy="give a restitution, 0 for none",
        needs="clearance", group=CONTACT
    ))  # fmt: skip
    stiffness: float = field(default=0.0, metadata=quantity(
        "force of a slot's wall divided by the penetration", "stiffness", slotted=True,
        instead="efficiency", metavar="K", remedy="give the stiffness, 0 for rigid bodies",
        group=CONTACT
    ))  # fmt: skip
    damping: float | None = field(default=None, metadata=quantity(
        "force of a slot's wall divided by the speed of penetration", "damping", slotted=True,
        instead="efficiency", metavar="D", remedy="give the damping, 0 for none", needs="stiffness",
        note=", by default that of critical damping", group=CONTACT
    ))  # fmt: skip
    contact_law: str = field(default=CONTACT_LAWS[0], metadata=setting(Choice(
        long_name=f"force of a compliant contact: {', '.join(CONTACT_LAWS)}",
        allowed=CONTACT_LAWS, slotted=True, instead="efficiency", metavar="NAME",
        needs="stiffness", group=CONTACT
    )))  # fmt: skip
    slip_speed: float = field(default=0.0, metadata=quantity(
        "sliding speed below which friction fades", "slip", slotted=True,
        instead="efficiency", metavar="V", remedy="give the speed, 0 if the engine shall choose it",
        needs="stiffness", group=CONTACT
    ))  # fmt: skip
    pin_length: float = field(default=0.0, metadata=_of_pin("length of the pin in its slot"))
    pin_gap: float = field(default=0.0, metadata=_of_pin(
        "gap between the driver and the slot, for the bending of the pin", needs="pin_length"
    ))  # fmt: skip
    pressure_pin_radius: float = field(default=0.0, metadata=_of_pin(
        "radius of the pin for its stresses alone", needs="pin_length",
        note=", by default that of the pin or roller",
    ))  # fmt: skip
    pin_material: Any = field(default="steel", metadata=_material("pin"))
    wheel_material: Any = field(default="steel", metadata=_material("wheel"))
    barrel: Train | None = None
    load_train: Train | None = None
    _cells = 1

    def __post_init__(self) -> None:
        checked(self.mechanism, perfect=False)
        if not isinstance(self.inertia, Inertia):
            remedy = "give Inertia(driver=..., follower=...)"
            raise validate.fail("inertia", "an Inertia", self.inertia, remedy)
        self._take_motor()
        self.check_fields()
        for role in ROLES:
            if not isinstance(train := getattr(self, role), Train | None):
                remedy = "give for example Train(ratio=5), or leave it out"
                raise validate.fail(role, "a Train", train, remedy)
        if self.mechanism.pitch is None:
            path: Any = self.mechanism.path
            if not isinstance(path, Path):
                remedy = "make it with two_vector_path or chebyshev_table"
                raise validate.fail("mechanism.path", "a Path", path, remedy)
        check_outlines(self)
        check_losses(self, self.mechanism.meshed)
        self._check_curve()
        check_lengths(vars(self), self.mechanism.crank_radius, self.mechanism.plain_crank)
        check_speeds(self)
        check_trains(self, self.curve is not None)
        check_contact(self.contact, self.mechanism, vars(self))
        check_load(self)
        check_pin(vars(self), self.mechanism)

    def _take_motor(self) -> None:
        """Replace a motor by its numbers."""
        if isinstance(motor := self.torque, Motor):
            given = self.no_load_speed
            if given is not None and given != motor.no_load_speed:
                rule = f"left out with a Motor, whose own is {motor.no_load_speed!r}"
                raise validate.fail("no_load_speed", rule, given, "give torque as a number")
            vars(self).update(torque=motor.stall_torque, no_load_speed=motor.no_load_speed)

    def _check_curve(self) -> None:
        """Refuse a curve together with a spring rate, or with too many points in a cell, and a
        motor with either."""
        if self.no_load_speed is not None and (
            isinstance(self.torque, TorqueCurve) or self.spring_rate > 0.0
        ):
            what = "spring rate" if self.spring_rate > 0.0 else "torque curve"
            remedy = "a motor has a constant torque at rest"
            rule = f"left out with a {what}"
            raise validate.fail("no_load_speed", rule, self.no_load_speed, remedy)
        if isinstance(self.torque, TorqueCurve):
            if self.spring_rate > 0.0:
                remedy = "let its torque fall by itself"
                raise validate.fail(
                    "spring_rate", "0 with a torque curve", self.spring_rate, remedy
                )
            most = self.curve.most_within(self.mechanism.cell_angle) if self.curve else 0
            if most > MOST_KNOTS:
                rule = f"a torque curve with at most {MOST_KNOTS} points in a cell"
                raise validate.fail("torque", rule, most, "leave out points")

    @cached_property
    def drive_curve(self) -> TorqueCurve | None:
        """The torque curve that is given, as the driver sees it; None without one."""
        if not isinstance(self.torque, TorqueCurve):
            return None
        return self.torque.behind(self.barrel.ratio) if self.barrel else self.torque

    @cached_property
    def curve(self) -> TorqueCurve | None:
        """The torque over the driver angle turned, None where it is the same at all angles."""
        if (drive := self.drive_curve) is not None:
            return drive if len(drive.angle) > 1 else None
        torque, rate = self.referred["torque"], self.referred["spring_rate"]
        return TorqueCurve((0.0, torque / rate), (torque, 0.0)) if rate > 0.0 else None

    @cached_property
    def referred(self) -> dict[str, Any]:
        """Its numbers by the names that studies use [SI], as driver and follower see them.

        Without a train they are its own; of a torque curve the torque is the greatest.
        """
        inertia = self.inertia
        values = {
            "driver_inertia": inertia.driver,
            "follower_inertia": inertia.follower,
            **vars(self),
        }
        if isinstance(self.torque, TorqueCurve):
            values["torque"] = self.torque.greatest
            values["top_speed"] = self.torque.speed[-1] if self.torque.speed else None
        return referred(values | self.mechanism.lengths | numbers_of_trains(self.trains))

    @property
    def trains(self) -> dict[str, Train]:
        """Its trains by their roles, "barrel" and "load_train"."""
        roles = {"barrel": self.barrel, "load_train": self.load_train}
        return {role: train for role, train in roles.items() if train is not None}

    @cached_property
    def without_trains(self) -> Escapement:
        """An escapement with the same motion and without trains; itself if it has none."""
        if self.barrel is self.load_train is None:
            return self
        found, none = self.referred, cast(Any, dict.fromkeys(ROLES))
        inertia = Inertia(found["driver_inertia"], found["follower_inertia"])
        torque: Any = self.drive_curve or found["torque"]
        numbers = {name: found[name] for name in ("load_torque", "spring_rate", "no_load_speed")}
        return replace(self, inertia=inertia, torque=torque, **numbers, **none)

    @cached_property
    def contact(self) -> str:
        """Which law of contact it needs: "outlines" of bodies that touch anywhere, "compliant
        outlines" where they yield; else "rigid" where there is clearance, "compliant" where there
        is stiffness, "" where the pins fit their slots exactly.
        """
        if self.mechanism.pitch is not None:
            return "compliant outlines" if self.stiffness > 0.0 else "outlines"
        if self.stiffness > 0.0:
            return "compliant"
        return "rigid" if self.mechanism.clearance > 0.0 else ""

    @property
    def idle(self) -> str:
        """Which settings have no effect, since another one is missing; "" if there are none."""
        clearance = self.mechanism.clearance or self.mechanism.pitch or 0.0
        return idle_settings(type(self), vars(self) | {"clearance": clearance})

    @property
    def critical_damping(self) -> float:
        """Damping with which bodies that only one wall connects just do not swing [N s/m].

        It is 2 sqrt(k m) with the reduced mass of driver and follower at the crank radius r,
        m = I_d I_f/((I_d + I_f) r^2).
        """
        wheel, referred = cast(Any, self.mechanism), self.referred
        driver, follower = referred["driver_inertia"], referred["follower_inertia"]
        reduced = driver / (driver + follower) * follower
        return 2.0 * math.sqrt(self.stiffness * reduced) / float(wheel.crank_radius)

    @property
    def assumed(self) -> str:
        """What is taken for a number of the contact that is not given; "" if all are given."""
        if not self.stiffness or not self._damps_critically:
            return ""
        damping = as_spoken(self.critical_damping, "damping")
        return f"no damping is given: critical damping, {damping}, is taken"

    @cached_property
    def notes(self) -> str:
        """What the results of an escapement say about its settings; "" if there is nothing."""
        drive = self.drive_curve
        of_both = drive is not None and drive.speed and drive.angle
        motor = "figures of a motor need a torque over the speed alone" if of_both else ""
        return "; ".join(filter(None, (self.assumed, self.idle, motor)))

    @property
    def _damps_critically(self) -> bool:
        """Whether linear walls have the damping that they have by default."""
        return self.damping is None and self.contact_law == CONTACT_LAWS[0]

    @cached_property
    def joint(self) -> Joint:
        """The joint of pin and slot in natural units."""
        wheel: Any = self.mechanism
        length, clock = wheel.crank_radius, self.time_unit
        unit = self.torque_unit / length**2
        damping = self.critical_damping if self._damps_critically else self.damping or 0.0
        return Joint(
            half_clearance=0.5 * wheel.clearance / length,
            restitution=self.restitution,
            stiffness=self.stiffness / unit,
            damping=damping / (unit * clock),
            hertz=self.contact_law != CONTACT_LAWS[0],
            slip=self.slip_speed * clock / length,
        )

    @property
    def held(self) -> Escapement:
        """The escapement of which there is a terminal cycle: itself, or the one with the torque of
        its start at all angles where its torque does not repeat in whole cells.
        """
        if self.torque_cells:
            return self
        torque = self.torque.at_start if isinstance(self.torque, TorqueCurve) else self.torque
        return replace(self, torque=torque, spring_rate=0.0)

    @cached_property
    def torque_cells(self) -> int:
        """Cells after which its torque repeats, 1 where it is the same at all angles, 0 where it
        never does.
        """
        if self.curve is None:
            return 1
        if not self.curve.periodic or self.contact:
            return 0
        share = float(self.mechanism.cell_angle) / self.curve.period
        near = Fraction(share).limit_denominator(MOST_CELLS)
        return near.denominator if abs(near - share) <= SAME_CELLS * share else 0

    @cached_property
    def whole_round(self) -> Escapement:
        """The same with `pairs` for all cells after which its torque repeats, as in its cycle."""
        if self.torque_cells < 2:
            return self
        found = replace(self)
        vars(found)["_cells"] = self.torque_cells
        return found

    @cached_property
    def pairs(self) -> tuple[Pair, ...]:
        """Its engagements: one that repeats itself, or a pattern of them, with imperfect parts or a
        load that repeats in a turn of the follower.
        """
        if self.mechanism.pitch is not None:
            return (one_pitch(self.mechanism.pitch),)
        pairs = self.mechanism.pairs
        if self.load_curve is None and self._cells == 1:
            return pairs
        count = math.lcm(len(pairs), self._load_steps, self._cells)
        pairs = pairs * (count // len(pairs))
        if self.contact or self.load_curve is None:
            return pairs
        cells = zip(pairs, self._load_cells, strict=True)
        return tuple(pair._replace(edges=cell.edges) for pair, cell in cells)

    @property
    def _load_steps(self) -> int:
        """Steps of the follower after which its load repeats."""
        load, step = self.load_curve, abs(float(self.mechanism.follower_step))
        return 1 if load is None else steps_of(load, step)

    @cached_property
    def _load_cells(self) -> list[Any]:
        """The load that changes with the follower angle in each of its engagements."""
        if self.load_curve is None or self.contact:
            return []
        from escapement.model.load_cells import load_cells

        found = load_cells(self.load_curve, self.mechanism)
        return found * (math.lcm(len(found), self._cells) // len(found))

    @cached_property
    def scenes(self) -> tuple[Scene, ...]:
        """The escapement as an engine sees it in each of its `pairs`."""
        meshed = self.mechanism.meshed
        numbers: dict[str, Any]
        numbers = {name: float(value) for name, value in natural(self.referred, meshed).items()}
        torque = np.array([0.0, 0.0, 1.0]) if self.curve is None else self.curve.knots()
        pairs, loads = self.pairs, [np.zeros(1)] * len(self.pairs)
        drive = self.drive_curve
        fall = drive.fall() if drive is not None and drive.speed else np.zeros(1)
        if self._load_cells:
            loads = [cell.in_units(self.torque_unit) for cell in self._load_cells]
        elif self.load_curve is not None:
            from escapement.model.load_cells import over_follower

            load = self.load_curve * (1.0 / self.torque_unit)
            step = float(self.mechanism.follower_step)
            loads = [over_follower(load, self._load_steps, step)] * len(pairs)
        cells = zip(pairs, loads, strict=True)
        return tuple(Scene(*m[:3], torque, 0.0, load, fall, **numbers) for m, load in cells)

    @cached_property
    def scene(self) -> Scene:
        """The escapement as an engine sees it in the first of its `pairs`."""
        return self.scenes[0]

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """What engines derive from the scene and keep for their next call."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        """Another process computes the scene and everything that depends on it again."""
        own = {entry.name for entry in fields(self)} | {"_cells"}
        return {key: value for key, value in vars(self).items() if key in own}

    @cached_property
    def time_unit(self) -> float:
        """Natural unit of time, sqrt(I_f / torque) [s].

        In this unit the motion depends only on the mechanism, friction and the ratios of
        inertias, lengths, torques and drag: the torque changes only the unit of time.
        """
        return math.sqrt(self.referred["follower_inertia"] / self.torque_unit)

    @property
    def torque_unit(self) -> float:
        """Natural unit of torque, the greatest torque on the driver [N m]."""
        return float(self.referred["torque"])

    def driver_angle_before(self, engagement: Any) -> Any:
        """Driver angle turned before an engagement [rad]; 0 where the torque is constant."""
        return 0.0 if self.curve is None else self.angle_before(engagement)

    def angle_before(self, engagement: Any) -> Any:
        """Driver angle from the start of the motion to that of an engagement [rad]."""
        begins = self._begins
        angle = engagement * self.mechanism.cell_angle
        return angle + (begins[engagement % begins.size] - begins[0]) if begins.size > 1 else angle

    @cached_property
    def _begins(self) -> FloatArray:
        """Where its engagements begin, from the nominal dead centre of each [rad]."""
        begins: FloatArray = np.array([m.delay + m.edges[0] for m in self.pairs])
        return begins

    def drive_work(self, driver_angle: Any) -> Any:
        """Work of the drive from the start of the motion over a driver angle [J]."""
        return (
            self.torque_unit * driver_angle if self.curve is None else self.curve.work(driver_angle)
        )

    @cached_property
    def jump_works(self) -> FloatArray:
        """Work against the load for the jump of the follower ahead to each of its `pairs` [J]."""
        step = self.mechanism.follower_step
        ends = [
            k * step + float(pair.follower_angle(pair.edges[:1])[0])
            for k, pair in enumerate(self.pairs)
        ]
        cells = zip(self.pairs, ends, strict=True)
        works: FloatArray
        works = np.array([self.load_work(pair.jump, end - pair.jump) for pair, end in cells])
        return works

    def load_work(self, turn: Any, begin: Any = None) -> Any:
        """Work done against the load while the follower turns by angles [rad] [J].

        begin : follower angles from which it turns; None where it turns by whole rounds of a load
            that changes with the angle.
        """
        work = self.referred["load_torque"] * turn
        if (load := self.load_curve) is None:
            return work
        if begin is None:
            return work + turn / load.period * load.work(0.0, load.period)
        return work + load.work(begin, begin + turn)


def once_per_escapement(function: Callable[[Escapement], T]) -> Callable[[Escapement], T]:
    """A function of an escapement whose result is kept on the escapement, for its next call."""

    @wraps(function)
    def first_or_kept(escapement: Escapement) -> T:
        kept = escapement.kept
        if function not in kept:
            kept[function] = function(escapement)
        result: T = kept[function]
        return result

    return first_or_kept


def model_settings() -> dict[str, Setting]:
    """All declared numbers of an escapement without its mechanism, by their names in studies."""
    return {**declared(Escapement), **declared(Inertia), **train_numbers()}


def escapement_of(mechanism: Mechanism, values: Mapping[str, Any]) -> Escapement:
    """The escapement with these values by the names of `model_settings` [SI].

    Values that are None or missing have their default; errors are those of `Escapement`.
    """
    given = {name: value for name, value in values.items() if value is not None}
    inertias = {entry.key: given.get(name) for name, entry in declared(Inertia).items()}
    numbers = {name: given[name] for name in declared(Escapement) if name in given}
    return Escapement(mechanism, Inertia(**inertias), **numbers, **trains_of(given))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Run(Declared):
    """Numbers of a run, which are not part of the escapement."""

    initial_speed: float = field(default=0.0, metadata=quantity(
        "driver speed at the first pin entry", "speed",
        remedy="give the driver speed, 0 to start from rest"
    ))  # fmt: skip
    engagements: int = field(default=20, metadata=quantity(
        "engagements to run", minimum=1, whole=True, axis=False, metavar="N",
        remedy="give the number of engagements; the figures of merit need no long motion"
    ))  # fmt: skip
    turns: float | None = field(default=None, metadata=quantity(
        "driver turns to run", exclusive=True, metavar="N",
        remedy="give how often the driver turns"
    ))  # fmt: skip
    duration: float | None = field(default=None, metadata=quantity(
        "time to run", "time", exclusive=True, axis=False, note=", instead of engagements",
        remedy="give the time to run"
    ))  # fmt: skip
