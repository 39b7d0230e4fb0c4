"""`terminal` with compliant contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from escapement.base.status import MESSAGES, Status
from escapement.dynamics.compliant_cycle import cycle_of
from escapement.dynamics.figures_of_merit import Figures
from escapement.dynamics.impacts import jams
from escapement.dynamics.law import is_lossless
from escapement.dynamics.motion import Motion
from escapement.dynamics.painleve import friction_limits
from escapement.dynamics.train_losses import is_lossy
from escapement.engines.contact.compliant.simulate import March
from escapement.model.escapement import Escapement
from escapement.numerics.jit import as_python


def terminal(
    escapement: Escapement, base: Figures, *, initial_speed: float, rtol: float
) -> Figures:
    """Figures of merit with compliant contact; see `escapement.terminal`."""
    march = March(escapement, initial_speed, rtol)
    # between walls that yield a body may turn back, and then any train with an efficiency loses
    scene, joint = escapement.scene, march.joint
    lossless = is_lossless(scene) and scene.dwell == 0.0 and not as_python(is_lossy)(scene)
    if lossless and joint.damping == 0.0 and not joint.hertz:
        status = Status.NO_TERMINAL
        return replace(base, status=status, message=MESSAGES[status])
    return cycle_of(march, base, rtol, initial_speed, _jam_note)


def _jam_note(motion: Motion) -> str:
    """Where, and for how long, an engagement beyond the Painleve limit jams; "" below it."""
    escapement, limit = motion.escapement, friction_limits(motion.escapement)[0]
    if escapement.friction < limit:
        return ""
    above = f"friction {escapement.friction:g} is above the Painleve limit {limit:.6g}"
    found = jams(motion)
    angles = [f"{angle:.2f}" for angle in np.degrees(found.angle)]
    if not angles:
        return f"{above}, but it does not jam"
    return (
        f"{above}: the mechanism jams {', '.join(angles)} degrees from dead centre for "
        f"{found.duration.sum():.2g} s in all"
    )
