"""Gear trains that lose power: their effect depends on the direction of the power.

The barrel delivers the torque q = T - I_b theta_ddot - nu_m theta_dot, where nu_m is the slope of
a motor's torque over its speed. Where q > 0 the driver receives eta q; where the driver drives the
barrel, the torque on it is q/eta. The train after the follower requires z = M + I_l phi_ddot. Where
z > 0 the follower supplies z/eta_l; where the train drives the follower, it receives eta_l z. With
the factors e_b = eta or 1/eta, and e_l = 1/eta_l or eta_l, each combination is an escapement
without trains, of driver inertia I_d + e_b I_b, torque e_b T, viscous drag e_b nu_m, follower
inertia I_f + e_l I_l and load e_l M: see `in_flow`. The combination that holds is the one whose q
and z have the signs that it assumes. theta_ddot is the root of one function that is continuous,
linear between the points where a sign changes, and increasing below the Painleve limit of every
combination; therefore exactly one combination holds, and theta_ddot does not jump where it changes.

Inertias and torques are referred to the driver and the follower, in natural units; those of a
`Scene` include the trains as if nothing were lost.
"""

import numpy as np

from escapement.dynamics.law import state_of_pose
from escapement.dynamics.load import load_at
from escapement.dynamics.power_flow import FLOWS, UNKNOWN, factors, weight
from escapement.dynamics.torque import drive_torque
from escapement.mechanisms.slotted import pose_at
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit, jit


@inner_jit
def is_lossy(scene):
    """Whether a train of a scene loses power."""
    # with clearance a scene holds 1/eta where a body goes back
    return scene.barrel_efficiency != 1.0 or scene.load_train_efficiency != 1.0


@inner_jit(inlined=True)
def in_flow(scene, flow):
    """The scene of one flow, by its number, as if there were no trains.

    Its unit of inertia is that of its own follower, but its unit of time that of the original
    scene: torques and moments from `dynamics` have to be multiplied by `weight`.
    """
    barrel, train = factors(flow, scene)
    unit = 1.0 / (1.0 + (train - 1.0) * scene.load_train)
    return altered(
        scene,
        "rho", unit * (scene.rho + (barrel - 1.0) * scene.barrel),
        "load", unit * train * scene.load, "bearing", unit * scene.bearing,
        "driver_drag", unit * scene.driver_drag, "follower_drag", unit * scene.follower_drag,
        "driver_viscous", unit * (scene.driver_viscous + (barrel - 1.0) * scene.motor),
        "follower_viscous", unit * scene.follower_viscous,
        "gain", unit * barrel, "flow", flow,
    )  # fmt: skip


@jit(allocates=True)
def scene_in_flow(scene, flow):
    """As `in_flow`, for Python."""
    return in_flow(scene, flow)


@inner_jit
def through_trains(g, dg, rate, torque, w, scene):
    """q and z, the torques that reach the trains, at a driver acceleration; `torque` is T."""
    load = scene.load
    if scene.flow != UNKNOWN:
        load *= weight(scene) / factors(scene.flow, scene)[1]
    torque -= scene.barrel * rate + scene.motor * np.sqrt(max(w, 0.0))
    return torque, load + scene.load_train * (g * rate + dg * w)


@inner_jit
def _misses(flow, q, z):
    """How far q and z violate the signs of a flow."""
    back, given = flow == 1.0 or flow == 3.0, flow >= 2.0
    return max(q if back else -q, z if given else -z, 0.0)


@jit
def flow_at(theta, side, w, scene):
    """The flow at a driver angle while the side s carries the force, 0 in a dwell."""
    torque, best, least, held = drive_torque(theta, w, scene), 0.0, np.inf, False
    pose = pose_at(scene.path, theta) if side != 0.0 else (0.0, 0.0, 0.0, 0.0)
    for i in range(FLOWS):
        flow = float(i)
        here = in_flow(scene, flow)
        load = load_at(theta, side, here)
        now = state_of_pose(pose, drive_torque(theta, w, here), w, side, here, 0.0, 0.0, load)
        if not now.inertia > 0.0:
            # beyond the Painleve limit of this flow it would need a force of the other sign
            continue
        missed = _misses(flow, *through_trains(now.g, now.dg, now.rate, torque, w, scene))
        # beyond the limit two may have the right signs, one of them without a force on this side
        pressed = side * now.moment > 0.0
        if missed < least or (missed == least and pressed and not held):
            best, least, held = flow, missed, pressed
    return best


@inner_jit(inlined=True)
def flowing(theta, side, w, scene):
    """The scene of the flow at a driver angle; the scene itself if its trains lose nothing."""
    return in_flow(scene, flow_at(theta, side, w, scene)) if is_lossy(scene) else scene


@inner_jit
def within_flow(g, k, rate, pull, w, scene):
    """q and z, made positive while they have the signs of the flow of a scene.

    `pull` is the torque of the drive minus that of the bearing, in this scene.
    """
    barrel = factors(scene.flow, scene)[0]
    torque = (pull + scene.bearing) * weight(scene) / barrel
    dg = k - scene.follower_drag * (g * abs(g))
    q, z = through_trains(g, dg, rate, torque, w, scene)
    back, given = scene.flow == 1.0 or scene.flow == 3.0, scene.flow >= 2.0
    return -q if back else q, -z if given else z


@inner_jit
def train_losses(g, dg, rate, torque, w, scene):
    """Work lost per driver angle in the barrel's train and in that of the load."""
    barrel, train = factors(scene.flow, scene)
    q, z = through_trains(g, dg, rate, torque, w, scene)
    return (1.0 - barrel) * q, (train - 1.0) * z * g
