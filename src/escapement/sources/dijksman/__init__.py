"""Dijksman (1974): gear-driven Geneva wheels, figures 6 to 9 and the design charts."""

from escapement.sources.dijksman.captions import COLUMNS, Proportion, proportions
from escapement.sources.dijksman.slips import equations, start_ratios

__all__ = ["COLUMNS", "Proportion", "equations", "proportions", "start_ratios"]
