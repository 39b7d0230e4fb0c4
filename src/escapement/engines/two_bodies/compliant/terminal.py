"""`terminal` of two bodies whose outlines yield where they touch."""

from __future__ import annotations

from escapement.base.spoken import as_spoken
from escapement.base.validate import fail
from escapement.dynamics.compliant_cycle import cycle_of
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines.two_bodies.compliant.simulate import March
from escapement.model.escapement import Escapement


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit of two bodies that yield; see `escapement.terminal`."""
    if escapement.follower_spring or escapement.follower_gravity:
        given = as_spoken(escapement.stiffness, "stiffness")
        rule = "0 for the cycle of a follower with a spring or a weight, which takes many swings"
        raise fail("stiffness", rule, given, "leave it out, or simulate some engagements")
    return cycle_of(March(escapement, initial_speed, rtol), base, rtol, initial_speed)
