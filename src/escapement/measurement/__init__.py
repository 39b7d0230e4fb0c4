"""Encoder readings against a mechanism's position function (Prikhodko 2020)."""

from escapement.measurement.comparison import Measurement as Measurement
from escapement.measurement.comparison import measure as measure
from escapement.measurement.comparison import write_errors as write_errors
from escapement.measurement.encoder import Encoder as Encoder
from escapement.measurement.encoder import SensorShare as SensorShare
from escapement.measurement.encoder import sensor_share as sensor_share
from escapement.measurement.encoder import sensor_uncertainty as sensor_uncertainty
from escapement.measurement.encoder import synthetic_readings as synthetic_readings
from escapement.measurement.fit import Fit as Fit
from escapement.measurement.fit import position as position
from escapement.measurement.fit import slope as slope
from escapement.measurement.normality import Histogram as Histogram
from escapement.measurement.normality import NormalityTest as NormalityTest
from escapement.measurement.normality import anderson_darling as anderson_darling
from escapement.measurement.normality import chi_squared as chi_squared
from escapement.measurement.normality import class_count as class_count
from escapement.measurement.normality import histogram as histogram
from escapement.measurement.normality import published_chi_squared as published_chi_squared
from escapement.measurement.normality import sturges as sturges
from escapement.measurement.periodic import Periodogram as Periodogram
from escapement.measurement.periodic import ShaftError as ShaftError
from escapement.measurement.readings import Readings as Readings
from escapement.measurement.readings import read_readings as read_readings
from escapement.measurement.readings import write_readings as write_readings
