"""Choosing a slotted mechanism: charts, comparison of motions, inverse synthesis, gears."""

from escapement.synthesis.mechanism_search import Candidate as Candidate
from escapement.synthesis.mechanism_search import find_mechanisms as find_mechanisms
from escapement.synthesis.mechanism_search import motion_ratio_chart as motion_ratio_chart
from escapement.synthesis.wheel import FollowerMotion as FollowerMotion
from escapement.synthesis.wheel import GearPair as GearPair
from escapement.synthesis.wheel import MotionPeaks as MotionPeaks
from escapement.synthesis.wheel import follower_motion as follower_motion
from escapement.synthesis.wheel import gear_pairs as gear_pairs
from escapement.synthesis.wheel import motion_peaks as motion_peaks
from escapement.synthesis.wheel import planet_inertia as planet_inertia
