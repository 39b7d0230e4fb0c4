"""The figures of play between pin and slot."""

from dataclasses import replace

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.figure import Figure

import escapement as esc
from pages import FIGURES, LINES, drawn, panels, timer

RADIUS = 0.01
PLAYS = np.geomspace(1e-5, 1e-3, 9)
"""Half the clearance over the crank radius."""


def loose(friction: float, play: float, **more: float) -> esc.Escapement:
    """Meyer's four slots with play."""
    own = timer(4, friction, 0.10)
    wheel = esc.Geneva(4, crank_radius=RADIUS, clearance=2.0 * play * RADIUS)
    return replace(own, mechanism=wheel, **more)


def yielding(play: float, stiffness: float, share: float = 1.0) -> esc.Escapement:
    """The same with compliant contact; stiffness in units of torque over r squared."""
    own = timer(4, 0.30, 0.10)
    unit = own.torque / RADIUS**2
    damping = share * stiffness**0.5 * unit * own.time_unit
    return loose(0.30, play, stiffness=stiffness * unit, damping=damping)


@drawn
def clearance_period() -> Figure:
    """Period against clearance, and energy lost in impacts against friction."""
    figure, (left, right) = panels(2, 2.9)
    for friction, (colour, style) in zip((0.20, 0.30, 0.38), LINES, strict=False):
        ideal = esc.terminal(loose(friction, 0.0)).period
        change = [esc.terminal(loose(friction, x)).period / ideal - 1.0 for x in PLAYS]
        left.loglog(2.0 * PLAYS, 100.0 * np.array(change), color=colour, ls=style,
                    label=f"µ = {friction:.2f}")  # fmt: skip
    left.set(xlabel="Clearance over crank radius", ylabel="Increase of the period (%)")
    left.legend(frameon=False)
    frictions = np.linspace(0.02, 0.40, 20)
    for play, (colour, style) in zip((1e-3, 1e-4, 1e-5), LINES, strict=False):
        shares = []
        for friction in frictions:
            ledger = esc.terminal(loose(friction, play)).motion.ledger
            shares.append(100.0 * ledger.blows / ledger.work)
        clearance = f"{2.0 * play:f}".rstrip("0")
        right.plot(frictions, shares, color=colour, ls=style, label=f"{clearance} r")
    right.set(xlabel="Friction µ", ylabel="Work lost in impacts (%)")
    right.legend(frameon=False, title="Clearance")
    return figure


@drawn
def clearance_force() -> Figure:
    """Contact force and velocities over an engagement with its two impacts."""
    figure, (left, right) = panels(2, 2.9)
    own = yielding(5e-4, 1e6)
    cycle = esc.terminal(own)
    motion = esc.simulate(own, 2, initial_speed=cycle.handoff_velocity)
    start = float(motion.handoff_times[0])
    t = np.linspace(0.0, float(motion.end_time) - start, 40_001)
    state = motion.at(start + t)
    signed = np.where(np.sign(state.contact_moment) < 0.0, -1.0, 1.0) * np.abs(state.contact_force)
    left.plot(1e3 * t, signed, color=LINES[0][0], lw=1.0)
    left.set_yscale("symlog", linthresh=0.1)
    left.set(xlabel="Time (ms)", ylabel="Contact force (N)")
    right.plot(1e3 * t, state.theta_dot, color=LINES[0][0], label="driver")
    right.plot(1e3 * t, state.phi_dot, color=LINES[1][0], ls=LINES[1][1], label="follower")
    right.set(xlabel="Time (ms)", ylabel="Velocity (rad/s)")
    right.legend(frameon=False)
    return figure


@drawn
def contact_convergence() -> Figure:
    """Period as the clearance falls to zero, and as the walls become rigid."""
    figure, (left, right) = panels(2, 2.9)
    ideal = esc.terminal(loose(0.30, 0.0)).period
    errors = [esc.terminal(loose(0.30, x)).period / ideal - 1.0 for x in PLAYS]
    left.loglog(2.0 * PLAYS, errors, "o", color=LINES[0][0], mfc="none", label="computed")
    left.loglog(2.0 * PLAYS, errors[0] * PLAYS / PLAYS[0], color="0.4", ls=":", label="order 1")
    left.set(xlabel="Clearance over crank radius", ylabel="Relative increase of the period")
    left.legend(frameon=False)
    stiff = np.geomspace(1e5, 1e7, 5)
    off = [abs(esc.terminal(yielding(0.0, k, 0.3)).period / ideal - 1.0) for k in stiff]
    right.loglog(stiff, off, "o", color=LINES[0][0], mfc="none", label="computed")
    order = off[-1] * (stiff / stiff[-1]) ** -0.5
    right.loglog(stiff, order, color="0.4", ls=":", label="order 1/2")
    right.set(xlabel="Stiffness (τ/r²)", ylabel="Relative difference of the period")
    right.legend(frameon=False)
    return figure


def clearance_film() -> FuncAnimation:
    """Film of a pin that leaves the front wall, flies, and strikes the rear one."""
    wheel = esc.Geneva(4, crank_radius=RADIUS, pin_radius=0.08 * RADIUS, clearance=2e-3 * RADIUS)
    motion = esc.terminal(replace(timer(4, 0.30, 0.10), mechanism=wheel)).motion
    lifts, strikes = motion.reversals.time[0], motion.impacts.time[-1]
    aside = 0.5 * (strikes - lifts)
    return esc.plots.animate(motion, lifts - aside, strikes + aside, frames=20, rate=5.0)


FIGURES["clearance_film.gif"] = clearance_film
