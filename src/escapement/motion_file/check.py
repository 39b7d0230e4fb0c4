"""What must hold in a motion file, or following its motion would fail or never end."""

from typing import Any

import numpy as np

from escapement.model import Mechanism

_DIMENSIONS = ("handoff", "reversal", "extremum", "piece")


def check_columns(columns: dict[str, Any], end: float) -> None:
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


def check_pieces(columns: dict[str, Any], mechanism: Mechanism) -> None:
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
