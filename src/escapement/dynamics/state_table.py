"""The law at many driver angles, for readers of a motion and for `solve_ivp`."""

from typing import Any, NamedTuple

import numpy as np

from escapement.dynamics.law import (
    contact,
    friction_ratio,
    grip,
    is_ideal,
    net_torque,
    reduced_inertia,
    root_of,
    sign_of,
    signed_loss,
    slide_at,
    wall_state,
)
from escapement.dynamics.load import load_at
from escapement.dynamics.power_flow import factors, weight
from escapement.dynamics.torque import cell_after, fall_at
from escapement.dynamics.train_losses import flowing, is_lossy, train_losses
from escapement.mechanisms.slotted import is_meshed, pose_at
from escapement.numerics.jit import inner_jit, jit

# This far ahead or behind [rad], v and g are clear of zero where they vanish at the end of a piece.
_CLEAR = 1e-9


class LawTable(NamedTuple):
    """The rows that `tabulate` fills, in natural units, with a column for each driver angle.

    ratio, ratio_slope, rate : g, g' and theta_ddot.
    moment, pressing : moment N h of the contact on the follower, and X.
    force : contact force N, in units of torque over the path's unit of length.
    friction to load_train : work lost per driver angle in each of `dynamics.law.LOSSES`.
    """

    ratio: Any
    ratio_slope: Any
    rate: Any
    moment: Any
    pressing: Any
    force: Any
    friction: Any
    driver_bearing: Any
    follower_bearing: Any
    driver_drag: Any
    follower_drag: Any
    barrel: Any
    load_train: Any


ROWS, LOST = len(LawTable._fields), LawTable._fields.index("friction")
"""Number of rows, and the first of the losses."""


@inner_jit
def signs_near(theta, inward, side, scene):
    """Signs of the sliding speed v and of g at an angle of a piece, as `law.grip` takes them.

    At the ends of a piece v or g is zero, so that rounding would decide. There `inward` is 1 at the
    start and -1 at the end; it is 0 where the signs are those at the angle itself.
    """
    if inward == 0.0 or side == 0.0 or is_meshed(scene.path) or is_ideal(scene):
        return 0.0, 0.0
    g, u, _dg, radius = pose_at(scene.path, theta + inward * _CLEAR)
    return np.sign(slide_at(g, u, radius, side, scene)), np.sign(g)


@inner_jit(inlined=True)
def cell_before(driver_angle, theta, scene):
    """The scene in the cell in which the driver has turned so far at an angle of it."""
    return cell_after(driver_angle - (theta - scene.edges[0]), scene)


class ForceAndLosses(NamedTuple):
    """Contact force N, and the work lost per driver angle in each of `dynamics.law.LOSSES`."""

    force: float
    friction: float
    driver_bearing: float
    follower_bearing: float
    driver_drag: float
    follower_drag: float
    barrel: float
    load_train: float


@inner_jit
def losses_at(
    g, u, radius, k, pull, w, side, here, slide_sign=0.0, ratio_sign=0.0, load=0.0, fall=0.0
):  # fmt: skip
    """Contact force and losses at a driver angle.

    `here` is the scene of the flow, whose pull and k these are; signs are as in
    `dynamics.law.grip`. `fall` is how much less torque the drive gives than at rest, which counts
    as drag of the driver, as that of a motor does.
    """
    unit, ratio = weight(here), sign_of(g, ratio_sign) * g
    root, speed = root_of(w, here), np.sqrt(max(w, 0.0))
    c = friction_ratio(g, u, radius, side, here, slide_sign, ratio_sign)
    force = slot = barrel = train = slope = 0.0
    if radius > 0.0:
        slide, lever = grip(g, u, radius, side, here, slide_sign, ratio_sign)
        force = contact(g, k, pull, w, root, here, load) / reduced_inertia(g, c, here) / lever
        # with the given sign of N they stay smooth if a trial step of a solver passes a reversal
        slot = signed_loss(side, here) * slide * force
    if is_lossy(here):
        rate = net_torque(g, c, k, pull, w, root, here, load) / reduced_inertia(g, c, here)
        dg = k - here.follower_drag * (g * ratio)
        torque = (pull + here.bearing) * unit / factors(here.flow, here)[0]
        barrel, train = train_losses(g, dg, rate, torque, w, here)
        # of a motor's slope the scene of a flow has what reaches the driver
        slope = (1.0 - factors(here.flow, here)[0]) * here.motor
    air = here.follower_drag * w * ratio + here.follower_viscous * speed
    return ForceAndLosses(
        force=unit * force,
        friction=unit * slot,
        driver_bearing=unit * (side * here.driver_journal * force + here.bearing),
        follower_bearing=unit * (side * here.follower_journal * ratio * force),
        driver_drag=unit * (here.driver_drag * w + here.driver_viscous * speed)
        + (slope * speed + fall),
        follower_drag=unit * (g * g * air),
        barrel=barrel,
        load_train=train,
    )


@jit
def tabulate(scene, theta, inward, driver_angle, w, side, out):
    """Fill the rows of a `LawTable` at each angle.

    `inward` is as of `signs_near`, `driver_angle` are the driver angles turned since the start of
    the motion; `side` is 0 in a dwell.
    """
    for i in range(theta.size):
        here = flowing(theta[i], side, w[i], cell_before(driver_angle[i], theta[i], scene))
        signs = signs_near(theta[i], inward[i], side, here)
        now = wall_state(theta[i], w[i], side, here, *signs)
        path = now.g, now.u, now.radius, now.k, now.pull
        load, fall = load_at(theta[i], side, here), fall_at(theta[i], w[i], here)
        lost = losses_at(*path, w[i], side, here, *signs, load, fall)
        out[0, i], out[1, i], out[2, i] = now.g, now.dg, now.rate
        out[3, i], out[4, i] = weight(here) * now.moment / now.inertia, now.moment
        for j in range(ROWS - LOST + 1):
            out[LOST - 1 + j, i] = lost[j]
