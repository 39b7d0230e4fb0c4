"""Encoder readings against a mechanism's position function (Prikhodko 2020)."""

from escapement.measurement.comparison import Measurement, measure, write_errors
from escapement.measurement.encoder import (
    Encoder,
    SensorShare,
    sensor_share,
    sensor_uncertainty,
    synthetic_readings,
)
from escapement.measurement.fit import Fit, position, slope
from escapement.measurement.normality import (
    Histogram,
    NormalityTest,
    anderson_darling,
    chi_squared,
    class_count,
    histogram,
    published_chi_squared,
    sturges,
)
from escapement.measurement.readings import Readings, read_readings, write_readings
from escapement.measurement.shafts import ShaftError
from escapement.measurement.spectrum import Periodogram

__all__ = [
    "Encoder",
    "Fit",
    "Histogram",
    "Measurement",
    "NormalityTest",
    "Periodogram",
    "Readings",
    "SensorShare",
    "ShaftError",
    "anderson_darling",
    "chi_squared",
    "class_count",
    "histogram",
    "measure",
    "position",
    "published_chi_squared",
    "read_readings",
    "sensor_share",
    "sensor_uncertainty",
    "slope",
    "sturges",
    "synthetic_readings",
    "write_errors",
    "write_readings",
]
