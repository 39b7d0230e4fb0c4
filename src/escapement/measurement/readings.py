"""Readings of two encoders, sample by sample, with their times if known, and their files."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import validate
from escapement.base.columns import Columns, read_columns
from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.files import write_file
from escapement.base.headings import COUNTS
from escapement.base.text import Shown, csv_lines
from escapement.measurement.loggers import check_increasing, checked_times, row_of, unrolled
from escapement.mechanisms.protocol import FloatArray

TURN = 2.0 * np.pi
FARTHEST = 1e10 * TURN
"""Greatest angle; rounding of much greater ones is above a thousandth of a degree [rad]."""
WITHIN = "within 1e10 turns of zero, so that rounding stays below a thousandth of a degree"
LEAST_SAMPLES = 20
"""Of fewer samples, too few degrees of freedom would be left for tests."""
_SYNTHETIC = "# synthetic"
_BEATS = b"time [s],half_width [s],loudness\n"
_BLOCK = 1 << 17  # so many samples are worked on at once, which keeps temporary arrays small


@dataclass(frozen=True, eq=False, repr=False)
class Readings(Shown):
    """What was read in turn: angles of two encoders, or the instants of beats.

    A reading has a value and may have an instant. Of encoders the value is uncertain, an angle. Of
    beats the instant is, and the value is the number of the beat; see `of_beats`.

    Parameters
    ----------
    input, output : array_like, shape (n,)
        Angles in the order in which they were taken [rad]; NaN or masked where a
        reading is missing. If a column stays within one turn, it is taken to start again
        at zero each turn; any other is taken to count over all turns.
    line : array_like of int, shape (n,), optional
        Line of each sample in its file. Default: 1, 2, ...
    synthetic : bool
        Whether the readings were computed and not measured.
    remark : str
        A warning that becomes part of the message of each result.
    time : array_like, shape (n,), optional
        When each sample was taken, increasing [s]; neighbours of a coarse clock may be equal,
        and are then spread over its step. With times, all outputs may be NaN.
    half_widths : array_like, shape (n,), optional
        Half the width of the 95 % interval of each time [s], 0 where it is not known. With them
        these are beats.
    loudness : array_like, shape (n,), optional
        Root mean square of the sound of each beat over that of the noise before it [-].
    doubles : array_like, shape (m,)
        Instants of sounds that begin no beat [s]: further sounds of a beat, echoes and noises.
    sounds : int
        Sounds of a beat.

    Raises
    ------
    InvalidValue
        If the columns have different lengths, contain infinite angles or ones beyond 1e10
        turns, have fewer than 20 complete samples, the input does not turn, or time does not
        increase.
    """

    input: FloatArray
    output: FloatArray
    line: np.ndarray | None = None
    synthetic: bool = False
    remark: str = ""
    time: FloatArray | None = None
    half_widths: FloatArray | None = None
    loudness: FloatArray | None = None
    doubles: Sequence[float] | FloatArray = ()
    sounds: int = 1

    @classmethod
    def of_beats(cls, time: ArrayLike, half_widths: ArrayLike = 0.0, **more: Any) -> "Readings":
        """Beats in turn; the first one ends the first engagement.

        Parameters
        ----------
        time : array_like, shape (n,)
            When each begins, increasing [s]; NaN or masked where it was not heard.
        half_widths : array_like, shape (n,)
            Half the width of the 95 % interval of each time [s].
        **more :
            Other fields.
        """
        at = row_of("time", time, "give the instants of beats in s, NaN for one that is missing")
        check_increasing("time", at)
        wide = np.broadcast_to(np.asarray(half_widths, float), at.shape)
        number = np.arange(1.0, at.size + 1.0)
        more = {"loudness": np.full(at.size, np.nan)} | more
        return cls(number, np.full(at.size, np.nan), time=at, half_widths=wide, **more)

    def __post_init__(self) -> None:
        if self.half_widths is not None:
            return
        size, where = len(self.input), "sample" if self.line is None else "line"
        lines = np.arange(1, size + 1) if self.line is None else np.asarray(self.line)
        if not size == len(self.output) == len(lines):
            raise InvalidValue(
                f"input, output and line must be of one length, got {size}, {len(self.output)} "
                f"and {len(lines)}; give NaN for a missing reading"
            )
        for name in ("input", "output"):
            vars(self)[name] = _column(name, getattr(self, name), lines, where)
        vars(self)["line"] = lines
        taken = self.complete
        if self.time is not None:
            vars(self)["time"], doubt = checked_times(self.time, lines, where)
            vars(self)["remark"] = "; ".join(filter(None, (self.remark, doubt)))
            taken = np.isfinite(self.input)
        check_samples(int(np.count_nonzero(taken)), size)
        if np.ptp(self.input[taken]) == 0.0:
            raise InvalidValue(
                "input must turn, got the same angle in every sample; "
                "check which column is the input"
            )

    @cached_property
    def complete(self) -> np.ndarray:
        """Which samples have both readings, or which beats were heard: bool, shape (n,)."""
        if self.half_widths is not None:
            return np.asarray(np.isfinite(np.asarray(self.time)))
        return np.isfinite(self.input) & np.isfinite(self.output)

    @property
    def beats(self) -> np.ndarray:
        """Indices of the beats that were heard; none of readings of encoders."""
        return np.flatnonzero(self.complete & (self.half_widths is not None))

    @property
    def heard(self) -> FloatArray:
        """Their instants [s]."""
        return np.asarray(np.asarray(self.time)[self.beats])

    @property
    def period(self) -> float:
        """Mean time of a beat [s]."""
        return float(np.ptp(self.heard) / np.ptp(self.beats))

    @cached_property
    def counted_input(self) -> FloatArray:
        """Input that counts over all turns, NaN where it is missing, shape (n,) [rad].

        Neighbouring samples are assumed to be less than half a turn apart, and the first one less
        than half a turn from zero. Where inputs are missing, the median step between neighbours
        is assumed for them.
        """
        present = np.flatnonzero(np.isfinite(self.input))
        angle = self.input[present]
        if not wraps(angle):
            return self.input
        step, apart = np.diff(angle, prepend=0.0), np.diff(present, prepend=present[0])
        turns, near = -np.round(step / TURN), apart == 1
        if near.any():
            pace = np.median((step + TURN * turns)[near])
            turns = np.where(near, turns, np.round((pace * apart - step) / TURN))
        counted = np.full_like(self.input, np.nan)
        counted[present] = angle + TURN * np.cumsum(turns)
        return counted

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a user of any result must know, a sentence each."""
        synthetic = "these are synthetic data, computed and not measured" * self.synthetic
        return tuple(filter(None, (synthetic, self.remark)))

    @property
    def samples(self) -> int:
        """How many samples are complete."""
        return int(np.count_nonzero(self.complete))

    @property
    def missing(self) -> int:
        """How many samples are not."""
        return self.input.size - self.samples


