"""Reading a motion file back as a motion."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from escapement.engines.energy.pieces import follow
from escapement.errors import EscapementError, InputFileError
from escapement.files.names import check_input
from escapement.mechanisms import KINDS
from escapement.model import Escapement, FloatArray, Mechanism
from escapement.motion import Motion
from escapement.motion_file.layout import CONTENT, SCHEMA_VERSION
from escapement.status import Status
from escapement.study.parse import parse_plan
from escapement.study.reader import DAMAGE, configuration_of
from escapement.trajectory import Events, Extrema

_DIMENSIONS = ("handoff", "reversal", "extremum", "piece")
_RTOL = 1e-12  # of states between what the file holds


def is_motion(path: str | PathLike[str]) -> bool:
    """Whether `path` is an HDF5 file that says it holds a motion."""
    import h5py

    if not Path(path).is_file():
        return False
    try:
        with h5py.File(path, "r") as hdf5:
            return bool(hdf5.attrs.get("content") == CONTENT)
    except (OSError, RuntimeError):
        return False


def read_motion(path: str | PathLike[str]) -> Motion:
    """Read a motion.

    Handoffs and events are as written. The state at any time is computed anew from
    the samples at reversals and handoffs.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it holds no motion, is damaged, was written in a layout newer than this
        version knows, or has a mechanism that is of no kind it knows.
    """
    import h5py

    check_input(path, "motion")
    if not is_motion(path):
        raise InputFileError(
            f"motion {path} must be an HDF5 file that holds a motion, and is none; "
            "name a file that escapement run wrote"
        )
    try:
        with h5py.File(path, "r") as hdf5:
            _check_schema(path, hdf5)
            _check_kind(path, hdf5)
            return _read(hdf5)
    except InputFileError:
        raise
    except (*DAMAGE, EscapementError) as error:
        reason = " ".join(str(error).split())
        raise InputFileError(
            f"motion {path} must be whole, and is damaged: {reason}; write it anew"
        ) from None


def _check_schema(path: str | PathLike[str], hdf5: Any) -> None:
    version = int(hdf5.attrs["schema_version"])
    if version > SCHEMA_VERSION:
        raise InputFileError(
            f"motion {path} must have schema_version {SCHEMA_VERSION} or less, got {version}; "
            "install a newer geneva-escapement to read it"
        )


def _check_kind(path: str | PathLike[str], hdf5: Any) -> None:
    """Refuse a mechanism of somebody's own: a file cannot build it."""
    machine = configuration_of(hdf5)["mechanism"]
    if machine["kind"] not in KINDS and "description" in machine:
        raise InputFileError(
            f"motion {path} must have a mechanism that a file can describe, got one of class "
            f"{machine['kind']}; take its numbers with h5py or xarray"
        )


