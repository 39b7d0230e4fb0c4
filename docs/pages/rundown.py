"""The figure of a timer whose spring runs down."""

from dataclasses import replace
from math import pi

from matplotlib.figure import Figure

import escapement as esc
from escapement.plots import plot_rundown
from pages import drawn


@drawn
def rundown() -> Figure:
    """A 30-second timer whose spring loses a fifth of its torque."""
    inertia = esc.Inertia(driver=3.389e-7, follower=5.649e-6)
    timer = esc.Escapement(esc.Geneva(4), inertia, torque=0.0113, friction=0.35)
    turns = round(30.0 / esc.terminal(timer).period) / 4
    spring_rate = 0.2 * timer.torque / (2.0 * pi * turns)
    return plot_rundown(esc.rundown(replace(timer, spring_rate=spring_rate), turns=turns))
