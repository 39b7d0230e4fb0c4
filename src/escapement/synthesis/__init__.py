"""Choosing a slotted mechanism: charts, comparison of motions, inverse synthesis, gears."""

from escapement.synthesis.gears import GearPair, gear_pairs, planet_inertia
from escapement.synthesis.motion import FollowerMotion, MotionPeaks, follower_motion, motion_peaks
from escapement.synthesis.search import (
    Candidate,
    find_mechanisms,
    lobes_for,
    motion_ratio_chart,
)

__all__ = [
    "Candidate",
    "FollowerMotion",
    "GearPair",
    "MotionPeaks",
    "find_mechanisms",
    "follower_motion",
    "gear_pairs",
    "lobes_for",
    "motion_peaks",
    "motion_ratio_chart",
    "planet_inertia",
]
