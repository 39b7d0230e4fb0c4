"""Checks of what measured and computed readings are both given."""

from typing import Any

from escapement import validate
from escapement.measurement.encoder import Encoder
from escapement.measurement.readings import FARTHEST, WITHIN
from escapement.model import is_mechanism


def check_drive(mechanism: Any, encoder: Any) -> None:
    """Refuse what is no mechanism, and what is no encoder and not None."""
    if not is_mechanism(mechanism):
        raise validate.fail("mechanism", "a mechanism", mechanism, "give for example Geneva(4)")
    if encoder is not None and not isinstance(encoder, Encoder):
        raise validate.fail("encoder", "an Encoder", encoder, "give Encoder(4096, 0.003)")


def checked_zero(name: str, angle: Any) -> float:
    """Zero of an encoder [rad]."""
    remedy = "give an angle in rad"
    value = validate.number(name, angle, remedy)
    if abs(value) > FARTHEST:
        raise validate.fail(name, WITHIN, angle, remedy)
    return value
