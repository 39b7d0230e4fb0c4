"""The law at many driver angles, for readers of a motion and for `solve_ivp`."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.law import (
    contact,
    dragged_slope,
    friction_ratio,
    is_ideal,
    losses_per_angle,
    net_torque,
    reduced_inertia,
    root_of,
    sign_of,
    slide_at,
)
from escapement.dynamics.torque import cell_after, torque_at
from escapement.dynamics.train_losses import factors, flowing, is_lossy, train_losses, weight
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.jit import inner_jit, jit

# This far ahead or behind [rad], v and g are clear of zero where they vanish at the end of a piece.
_CLEAR = 1e-9


@inner_jit
def _pose(theta, side, scene):
    """g, u, g' and R at a driver angle, 0 in a dwell."""
    return pose_at(scene.path, theta) if side != 0.0 else (0.0, 0.0, 0.0, 0.0)


@inner_jit
def signs_near(theta, inward, side, scene):
    """Signs of the sliding speed v and of g at an angle of a piece, as `law.grip` takes them.

    At the ends of a piece v or g is zero, so that rounding would decide. There `inward` is 1 at the
    start and -1 at the end; it is 0 where the signs are those at the angle itself.
    """
    if inward == 0.0 or side == 0.0 or scene.path.table or is_ideal(scene):
        return 0.0, 0.0
    g, u, _dg, radius = pose_at(scene.path, theta + inward * _CLEAR)
    return np.sign(slide_at(g, u, radius, side, scene)), np.sign(g)


@jit
def tabulate(scene, theta, inward, driver_angle, w, side, out):
    """Fill out[0:5] with g, g', theta_ddot, contact moment N h and X at each angle.

    `inward` is as of `signs_near`, `driver_angle` are the driver angles turned since the start of
    the motion; `side` is 0 in a dwell.
    """
    for i in range(theta.size):
        here = flowing(theta[i], side, w[i], cell_before(driver_angle[i], theta[i], scene))
        g, u, dg, radius = _pose(theta[i], side, scene)
        slide_sign, ratio_sign = signs_near(theta[i], inward[i], side, here)
        c, k = (
            friction_ratio(g, u, radius, side, here, slide_sign, ratio_sign),
            dragged_slope(g, dg, here, ratio_sign),
        )
        pull = torque_at(theta[i], here)[0] - here.bearing
        root, inertia = root_of(w[i], here), reduced_inertia(g, c, here)
        out[0, i], out[1, i] = g, dg
        out[2, i] = net_torque(g, c, k, pull, w[i], root, here) / inertia
        # in a dwell nothing touches
        out[4, i] = contact(g, k, pull, w[i], root, here) if side != 0.0 else 0.0
        out[3, i] = weight(here) * out[4, i] / inertia


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
def losses_at(g, u, radius, k, pull, w, side, here, slide_sign=0.0, ratio_sign=0.0):
    """Contact force and losses at a driver angle.

    `here` is the scene of the flow, whose pull and k these are; signs are as in
    `dynamics.law.grip`.
    """
    unit, barrel, train = weight(here), 0.0, 0.0
    force, friction, at_driver, at_follower, drag, air = losses_per_angle(
        g, u, radius, k, pull, w, side, here, slide_sign, ratio_sign
    )
    if is_lossy(here):
        c = friction_ratio(g, u, radius, side, here, slide_sign, ratio_sign)
        rate = net_torque(g, c, k, pull, w, root_of(w, here), here) / reduced_inertia(g, c, here)
        dg = k - here.follower_drag * (g * sign_of(g, ratio_sign) * g)
        torque = (pull + here.bearing) * unit / factors(here.flow, here)[0]
        barrel, train = train_losses(g, dg, rate, torque, w, here)
    return ForceAndLosses(
        force=unit * force,
        friction=unit * friction,
        driver_bearing=unit * at_driver,
        follower_bearing=unit * at_follower,
        driver_drag=unit * drag,
        follower_drag=unit * air,
        barrel=barrel,
        load_train=train,
    )


@jit
def tabulate_losses(scene, theta, inward, driver_angle, w, side, out):
    """Fill out[0] with the contact force N and out[1:] with each of `law.LOSSES` per driver angle.

    `inward` is as of `signs_near`; `side` is 0 in a dwell. The force is in units of torque over the
    path's unit of length.
    """
    for i in range(theta.size):
        here = flowing(theta[i], side, w[i], cell_before(driver_angle[i], theta[i], scene))
        g, u, dg, radius = _pose(theta[i], side, scene)
        slide_sign, ratio_sign = signs_near(theta[i], inward[i], side, here)
        k, pull = (
            dragged_slope(g, dg, here, ratio_sign),
            torque_at(theta[i], here)[0] - here.bearing,
        )
        row = losses_at(g, u, radius, k, pull, w[i], side, here, slide_sign, ratio_sign)
        for j in range(out.shape[0]):
            out[j, i] = row[j]
