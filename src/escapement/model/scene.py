"""The input of an engine: a few dimensionless numbers and a path.

The follower's inertia I_f, the driving torque tau and the time sqrt(I_f/tau) are the units of
inertia, torque and time; angles are in radians. Two escapements with equal scenes have the same
motion except for the unit of time.
"""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

from escapement.base.lazy import FloatArray, np
from escapement.mechanisms.path import Path


class Scene(NamedTuple):
    """An escapement in natural units; the equation of motion is in `dynamics.law`.

    path : transmission of the mechanism.
    edges : driver angles [rad], shape (k,), ascending, from pin entry to pin exit; the motion
        is smooth between neighbours except for pin reversals.
    dwell : driver angle after the exit in which the follower is locked [rad].
    torque : the torque of the drive, linear between knots, as `dynamics.torque` lays it out.
    driver_angle : driver angle turned before the current cell [rad].
    load_curve : load that changes with the follower's angle, over the driver angle, as
        `dynamics.load` reads it; one number where there is none.
    fall : by how much the torque of the drive falls with its speed, as `dynamics.torque` reads it;
        one number where it does not depend on the speed.
    rho : inertia ratio I_d/I_f.
    mu_plus, mu_minus : loss on the side of the slot that drives the follower, and on the
        other: a pin's coefficient of friction, or 1/eta - 1 and 1 - eta of a mesh.
    load : load torque over driving torque.
    bearing : constant torque of the driver's bearing over driving torque.
    driver_drag, follower_drag : drag that grows with the square of the speed, divided by I_f.
    driver_viscous, follower_viscous : viscous drag, over sqrt(I_f tau).
    pin : radius of the pin, or of its roller, in the path's unit of length.
    driver_journal, follower_journal : friction of the bearings over the force in the contact,
        mu_b r_b sqrt(1 + mu^2), in the path's unit of length.
    gain : factor on the torque; it is 1 except in `dynamics.train_losses`.
    flow : directions of power through lossy trains, see `dynamics.train_losses`.
    barrel, load_train : inertias of barrel and last shaft referred to driver and follower,
        divided by I_f; rho and I_f contain them.
    barrel_efficiency, load_train_efficiency : of their trains.
    motor : the part of `driver_viscous` that is the slope of a motor on a barrel whose train loses
        power; 0 elsewhere.
    pace : unit of speed over the last speed of `fall`; 0 where the torque does not depend on the
        speed.
    """

    path: Path
    edges: FloatArray
    dwell: float
    torque: FloatArray
    driver_angle: float
    load_curve: FloatArray
    fall: FloatArray
    rho: float
    mu_plus: float
    mu_minus: float
    load: float
    bearing: float
    driver_drag: float
    follower_drag: float
    driver_viscous: float
    follower_viscous: float
    pin: float
    driver_journal: float
    follower_journal: float
    gain: float
    flow: float
    barrel: float
    barrel_efficiency: float
    load_train: float
    load_train_efficiency: float
    motor: float
    pace: float


class Joint(NamedTuple):
    """The contact of pin and slot with clearance or compliance, in natural units.

    half_clearance : half the difference between slot width and pin diameter, in crank radii r.
    restitution : rebound impulse over the impulse of compression.
    stiffness : stiffness of each wall, over torque/r^2; 0 for rigid walls.
    damping : damping of each wall, over sqrt(I_f torque)/r^2.
    hertz : whether the force grows with the power 1.5 of the penetration (Hunt and Crossley).
    slip : sliding speed below which friction fades, over r/sqrt(I_f/torque).
    """

    half_clearance: float
    restitution: float
    stiffness: float
    damping: float
    hertz: bool
    slip: float


_NUMBERS = len(Scene._fields) - Scene._fields.index("rho")
DWELL, DRIVER_ANGLE, TABLE, PATH_END, EDGES_END, TORQUE_END, LOAD_END, ARRAYS = range(
    _NUMBERS, _NUMBERS + 8
)
"""Places in a packed scene behind its numbers, which come first, in the order of the fields.

The last ones are where each array ends, and where the first one, that of the path, begins.
"""


def packed(scene: Scene) -> FloatArray:
    """A scene as one array, shape (n,), from which `dynamics.law.scene_of` makes it in a kernel.

    Numba needs half a microsecond to find out the types of all fields of a tuple, a twentieth of
    a simulation, so the kernels that Python calls often take an array.
    """
    path, edges, dwell, torque, driver_angle, load_curve, fall, *numbers = scene
    arrays = path.numbers, edges, torque, load_curve, fall
    ends = [*accumulate((array.size for array in arrays[:-1]), initial=ARRAYS)][1:]
    return np.concatenate([[*numbers, dwell, driver_angle, path.table, *ends], *arrays])