def _column(name: str, values: ArrayLike, lines: np.ndarray, where: str) -> FloatArray:
    remedy = "give a row of angles in rad, NaN for a missing reading"
    angles = row_of(name, values, remedy)
    far = np.flatnonzero(np.abs(angles) > FARTHEST)
    if far.size:
        got = f"{float(angles[far[0]])!r} rad in {where} {lines[far[0]]}"
        raise InvalidValue(f"{name} must be {WITHIN}, got {got}; {remedy}")
    return angles


def check_samples(count: int, size: int) -> None:
    """Raise InvalidValue if there are too few complete samples."""
    if count < LEAST_SAMPLES:
        raise InvalidValue(
            f"readings must have at least {LEAST_SAMPLES} complete samples, got {count} of {size}; "
            "measure longer"
        )


def wraps(angle: FloatArray) -> bool:
    """Whether angles [rad] stay within a turn, as those of an absolute encoder do."""
    return bool(np.ptp(angle) <= TURN * (1.0 + 1e-9))


def blocks(count: int) -> Iterator[slice]:
    """Slices of bounded length that cover `count` samples."""
    for start in range(0, count, _BLOCK):
        yield slice(start, start + _BLOCK)


def read_readings(
    path: str | PathLike[str], *, input: str | None = None, output: str | None = None,
    time: str | None = None, angle_unit: str | None = None,
    resolution: int | tuple[int, int] | None = None, skip_rows: int = 0,
    time_unit: str | None = None,
) -> Readings:  # fmt: skip
    """Read the angles of two encoders from a CSV file.

    Parameters
    ----------
    path : path
        Text in UTF-8, UTF-16 or code page 1252, with columns separated by comma, semicolon, tab
        or blanks; lines that begin with # are comments. If commas do not separate columns, they
        may be decimal points. An empty field, NaN, NA, #N/A or - is a missing reading. Below the
        names there may be a line of units.
    input, output : str, optional
        Names of the columns in the header, with or without their unit. Default:
        those called input or driver, and output or follower; in a file without a header
        the first and the second of two columns.
    time : str, optional
        Name of the column of times; "time" stands for t or timestamp too. Default: times are
        not read. A file with times needs no output.
    angle_unit : str, optional
        "deg", "rad", "turn" or "counts". Default: the unit in a column's name, as in input_rad
        or "input (rad)", else degrees.
    resolution : int or (int, int), optional
        Counts in a turn, >= 2, for angles in counts; a pair is that of input and output. A
        register of 8, 16, 24 or 32 bits that starts again is undone.
    skip_rows : int
        How many lines to ignore at the beginning of the file.
    time_unit : str, optional
        "s", "ms", "us", "ns", "min" or "h". Default: the unit in the column's name, else s. Times
        may also be written as 19:13:03.25 or 2026-11-25T19:13:03.25.

    Returns
    -------
    Readings
        They are marked as synthetic if a comment begins with "# synthetic".

    Raises
    ------
    MissingInput
        If there is no such file.
    InputFileError
        If the file is not such a table; the message gives the line.
    InvalidValue
        If there is no column with a given name, or the unit is unknown.
    """
    pair = checked_resolution(resolution)
    validate.integer("skip_rows", skip_rows, 0, "give how many lines to skip")
    names = input, output, time
    found = read_columns(
        path, "measurement", names, angle_unit, resolution=pair, skip=skip_rows,
        time_unit=time_unit,
    )  # fmt: skip
    synthetic = any(comment.startswith(_SYNTHETIC) for comment in found.comments)
    remarks = ["the angles have no unit and are taken as degrees"] if None in found.units else []
    if found.time is not None and found.time_unit is None:
        remarks.append("the times have no unit and are taken as seconds")
    first, second = found.angles if pair is None else _unrolled(found, pair, remarks)
    try:
        return Readings(first, second, found.line, synthetic, "; ".join(remarks), found.time)
    except InvalidValue as error:
        raise InputFileError(f"{path}: {error}") from None


