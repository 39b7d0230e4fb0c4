"""Reading a motion file back as a motion."""

import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from escapement.configuration import parse_plan
from escapement.dynamics import tabulate
from escapement.errors import EscapementError, InputFileError, MissingInput
from escapement.model import Escapement, FloatArray
from escapement.motion import Events, Extrema, Motion
from escapement.status import Status
from escapement.store_motion._layout import CONTENT, SCHEMA_VERSION


def is_motion(path: str | PathLike[str]) -> bool:
    """Whether `path` is an HDF5 file that says it holds a motion."""
    import h5py

    try:
        with h5py.File(path, "r") as hdf5:
            return bool(hdf5.attrs.get("content") == CONTENT)
    except (OSError, RuntimeError):
        return False


def read_motion(path: str | PathLike[str]) -> Motion:
    """Read a motion.

    Handoffs and events are as written. Between its samples, about a hundred an
    engagement, the state is interpolated by cubics: smooth to the eye, and not
    to the tolerance of the engine.

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it holds no motion, is damaged, or was written in a layout newer
        than this version knows.
    """
    import h5py

    if not Path(path).exists():
        raise MissingInput(f"motion {path} does not exist; check its name")
    if not is_motion(path):
        raise InputFileError(
            f"motion {path} must be an HDF5 file that holds a motion, and is none; "
            "name a file that escapement run wrote"
        )
    try:
        with h5py.File(path, "r") as hdf5:
            _check_schema(path, hdf5)
            return _read(hdf5)
    except InputFileError:
        raise
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, EscapementError) as error:
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


@dataclass(frozen=True)
class SampledTrajectory:
    """A trajectory between samples; see `escapement.motion.Trajectory`.

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
        """Driver angle in the cell [rad] and speed [rad/s] at times within a piece."""
        from scipy.interpolate import CubicHermiteSpline

        end = self.start[piece + 1] if piece + 1 < self.start.size else self.t[-1]
        first, last = np.searchsorted(self.t, [self.start[piece], end])
        first = min(int(first), self.t.size - 1)  # a piece of no length ends the motion
        inside = slice(first, last + 1)
        turned = self.engagement[piece] * self.escapement.mechanism.cell_angle
        nodes, theta, speed = self.t[inside], self.theta[inside] - turned, self.theta_dot[inside]
        if nodes.size < 2:
            return np.full(t.shape, theta[0]), np.full(t.shape, speed[0])
        rate = self._acceleration(piece, theta, speed)
        return (
            CubicHermiteSpline(nodes, theta, speed)(t),
            CubicHermiteSpline(nodes, speed, rate)(t),
        )

    def _acceleration(self, piece: int, theta: FloatArray, speed: FloatArray) -> FloatArray:
        """From the equation of motion: the file's jumps where a piece ends."""
        scene, clock = self.escapement, self.escapement.time_unit
        if self.sign[piece] == 0.0:
            return np.full(theta.shape, scene.torque / scene.inertia.driver)
        numbers = (self.sign[piece], scene.inertia_ratio, scene.loss, scene.load_ratio)
        table = np.empty((4, theta.size))
        tabulate(scene.mechanism.path, theta, (speed * clock) ** 2, *numbers, table)
        return table[2] / clock**2


def _read(hdf5: Any) -> Motion:
    escapement = parse_plan(json.loads(hdf5["configuration"].asstr()[()])).escapement(0)
    columns = {name: data[()] for name, data in hdf5.items() if name != "configuration"}
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
        end_time=float(hdf5.attrs["end_time"]),
        handoff_times=columns["handoff_times"],
        handoff_velocities=columns["handoff_velocities"],
        status=Status[str(hdf5.attrs["status"]).upper()],
        message=str(hdf5.attrs["message"]),
    )


def _events(columns: dict[str, Any], kind: str) -> dict[str, Any]:
    return {
        name: columns[f"{kind}_{name}"] for name in ("engagement", "time", "theta", "theta_dot")
    }
