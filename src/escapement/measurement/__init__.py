"""Encoder readings against a mechanism's position function (Prikhodko 2020)."""

from escapement.measurement._csv import read_readings
from escapement.measurement._fit import Fit
from escapement.measurement._position import position, slope
from escapement.measurement._result import Measurement
from escapement.measurement._write import write_errors, write_readings
from escapement.measurement.classes import Histogram, class_count, histogram, sturges
from escapement.measurement.comparison import measure
from escapement.measurement.encoder import (
    Encoder,
    SensorShare,
    sensor_share,
    sensor_uncertainty,
)
from escapement.measurement.normality import (
    NormalityTest,
    anderson_darling,
    chi_squared,
    published_chi_squared,
)
from escapement.measurement.readings import Readings
from escapement.measurement.shafts import ShaftError
from escapement.measurement.spectrum import Periodogram
from escapement.measurement.synthetic import synthetic_readings

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
