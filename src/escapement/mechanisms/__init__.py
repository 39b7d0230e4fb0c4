"""Mechanisms: each gives its transmission over a cell of driver angle."""

from escapement.mechanisms.elliptical_planetary import EllipticalPlanetary
from escapement.mechanisms.gear_driven import GearDriven
from escapement.mechanisms.geneva import Geneva

__all__ = ["EllipticalPlanetary", "GearDriven", "Geneva"]