@dataclass(frozen=True)
class SampledTrajectory:
    """A trajectory between samples; see `escapement.trajectory.Trajectory`.

    t, theta, theta_dot : samples, each start of a piece among them.
    """

    escapement: Escapement
    start: FloatArray
    engagement: np.ndarray
    sign: FloatArray
    friction_loss: FloatArray
    reversals: Events
    extrema: Extrema
    t: FloatArray
    theta: FloatArray
    theta_dot: FloatArray

    def state(self, piece: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece.

        From the piece's start by the equation of motion: no curve through the samples
        would follow the speed of a light driver, which peaks between two of them.
        """
        clock = self.escapement.time_unit
        since = np.maximum(np.ascontiguousarray(t) - self.start[piece], 0.0) / clock
        angle, w = self._start(piece)
        end = self.escapement.mechanism.breaks[-1]
        if not self._begins(piece + 1):
            end = self._start(piece + 1)[0]
        start = (angle, w, self.sign[piece])
        theta, squares = follow(self.escapement.scene, start, end, since, _RTOL)
        return theta, np.sqrt(squares) / clock

    def _begins(self, piece: int) -> bool:
        """Whether a piece, there or not, is the first of an engagement."""
        inside = 0 < piece < self.start.size
        return not inside or bool(self.engagement[piece] != self.engagement[piece - 1])

    def _start(self, piece: int) -> tuple[float, float]:
        """Driver angle in the cell, and squared speed in natural units, where a piece starts."""
        mechanism = self.escapement.mechanism
        # a piece of no length may end the motion
        sample = min(int(np.searchsorted(self.t, self.start[piece])), self.t.size - 1)
        angle = self.theta[sample] - self.engagement[piece] * mechanism.cell_angle
        if self._begins(piece):
            angle = mechanism.breaks[0]
        elif self.sign[piece] == 0.0:
            angle = mechanism.breaks[-1]
        return float(angle), float(self.theta_dot[sample] * self.escapement.time_unit) ** 2


def _read(hdf5: Any) -> Motion:
    escapement = parse_plan(configuration_of(hdf5)).escapement(0)
    columns = {name: data[()] for name, data in hdf5.items() if name != "configuration"}
    end = float(hdf5.attrs["end_time"])
    _check_columns(columns, end)
    _check_pieces(columns, escapement.mechanism)
    maximum = columns["extremum_maximum"].astype(bool)
    trajectory = SampledTrajectory(
        escapement=escapement,
        start=columns["piece_start"],
        engagement=columns["piece_engagement"],
        sign=columns["piece_sign"],
        friction_loss=columns["piece_friction_loss"],
        reversals=Events(**_events(columns, "reversal")),
        extrema=Extrema(**_events(columns, "extremum"), maximum=maximum),
        t=columns["t"],
        theta=columns["theta"],
        theta_dot=columns["theta_dot"],
    )
    return Motion(
        escapement=escapement,
        engine=str(hdf5.attrs["engine"]),
        rtol=float(hdf5.attrs["rtol"]),
        trajectory=trajectory,
        end_time=end,
        handoff_times=columns["handoff_times"],
        handoff_velocities=columns["handoff_velocities"],
        status=Status[str(hdf5.attrs["status"]).upper()],
        message=str(hdf5.attrs["message"]),
    )


def _events(columns: dict[str, Any], kind: str) -> dict[str, Any]:
    return {
        name: columns[f"{kind}_{name}"] for name in ("engagement", "time", "theta", "theta_dot")
    }


def _check_columns(columns: dict[str, Any], end: float) -> None:
    """Raise ValueError where the numbers cannot be those of a motion."""
    scales = {"t": "t", "theta": "t", "theta_dot": "t"}
    scales |= {name: kind for kind in _DIMENSIONS for name in columns if name.startswith(kind)}
    lengths: dict[str, int] = {}
    for name, scale in scales.items():
        values = columns[name]
        numbers = values.ndim == 1 and values.dtype.kind in "fiu"
        if not numbers or not np.isfinite(values).all():
            raise ValueError(f"{name} must be a line of finite numbers")
        if lengths.setdefault(scale, values.size) != values.size:
            raise ValueError(f"{name} must have {lengths[scale]} numbers, got {values.size}")
    if not lengths["piece"]:
        raise ValueError("piece_start must not be empty")
    t = columns["t"]
    if not lengths["t"] or not (np.diff(t) > 0.0).all() or t[0] != 0.0 or t[-1] != end:
        raise ValueError(f"t must ascend from 0 to the end_time, {end:g} s")
    for name in ("handoff_times", "reversal_time", "extremum_time", "piece_start"):
        times = columns[name]
        if (np.diff(times) < 0.0).any() or (times < 0.0).any() or (times > end).any():
            raise ValueError(f"{name} must ascend between 0 and the end_time, {end:g} s")


def _check_pieces(columns: dict[str, Any], mechanism: Mechanism) -> None:
    """Raise ValueError unless each piece starts in its cell: to follow it might never end."""
    samples = np.searchsorted(columns["t"], columns["piece_start"])
    angle = columns["theta"][samples] - columns["piece_engagement"] * mechanism.cell_angle
    slack = 1e-6 * mechanism.cell_angle
    inside = (angle > mechanism.breaks[0] - slack) & (angle < mechanism.breaks[-1] + slack)
    if not inside.all():
        raise ValueError("theta must be in its engagement's cell where a piece starts")
    speeds = columns["theta_dot"]
    # where "ivp" finds a stop, the speed is a rounding error of either sign
    if speeds.min() < -1e-6 * speeds.max():
        raise ValueError("theta_dot must be at least 0")
    if not np.isin(columns["piece_sign"], (-1, 0, 1)).all():
        raise ValueError("piece_sign must be one of -1, 0 and 1")
