"""A drive with a cam that does what an indexing drive does, to be compared with it."""

import math

from escapement.base import validate
from escapement.constant_speed.indexing import IndexingDrive
from escapement.mechanisms.cam_indexer import LAWS, CamIndexer

_SAME = (
    *("speed", "load_torque", "follower_inertia", "efficiency", "driver_bearing_torque"),
    *("driver_drag", "follower_drag", "driver_viscous", "follower_viscous"),
    *("load_curve", "load_frequency", "load_damping", "load_tolerance"),
)
"""Numbers that both drives have; a cam has no pin, and no friction in a slot."""


def cam_drive(drive: IndexingDrive, law: str) -> IndexingDrive:
    """A drive with a cam that turns the same load by the same step in the same driver angle.

    Parameters
    ----------
    drive : IndexingDrive
        With one index in a turn of its driver.
    law : str
        Law of motion of the cam, one of `CamIndexer`'s.

    Raises
    ------
    InvalidValue
        For an unknown law, or a drive with several indexes in a turn.

    Losses of the cam are given by the efficiency of the drive alone.
    """
    validate.choice("law", law, tuple(LAWS))
    mechanism = drive.mechanism
    if not math.isclose(mechanism.cell_angle, 2.0 * math.pi):
        turns = 2.0 * math.pi / mechanism.cell_angle
        rule = "one in a turn of the driver, to be compared with a cam"
        raise validate.fail("indexes", rule, round(turns, 6), "give one pin, or one lobe")
    stations = round(2.0 * math.pi / abs(mechanism.follower_step))
    angle = min(mechanism.breaks[-1] - mechanism.breaks[0], 2.0 * math.pi)
    numbers = {name: getattr(drive, name) for name in _SAME}
    return IndexingDrive(CamIndexer(stations, angle, law), friction=0.0, **numbers)
