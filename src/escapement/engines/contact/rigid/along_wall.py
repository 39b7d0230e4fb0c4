"""The way of the pin along a wall, from panel to panel."""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.dynamics.law import wall_state
from escapement.dynamics.power_flow import UNKNOWN
from escapement.engines.contact.rigid.panel import SMALLEST, flow_behind, width_after
from escapement.engines.contact.rigid.walls import next_break, wall_scene
from escapement.numerics.jit import inner_jit


class Way(NamedTuple):
    """The pin on its way along a wall.

    side : the wall. sense : 1, or -1 where the driver turns back.
    theta, w, time : driver angle, squared speed, 0 for a driver at rest for good, and time.
    width : of the panel to try next, inf where none is known.
    flow : flow of power in trains, `UNKNOWN` behind a break.
    """

    side: float
    sense: float
    theta: float
    w: float
    time: float
    width: float
    flow: float


@inner_jit
def set_off(walls, side, theta, speed, time):
    """The start of the way along a wall.

    A driver at rest that the drive can move has turned by the smallest angle of a panel, over which
    its acceleration is taken as constant.
    """
    sense, w = 1.0 if speed >= 0.0 else -1.0, speed * speed
    if w == 0.0:
        rate = wall_state(theta, 0.0, side, wall_scene(walls, side, theta, 1.0, 0.0, UNKNOWN)).rate
        if rate > 0.0:
            w, theta = 2.0 * rate * SMALLEST, theta + SMALLEST
            time += np.sqrt(w) / rate
    return Way(side=side, sense=sense, theta=theta, w=w, time=time, width=np.inf, flow=UNKNOWN)


@inner_jit(inlined=True)
def ahead(walls, way):
    """The scene of the next panel of a way, and the driver angle that it may reach."""
    scene = wall_scene(walls, way.side, way.theta, way.sense, way.w, way.flow)
    return scene, next_break(walls, way.side, way.theta, way.sense, scene)


@inner_jit(inlined=True)
def behind(way, scene, limit, found, tail):
    """The way behind a panel that was `found` with a scene up to a limit."""
    whole = found.ending == Ending.TOUCHES and found.width == limit - way.theta
    return Way(
        side=way.side, sense=way.sense, theta=limit if whole else way.theta + found.width,
        w=found.w, time=way.time + found.time, width=width_after(found, tail),
        flow=flow_behind(found, scene.flow, whole),
    )  # fmt: skip
