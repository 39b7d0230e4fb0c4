"""What the package offers: read by type checkers and editors, and by `__init__.py` itself."""

from escapement import plots as plots
from escapement import sources as sources
from escapement import synthesis as synthesis
from escapement import units as units
from escapement.blows import contact_summary as contact_summary
from escapement.blows import jams as jams
from escapement.constant_speed import drive_torque as drive_torque
from escapement.constant_speed import fewest_slots as fewest_slots
from escapement.constant_speed import greatest_follower_inertia as greatest_follower_inertia
from escapement.constant_speed import greatest_speed as greatest_speed
from escapement.constant_speed import least_load_torque as least_load_torque
from escapement.constant_speed import reversal_study as reversal_study
from escapement.constant_speed import transmission_extrema as transmission_extrema
from escapement.jam_rule import jam_rule as jam_rule
from escapement.measurement import Encoder as Encoder
from escapement.measurement import Readings as Readings
from escapement.measurement import measure as measure
from escapement.measurement import read_readings as read_readings
from escapement.measurement import synthetic_readings as synthetic_readings
from escapement.measurement import write_readings as write_readings
from escapement.mechanisms import EllipticalPlanetary as EllipticalPlanetary
from escapement.mechanisms import GearDriven as GearDriven
from escapement.mechanisms import Geneva as Geneva
from escapement.mechanisms import Tabulated as Tabulated
from escapement.metrics import Figures as Figures
from escapement.model import Escapement as Escapement
from escapement.model import Inertia as Inertia
from escapement.motion import Motion as Motion
from escapement.motion_file import read_motion as read_motion
from escapement.motion_file import write_motion as write_motion
from escapement.painleve import critical_friction as critical_friction
from escapement.run_down import Rundown as Rundown
from escapement.run_down import rundown as rundown
from escapement.simulation import simulate as simulate
from escapement.simulation import terminal as terminal
from escapement.solver import Solver as Solver
from escapement.stiffness import contact_stiffness as contact_stiffness
from escapement.study.parse import load_plan as load_plan
from escapement.study.reader import read_study as read_study
from escapement.study.result import Study as Study
from escapement.study.run import run_plan as run_plan
from escapement.study.run import sweep as sweep
from escapement.study.writer import write_study as write_study
from escapement.torque_curve import TorqueCurve as TorqueCurve

__version__: str
