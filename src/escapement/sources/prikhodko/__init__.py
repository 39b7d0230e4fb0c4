"""Prikhodko (2020): the planetary drive with elliptical gears, and its measurement."""

from escapement.sources.prikhodko.numbers import (
    ERRATA,
    PrintedValue,
    drive,
    pitch_curve_slip,
    position_function_error,
    synthetic_measurement,
    table,
)

__all__ = [
    "ERRATA",
    "PrintedValue",
    "drive",
    "pitch_curve_slip",
    "position_function_error",
    "synthetic_measurement",
    "table",
]
