"""What is measured against theory: readings of encoders (Prikhodko 2020), motions and beats.

All of it ends in an `Estimate` of each number and a `Verdict` with three values (`estimate`).

Readings of encoders: read `comparison` first.

- `readings`, `loggers`, `encoder`: files of readings, what loggers do to them (coarse clocks,
  counters of few bits), errors by the data sheet, and synthetic readings
- `positions`, `comparison`: the fit of a position function, and errors with their statistics
- `findings`: what readings may show, each with its size and its words
- `finding`, `error_columns`, `normal_equations`, `noise`: the search for all of it at once
- `slot_errors`, `changes`, `backlash`: slots and pins, changes for good and single readings, and
  free play in that search
- `periodic`, `normality`: periodogram and distribution of the errors
- `verdict`: what all of them say together
- `measurement_record`: what is reported of a measurement and of a measured motion

Motions and beats: least squares with the intervals of its `Tangent` (`estimate`).

- `motion_fit`, `motion_task`: the fit of a simulated motion to a measured run-up or its beats
- `ticks`, `rounds`: beats without missed or doubled ticks, sorted by pin and slot
- `interval_fit`: least squares for intervals, whose noise is partly the jitter of instants
- `beats`, `beat_unknowns`, `part_estimates`: the fit of parts to beats, and what it says
- `beat_spectrum`: which lines of the spectrum pins and slots cause

From sound to beats: read `beat_times` first.

- `recording`, `onsets`, `rhythm`: a WAV file, the beginnings of its ticks, and their beats
- `beat_files`, `beat_times`: text files of beats, and what all of these end in
- `timekeeping`: rate, beat error, drift and stability
- `synthetic_sound`: recordings that are computed
- `beat_record`: what is reported of beats
"""

from escapement.measurement.beat_spectrum import BeatLine as BeatLine
from escapement.measurement.beat_spectrum import BeatSpectrum as BeatSpectrum
from escapement.measurement.beat_spectrum import beat_spectrum as beat_spectrum
from escapement.measurement.beat_times import BeatTimes as BeatTimes
from escapement.measurement.beat_times import read_beats as read_beats
from escapement.measurement.beat_times import write_beats as write_beats
from escapement.measurement.beats import BeatFit as BeatFit
from escapement.measurement.beats import fit_beats as fit_beats
from escapement.measurement.comparison import Measurement as Measurement
from escapement.measurement.comparison import measure as measure
from escapement.measurement.comparison import write_errors as write_errors
from escapement.measurement.encoder import Encoder as Encoder
from escapement.measurement.encoder import SensorShare as SensorShare
from escapement.measurement.encoder import sensor_share as sensor_share
from escapement.measurement.encoder import sensor_uncertainty as sensor_uncertainty
from escapement.measurement.encoder import synthetic_readings as synthetic_readings
from escapement.measurement.estimate import Estimate as Estimate
from escapement.measurement.estimate import Fit as Fit
from escapement.measurement.estimate import Verdict as Verdict
from escapement.measurement.findings import Backlash as Backlash
from escapement.measurement.findings import Change as Change
from escapement.measurement.findings import Glitch as Glitch
from escapement.measurement.findings import ShaftError as ShaftError
from escapement.measurement.findings import SlotError as SlotError
from escapement.measurement.motion_fit import MotionFit as MotionFit
from escapement.measurement.motion_fit import fit_motion as fit_motion
from escapement.measurement.motion_fit import fit_run_up as fit_run_up
from escapement.measurement.normality import Histogram as Histogram
from escapement.measurement.normality import NormalityTest as NormalityTest
from escapement.measurement.normality import anderson_darling as anderson_darling
from escapement.measurement.normality import chi_squared as chi_squared
from escapement.measurement.normality import class_count as class_count
from escapement.measurement.normality import histogram as histogram
from escapement.measurement.normality import published_chi_squared as published_chi_squared
from escapement.measurement.normality import sturges as sturges
from escapement.measurement.periodic import Periodogram as Periodogram
from escapement.measurement.positions import position as position
from escapement.measurement.positions import slope as slope
from escapement.measurement.readings import Readings as Readings
from escapement.measurement.readings import read_readings as read_readings
from escapement.measurement.readings import write_readings as write_readings
from escapement.measurement.recording import Recording as Recording
from escapement.measurement.recording import read_recording as read_recording
from escapement.measurement.rounds import Rounds as Rounds
from escapement.measurement.synthetic_sound import Resonances as Resonances
from escapement.measurement.synthetic_sound import synthetic_recording as synthetic_recording
from escapement.measurement.synthetic_sound import write_recording as write_recording
from escapement.measurement.timekeeping import Stability as Stability
from escapement.measurement.timekeeping import Timekeeping as Timekeeping
from escapement.measurement.timekeeping import timekeeping as timekeeping

Combination = Estimate
"""An angle that the beats determine although they do not determine the single errors."""
