"""Mechanisms: each gives its transmission over a cell of driver angle."""

from escapement.mechanisms.elliptical_planetary import EllipticalPlanetary
from escapement.mechanisms.gear_driven import GearDriven
from escapement.mechanisms.geneva import Geneva
from escapement.mechanisms.tabulated import Tabulated

__all__ = ["EllipticalPlanetary", "GearDriven", "Geneva", "Tabulated"]
