"""`simulate` with compliant contact: integration from handoff to handoff, and its results."""

from __future__ import annotations

import math

from escapement.base.spoken import as_spoken
from escapement.base.status import Status
from escapement.dynamics.codes import Ending
from escapement.dynamics.compliant_march import CompliantMarch, simulated
from escapement.dynamics.motion import Motion, stall_message
from escapement.dynamics.torque import is_spent
from escapement.engines.contact.compliant import march, rows
from escapement.model.escapement import Escapement


class March(CompliantMarch):
    """The march of a pin in its slot."""

    engine, marching = "contact", march
    tabulate = staticmethod(rows.tabulate)

    def __init__(self, escapement: Escapement, speed: float, rtol: float) -> None:
        super().__init__(escapement, speed, rtol)
        scene = escapement.scene
        # the follower rests with the pin in the middle of its slot
        follower_angle = escapement.pairs[0].follower_angle(scene.edges[:1])[0]
        self.state[:2] = scene.edges[0], follower_angle
        self.marched = self.tabulated = scene, self.joint, escapement.mechanism.follower_step

    def outcome(self, why: Ending) -> tuple[Status, str]:
        """See `CompliantMarch.outcome`."""
        if why == Ending.TOO_LONG:
            return Status.NOT_CONVERGED, self._given_up()
        scene, engagement = self.escapement.scene, int(self.clock["engagement"][0])
        driver_angle = engagement * self.escapement.mechanism.cell_angle
        spent = is_spent(self.state[0], scene._replace(driver_angle=driver_angle))
        status = Status.SPENT if spent else Status.STALL
        return status, stall_message(self.state[0], engagement, status)

    def _given_up(self) -> str:
        """How far a motion got whose steps are used up, and a remedy that is known to help."""
        timer, clock = self.escapement, self.clock[0]
        passed, time = self.before[0] + clock["engagement"], self.before[1] + clock["time"]
        where = f"{math.degrees(self.state[0]):.3f} degrees from dead centre of engagement "
        where += f"{int(passed) + 1}, after {time * timer.time_unit:.6g} s"
        least = timer.critical_damping
        weak = timer.damping is not None and timer.damping < least and not self.joint.hertz
        remedy = (
            f"; leave out damping, and critical damping, {as_spoken(least, 'damping')}, is taken"
        )
        followed = f"the motion was followed {where}, where {clock['tries']} steps were used up"
        return followed + (remedy if weak else "")


def simulate(
    escapement: Escapement, *, engagements: int | None, duration: float | None,
    initial_speed: float, rtol: float,
) -> Motion:  # fmt: skip
    """Motion with compliant contact; arguments are validated by `escapement.simulate`."""
    return simulated(March(escapement, initial_speed, rtol), engagements, duration, rtol)
