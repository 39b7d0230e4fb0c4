"""What a study computes: the configuration file and its Python equivalent as one value."""

from escapement.configuration._file import load_plan
from escapement.configuration._from_escapement import plan_from
from escapement.configuration._parse import parse_plan
from escapement.configuration._plan import StudyPlan
from escapement.solver import Solver

__all__ = ["Solver", "StudyPlan", "load_plan", "parse_plan", "plan_from"]
