"""Studies over grids and samples of parameters: every case solved, into memory or into a file."""

from escapement.sweeping._run import Tally, frame_of, run_plan, write_plan
from escapement.sweeping._sweep import sweep

__all__ = ["Tally", "frame_of", "run_plan", "sweep", "write_plan"]
