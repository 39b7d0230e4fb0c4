"""Time-domain simulation of Geneva escapements and intermittent motion.

    import escapement as esc
    timer = esc.Escapement(
        mechanism=esc.Geneva(slots=4),
        inertia=esc.Inertia(driver=3.39e-7, follower=5.65e-6),
        friction=0.35,
        torque=0.0113,
    )
    motion = esc.simulate(timer, engagements=20)

Names are imported on first use, so that importing the package loads and compiles nothing.
"""

__version__ = "0.1.0"

_NAMES = {
    "model": "Escapement Inertia",
    "mechanisms": "Geneva GearDriven EllipticalPlanetary Tabulated",
    "painleve": "critical_friction",
    "motion": "Motion",
    "metrics": "Figures",
    "solver": "Solver",
    "simulation": "simulate terminal",
    "constant_speed": "drive_torque transmission_extrema reversal_study greatest_speed "
    "greatest_follower_inertia least_load_torque fewest_slots",
    "study.sweep": "sweep",
    "study.result": "Study",
    "study.parse": "load_plan",
    "study.run": "run_plan",
    "study.reader": "read_study",
    "study.writer": "write_study",
    "motion_file": "read_motion write_motion",
    "measurement": "measure Encoder Readings read_readings write_readings synthetic_readings",
    "": "units plots sources synthesis",
}
"""Public names by the module that has them; those of the empty one are modules themselves."""

_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}
__all__ = sorted([*_HOMES, "__version__"])

# Type checkers and editors read these imports, Python runs the function below. The function is
# hidden from type checkers, for which it would give every unknown name a type. They know this
# constant by its name; to import `typing` takes longer than all that stands here.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from escapement import plots as plots
    from escapement import sources as sources
    from escapement import synthesis as synthesis
    from escapement import units as units
    from escapement.constant_speed import drive_torque as drive_torque
    from escapement.constant_speed import fewest_slots as fewest_slots
    from escapement.constant_speed import greatest_follower_inertia as greatest_follower_inertia
    from escapement.constant_speed import greatest_speed as greatest_speed
    from escapement.constant_speed import least_load_torque as least_load_torque
    from escapement.constant_speed import reversal_study as reversal_study
    from escapement.constant_speed import transmission_extrema as transmission_extrema
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
    from escapement.simulation import simulate as simulate
    from escapement.simulation import terminal as terminal
    from escapement.solver import Solver as Solver
    from escapement.study.parse import load_plan as load_plan
    from escapement.study.reader import read_study as read_study
    from escapement.study.result import Study as Study
    from escapement.study.run import run_plan as run_plan
    from escapement.study.sweep import sweep as sweep
    from escapement.study.writer import write_study as write_study
else:

    def __getattr__(name):
        if name not in _HOMES:
            raise AttributeError(f"module 'escapement' has no attribute {name!r}")
        from importlib import import_module

        home = _HOMES[name]
        module = import_module(f"escapement.{home or name}")
        value = getattr(module, name) if home else module
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return __all__
