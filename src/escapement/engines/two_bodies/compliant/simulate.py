"""`simulate` of two bodies whose outlines yield where they touch."""

from __future__ import annotations

import math

import numpy as np

from escapement.base.errors import InvalidValue
from escapement.base.spoken import as_spoken
from escapement.base.status import Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.compliant_march import CompliantMarch, simulated
from escapement.dynamics.motion import Motion
from escapement.engines.two_bodies import simulate as rigid
from escapement.engines.two_bodies.compliant import march, rows
from escapement.engines.two_bodies.compliant.law import CONTACT, MOST
from escapement.engines.two_bodies.scene import prepared
from escapement.mechanisms.features import CONVEX
from escapement.model.escapement import Escapement

FINEST = 1e-10
_ROUNDING = 2e-15
"""A smaller relative error, or one below this share of the frequency of the stiffest contact, is
lost in the rounding of penetrations."""
_DEEPEST = 0.01
"""Depth of a contact at which a motion ends, if no rounding sets a smaller one [crank radii]."""


class March(CompliantMarch):
    """The march of two bodies with outlines."""

    engine, marching = "two_bodies", march
    tabulate = staticmethod(rows.tabulate)

    def __init__(self, escapement: Escapement, speed: float, rtol: float) -> None:
        super().__init__(escapement, speed, rtol)
        scene = prepared(escapement)
        fastest = math.sqrt(self.joint.stiffness * (1.0 + 1.0 / scene.law.rho))
        self.rtol = max(rtol, FINEST, _ROUNDING * fastest)
        self.tabulated = (scene.law, scene.pairs, scene.joints, self.joint), scene.pitches
        self.state[:2] = scene.start
        # of two rounded places a third of their radii is left round
        rounds = scene.pairs[scene.pairs["kind"] == CONVEX]
        radii = rounds["rho"] + rounds["radius"]
        self.deepest = min(_DEEPEST, float(radii.min(initial=np.inf)) / 3.0)
        if self.deepest == 0.0:
            raise InvalidValue(
                "stiffness must be 0 where sharp corners of both bodies may meet, got "
                f"{as_spoken(escapement.stiffness, 'stiffness')}; round the corners of one of them"
            )
        self.marched = np.zeros(MOST, CONTACT), *self.tabulated, self.deepest

    def outcome(self, why: Ending) -> tuple[Status, str]:
        """See `CompliantMarch.outcome`."""
        engagement = int(self.before[0] + self.clock["engagement"][0])
        if why in (Ending.STANDS, Ending.UNDRIVEN):
            return rigid.outcome(self.escapement, why, self.state[0], engagement)
        driver = math.degrees(self.state[0] + engagement * self.escapement.mechanism.cell_angle)
        size = self.deepest * self.escapement.mechanism.crank_radius
        reason = {
            Ending.SINKS: f"the bodies sink into each other by {as_spoken(size, 'length')}, where "
            "the outline no longer says how they push; give a greater stiffness",
            Ending.TOO_LONG: f"{self.clock['tries'][0]} steps were used up",
        }.get(why, f"the bodies touch at more than {MOST} points")
        where = f"at a driver angle of {driver:.3f} degrees, in engagement {engagement + 1}"
        return Status.NOT_CONVERGED, f"the mechanism was followed {where}, where {reason}"


def simulate(
    escapement: Escapement, *, engagements: int | None, duration: float | None,
    initial_speed: float, rtol: float,
) -> Motion:  # fmt: skip
    """Motion of two bodies that yield; arguments are validated by `escapement.simulate`."""
    return simulated(March(escapement, initial_speed, rtol), engagements, duration, rtol)
