"""Time-domain simulation of Geneva escapements and intermittent motion.

    import escapement as esc
    timer = esc.Escapement(
        mechanism=esc.Geneva(slots=4),
        inertia=esc.Inertia(driver=3.39e-7, follower=5.65e-6),
        friction=0.35,
        torque=0.0113,
    )
    motion = esc.simulate(timer, engagements=20)

Names are resolved on first use: importing the package compiles and loads nothing.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Escapement": "model",
    "Inertia": "model",
    "Geneva": "mechanisms",
    "GearDriven": "mechanisms",
    "EllipticalPlanetary": "mechanisms",
    "Tabulated": "mechanisms",
    "critical_friction": "painleve",
    "Motion": "motion",
    "Figures": "metrics",
    "simulate": "simulation",
    "drive_torque": "constant_speed",
    "transmission_extrema": "constant_speed",
    "reversal_study": "constant_speed",
    "greatest_speed": "constant_speed",
    "greatest_follower_inertia": "constant_speed",
    "least_load_torque": "constant_speed",
    "fewest_slots": "constant_speed",
    "measure": "measurement",
    "Encoder": "measurement",
    "Readings": "measurement",
    "read_readings": "measurement",
    "write_readings": "measurement",
    "synthetic_readings": "measurement",
    "terminal": "simulation",
    "sweep": "study.sweep",
    "read_study": "study.reader",
    "units": "",
    "plots": "",
    "sources": "",
    "synthesis": "",
}

__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'escapement' has no attribute {name!r}")
    home = _HOMES[name]
    value = (
        getattr(import_module(f"escapement.{home}"), name)
        if home
        else import_module(f"escapement.{name}")
    )
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
