"""What is measured against theory: readings of encoders (Prikhodko 2020), motions and beats.

All of it ends in an `Estimate` of each number and a `Verdict` with three values (`estimate`).

Readings of encoders: read `comparison` first.

- `readings`, `loggers`, `encoder`: readings, of beats too, and their files, what loggers do to them
  (coarse clocks, counters of few bits), errors by the data sheet, and synthetic readings
- `positions`, `comparison`: the fit of a position function, and errors with their statistics
- `findings`: what readings may show, each with its size and its words
- `finding`, `error_columns`, `normal_equations`, `noise`: the search for all of it at once
- `periodic`, `normality`: periodogram and distribution of the errors
- `verdict`: what all of them say together

Motions and beats: each is a residual function of one `Fit`, with intervals from its `Tangent`.

- `motion_task`, `motion_fit`: a simulated motion, near angles at given times or times of beats
- `rounds`: beats sorted by pin and slot, their means and their spectrum
- `beat_unknowns`, `part_estimates`, `beats`: parts near mean beats, and what is known of each

From sound to beats: read `beat_times` first.

- `recording`, `onsets`, `rhythm`: a WAV file, the beginnings of its ticks, and their beats without
  missed or doubled ones
- `beat_times`: these, and text files of beats, as `Readings`
- `timekeeping`: rate, beat error, drift and stability

`measurement_record` has all that is reported.
"""

from escapement.measurement.beat_times import read_beats
from escapement.measurement.beats import BeatFit, fit_beats
from escapement.measurement.comparison import Measurement, measure, write_errors
from escapement.measurement.encoder import (
    Encoder,
    SensorShare,
    sensor_share,
    sensor_uncertainty,
    synthetic_readings,
)
from escapement.measurement.estimate import Estimate, Fit, Verdict
from escapement.measurement.findings import Backlash, Change, Glitch, ShaftError, SlotError
from escapement.measurement.motion_fit import MotionFit, fit_motion
from escapement.measurement.normality import (
    Histogram,
    NormalityTest,
    anderson_darling,
    class_count,
    histogram,
    published_chi_squared,
    sturges,
)
from escapement.measurement.periodic import Periodogram
from escapement.measurement.positions import position, slope
from escapement.measurement.readings import Readings, read_readings, write_readings
from escapement.measurement.recording import (
    Recording,
    read_recording,
    synthetic_recording,
    write_recording,
)
from escapement.measurement.rounds import BeatLine, BeatSpectrum, Rounds, beat_spectrum
from escapement.measurement.timekeeping import Stability, Timekeeping, timekeeping

__all__ = [
    "Backlash", "BeatFit", "BeatLine", "BeatSpectrum", "Change", "Encoder",
    "Estimate", "Fit", "Glitch", "Histogram", "Measurement", "MotionFit",
    "NormalityTest", "Periodogram", "Readings", "Recording", "Rounds", "SensorShare",
    "ShaftError", "SlotError", "Stability", "Timekeeping", "Verdict", "anderson_darling",
    "beat_spectrum", "class_count", "fit_beats", "fit_motion",
    "histogram", "measure", "position", "published_chi_squared", "read_beats", "read_readings",
    "read_recording", "sensor_share", "sensor_uncertainty", "slope", "sturges",
    "synthetic_readings", "synthetic_recording", "timekeeping", "write_errors",
    "write_readings", "write_recording",
]  # fmt: skip
