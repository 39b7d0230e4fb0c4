"""The data of a motion, by their names in files, in xarray and in pandas."""

from typing import TYPE_CHECKING, Any

import numpy as np

from escapement.base.units import unit_name
from escapement.base.validate import package
from escapement.dynamics.law import LOSSES

if TYPE_CHECKING:
    from xarray import Dataset

# for each dataset: its kind of unit in `escapement.base.units`, its description and its type
Columns = dict[str, tuple[str, str, str]]
SAMPLES: Columns = {
    "t": ("time", "time from the first pin entry", "<f8"),
    "theta": ("angle", "driver angle from the first dead centre", "<f8"),
    "theta_dot": ("speed", "driver velocity", "<f8"),
    "theta_ddot": ("acceleration", "driver acceleration", "<f8"),
    "phi": ("angle", "follower angle", "<f8"),
    "phi_dot": ("speed", "follower velocity", "<f8"),
    "phi_ddot": ("acceleration", "follower acceleration", "<f8"),
    "contact_moment": ("torque", "moment of the pin on the follower", "<f8"),
    "contact_force": ("force", "force between pin and slot, with a crank radius", "<f8"),
    "driver_bearing_reaction": ("force", "force that the driver's bearing carries", "<f8"),
    "follower_bearing_reaction": ("force", "force that the follower's bearing carries", "<f8"),
}
"""Columns over the times `t`; they are computed block by block."""
_HANDOFFS: Columns = {
    "handoff_times": ("time", "end of each engagement", "<f8"),
    "handoff_velocities": ("speed", "driver velocity at each handoff", "<f8"),
}
_EVENTS: Columns = {
    "time": ("time", "time of each event", "<f8"),
    "engagement": ("ratio", "number of the engagement, from 0", "<i8"),
    "theta": SAMPLES["theta"],
    "theta_dot": SAMPLES["theta_dot"],
}
_EXTREMA: Columns = {
    **_EVENTS,
    "maximum": ("ratio", "whether the driver velocity has a maximum or a minimum", "u1"),
}
_PIECES: Columns = {
    "start": ("time", "start of each piece", "<f8"),
    "engagement": ("ratio", "number of the engagement, from 0", "<i8"),
    "sign": ("ratio", "side of the slot that carries the force, 0 while locked", "<f8"),
    **{
        f"{name}_loss": ("energy", f"work lost in {name.replace('_', ' ')} over each piece", "<f8")
        for name in LOSSES
    },
}
LOST = {f"{name}_loss": row for row, name in enumerate(LOSSES)}
GROUPS = (
    ("", "", _HANDOFFS),
    ("reversals", "reversal_", _EVENTS),
    ("extrema", "extremum_", _EXTREMA),
    ("trajectory", "piece_", _PIECES),
)
"""All other datasets: the attribute of the motion that has them ("" for the motion itself), the
prefix of their names, and their columns."""
_IMPACTS: Columns = {
    **_EVENTS,
    "wall": ("ratio", "wall of the slot that is struck", "<f8"),
    "speed_before": ("speed", "driver velocity before each impact", "<f8"),
    "approach_speed": ("slip", "speed of approach", "<f8"),
    "impulse": ("impulse", "impulse of the normal force", "<f8"),
    "energy": ("energy", "energy lost in each impact", "<f8"),
}
ATTRIBUTES = "engine", "rtol", "end_time", "message"
"""Attributes of a motion as a whole, besides its status."""


def groups_of(motion: Any) -> tuple[tuple[str, str, Columns], ...]:
    """`GROUPS`, and the impacts if the motion has clearance."""
    has_impacts = motion.trajectory.impacts is not None
    return (*GROUPS, ("impacts", "impact_", _IMPACTS)) if has_impacts else GROUPS


def attributes_of(key: str, column: tuple[str, str, str], units: str) -> dict[str, Any]:
    """Unit and description of a dataset, as its attributes, in a unit system."""
    quantity, long_name, _ = column
    found: dict[str, Any] = {"units": unit_name(quantity, units), "long_name": long_name}
    if key == "maximum":
        found |= {"flag_values": np.array([0, 1], "u1"), "flag_meanings": "minimum maximum"}
    return found


def values_of(source: Any, key: str) -> Any:
    """A column of one of the `GROUPS` of a motion."""
    return source.losses[LOST[key]] if key in LOST else getattr(source, key)


def as_dataset(motion: Any) -> "Dataset":
    """A motion as an `xarray.Dataset` in SI; see `Motion.to_xarray`."""
    xarray, found = package("xarray", "to_xarray"), {}
    for owner, prefix, columns in (("samples", "", SAMPLES), *groups_of(motion)):
        source = getattr(motion, owner) if owner else motion
        scale = prefix + next(iter(columns))
        for key, column in columns.items():
            if (values := values_of(source, key)) is not None:
                values = np.asarray(values, column[2])
                found[prefix + key] = ((scale,), values, attributes_of(key, column, "SI"))
    dataset: Dataset = xarray.Dataset(found, attrs=attributes(motion))
    return dataset


def as_dataframe(motion: Any) -> Any:
    """The samples as a `pandas.DataFrame` in SI; see `Motion.to_dataframe`."""
    pandas = package("pandas", "to_dataframe")
    found = {name: getattr(motion.samples, name) for name in SAMPLES}
    columns = {name: values for name, values in found.items() if values is not None}
    frame = pandas.DataFrame(columns).set_index("t")
    units = {name: unit_name(SAMPLES[name][0], "SI") for name in columns}
    frame.attrs = attributes(motion) | {"units": units}
    return frame


def attributes(motion: Any) -> dict[str, Any]:
    """Attributes of a motion as a whole, by name."""
    return {name: getattr(motion, name) for name in ATTRIBUTES} | {"status": motion.status.label}