def checked_resolution(resolution: int | tuple[int, int] | None) -> tuple[int, int] | None:
    """Counts in a turn of input and output."""
    if resolution is None:
        return None
    pair = tuple(resolution) if isinstance(resolution, tuple | list) else (resolution,) * 2
    remedy = "give the counts in a turn, or those of input and output"
    if len(pair) != 2:
        raise validate.fail("resolution", "one number or two", resolution, remedy)
    first, second = (validate.integer("resolution", count, 2, remedy) for count in pair)
    return first, second


def _unrolled(found: Columns, pair: tuple[int, int], remarks: list[str]) -> Iterator[FloatArray]:
    """Angles with the roll-overs of their counters undone; a remark says so."""
    for name, angle, counts, unit in zip(
        ("input", "output"), found.angles, pair, (*found.units, None), strict=False
    ):
        if unit != COUNTS:
            yield angle
            continue
        better, bits, first = unrolled(angle, TURN / counts, TURN)
        if bits:
            remarks.append(
                f"the counter of the {name} has {bits} bits and starts again, first in line "
                f"{found.line[first]}, which was undone"
            )
        yield better


def write_readings(
    readings: Readings, path: str | PathLike[str], *, note: str = "", force: bool = False
) -> None:
    """Write readings as `read_readings` reads them, or the beats that were heard.

    Parameters
    ----------
    readings : Readings
        What to write; the first line says whether they are synthetic.
    path : path
        The file.
    note : str
        A comment for the beginning of the file; beats have none.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    CannotCreate, StorageError
        If the file cannot be created, or writing fails.
    """
    if readings.half_widths is not None:
        each = readings.time, readings.half_widths, readings.loudness
        columns = [np.asarray(values)[readings.beats] for values in each]
        write_file(path, [_BEATS, csv_lines(columns)], force)
        return
    angles = {"input_deg": readings.input, "output_deg": readings.output}
    write_table(path, angles, readings.synthetic, note, force)


def write_table(
    path: str | PathLike[str], columns: dict[str, FloatArray], synthetic: bool, note: str,
    force: bool,
) -> None:  # fmt: skip
    """Write columns of angles [rad] as CSV in degrees, with comments at its head."""
    label = f"{_SYNTHETIC} data: computed by escapement, not measured\n" if synthetic else ""
    comments = "".join(f"# {line}\n" for line in note.splitlines())

    def text() -> Iterator[bytes]:
        """Lines, a block of samples at a time; an empty field for what is missing."""
        yield (label + comments + ",".join(columns) + "\n").encode()
        # six decimals of a degree are ten times finer than an encoder of 26 bits
        row = ",".join(["%.6f"] * len(columns)) + "\n"
        for part in blocks(len(next(iter(columns.values())))):
            table = np.degrees([column[part] for column in columns.values()]).T + 0.0
            yield (row * len(table) % tuple(table.ravel())).replace("nan", "").encode()

    write_file(path, text(), force)
