"""What is told of a motion and of its figures of merit."""

from typing import Any

from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.status import MESSAGES, Status
from escapement.dynamics.figure_table import FIGURES, uneven

ENGAGEMENTS = {
    "handoffs": Result(long_name="engagements of the motion"),
    "last_handoff": Result("time", "end of the last of them"),
    "last_handoff_velocity": Result("speed", "driver velocity there"),
    "handoff_times": Result("time", "end of each of them", tabled=False),
    "handoff_velocities": Result("speed", "driver velocity there", tabled=False),
}
"""What is told of the engagements of a motion."""
BEATS = Result("time", "each engagement of the cycle in turn", exists=uneven, tabled=False)


def record_of(figures: Any, escapement: Any) -> Record:
    """The figures that a design can have, and those of which it is told why it lacks them.

    figures : the `Figures` of the escapement.
    """
    values, results = {}, {}
    for name, result in (FIGURES | {"beats": BEATS}).items():
        lacking = result.exists is not None and not result.exists(escapement)
        # where there is no cycle its status says why figures are missing
        told = lacking or (result.exists is None and figures.motion is not None)
        if result.missing or not lacking:
            values[name] = getattr(figures, name)
            results[name] = result._replace(missing=result.missing * told)
    return Record(values, results)


def record_of_motion(motion: Any, figures: Any) -> tuple[Record, str]:
    """Figures and engagements of a motion, and what a reader must know of them.

    Parameters
    ----------
    motion : Motion
        From the start.
    figures : Figures
        Of the terminal cycle, which do not depend on the length of the motion.
    """
    times, speeds = motion.handoff_times, motion.handoff_velocities
    found = {
        "energy_residual": motion.ledger.residual,
        "handoffs": times.size,
        "last_handoff": times[-1] if times.size else None,
        "last_handoff_velocity": speeds[-1] if times.size else None,
        "handoff_times": times,
        "handoff_velocities": speeds,
    }
    record = record_of(figures, motion.escapement) | Record(found, ENGAGEMENTS)
    outcome = motion if motion.status is not Status.OK else figures
    reasons = record.reasons()
    if not reasons or outcome.message != MESSAGES[Status.OK]:
        reasons.insert(0, outcome.message)
    if motion.status is Status.SPENT:
        reasons.insert(1, figures.message)
    return record, "; ".join(reasons)
