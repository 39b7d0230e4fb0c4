"""A pin in a slot whose clearance is drawn wide enough to be seen."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from escapement.dynamics.motion import State
from escapement.mechanisms import Geneva
from escapement.mechanisms.protocol import FloatArray
from escapement.outlines.geneva import GenevaOutline
from escapement.plots import drawing, style
from escapement.plots.geneva import draw_bodies

_VISIBLE = 0.3
"""Clearance on each side that is well seen, over the radius of the pin [-]."""
_AROUND = 4.0
"""Half the width of a close-up, over the radius of the pin [-]."""


class Exaggerated(NamedTuple):
    """A wheel whose clearance is drawn `factor` times as wide.

    phi : angles of its follower [rad], at which the pins stand between its walls as they do.
    pins : where the pin in a slot stands, complex, in crank radii; NaN in a dwell.
    touched : the wall that it touches: "front wall", "rear wall", or "flight" for none.
    """

    outline: GenevaOutline
    factor: float
    phi: FloatArray
    pins: np.ndarray
    touched: list[str]


def exaggerated(wheel: Geneva, state: State) -> Exaggerated:
    """The wheel of a motion with clearance, with clearance that is seen.

    Parameters
    ----------
    wheel : Geneva
        A wheel without errors of its parts.
    state : State
        State of the motion at the times that are drawn.
    """
    unit = wheel.crank_radius or 1.0
    # pins without a width are drawn with one
    width = GenevaOutline(wheel).pin_radius
    drawn = wheel if wheel.contact_radius else replace(wheel, pin_radius=width * unit)
    half_clearance = 0.5 * wheel.clearance / unit
    factor = max(1.0, style.round_below(_VISIBLE * width / half_clearance))
    cell, entry, leaving = wheel.cell_angle, float(wheel.breaks[0]), float(wheel.breaks[-1])
    engagement = np.floor((state.theta - entry) / cell + 1e-12)
    angle, phi = state.theta - engagement * cell, state.phi - engagement * wheel.follower_step
    side = 1.0 if wheel.internal else -1.0
    pin = wheel.centre_distance + side * np.exp(1j * side * angle)
    distance = np.abs(pin)
    across = factor * (pin * np.exp(-1j * phi)).imag
    pin_angle = np.angle(pin) - np.arcsin(np.clip(across / distance, -1.0, 1.0))
    inside = angle <= leaving
    shown = np.where(inside, pin_angle, phi) + engagement * wheel.follower_step
    force = np.sign(state.contact_moment)
    names = {1.0: "front wall", -1.0: "rear wall", 0.0: "flight"}
    touched = [
        names[float(sign)] if held else "dwell" for sign, held in zip(force, inside, strict=True)
    ]
    wide = replace(drawn, clearance=factor * wheel.clearance)
    return Exaggerated(GenevaOutline(wide), factor, shown, np.where(inside, pin, np.nan), touched)


def draw_close_up(ax: Axes, scene: Exaggerated, theta: float, frame: int) -> None:
    """The pin between its walls at one of the times; nothing in a dwell."""
    middle, half = complex(scene.pins[frame]), _AROUND * scene.outline.pin_radius
    box = middle.real - half, middle.real + half, middle.imag - half, middle.imag + half
    if not np.isnan(middle):
        drawing.dress_scene(ax, box)
        draw_bodies(ax, scene.outline, theta, float(scene.phi[frame]))
    ax.set_axis_off()
    text = f"clearance {scene.factor:g} times wider\n{scene.touched[frame]}"
    ax.set_title(text, fontsize=style.SMALL_SIZE, y=1.0)
