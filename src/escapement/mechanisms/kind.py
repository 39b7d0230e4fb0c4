"""What every kind of mechanism tells files, the command line and reports of itself."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from escapement.quantity import Declared, Setting, declared
from escapement.units import degrees


class Kind(Declared):
    """Base of the mechanisms that a file or the command line can describe.

    Beside what the protocol `escapement.model.Mechanism` asks for, a kind has its
    declared fields and the attributes below. Its file is imported to list its options, so it
    loads nothing heavy: NumPy and kernels come through `escapement.lazy`.
    """

    section: ClassVar[str] = "mechanism"
    kind: ClassVar[str]
    """Its name, a key of `escapement.mechanisms.KINDS`."""
    summary: ClassVar[str]
    """What it is, in a line of help."""
    meshed: ClassVar[bool] = False
    """Whether it has no slot, and loses in a mesh."""
    report_units: ClassVar[Mapping[str, str]] = {}
    """Kind of unit of those numbers of the report that have another than their name says."""

    # of subclasses, as fields or properties
    path: Any
    breaks: Any
    follower_angle: Any
    cell_angle: Any
    follower_step: Any
    motion_ratio: Any

    @classmethod
    def options(cls) -> dict[str, Setting]:
        """What the command line asks for, by the name of the option."""
        return declared(cls)

    @classmethod
    def from_options(cls, **given: Any) -> Self:
        """The mechanism of what was typed, in SI, by the key of each option."""
        return cls(**given)

    def report(self) -> dict[str, Any]:
        """Its geometry by JSON key, in SI; angles in degrees where the key says so."""
        raise NotImplementedError

    def cell_report(self) -> dict[str, Any]:
        """How far driver and follower turn in a cell, by JSON key."""
        return {
            "motion_ratio": self.motion_ratio,
            "cell_angle_deg": degrees(self.cell_angle),
            "follower_step_deg": degrees(self.follower_step),
        }


class Wheel(Kind):
    """Base of the wheels with slots that pins drive."""

    slots: Any
    pins: Any
    continuous: Any
    transmission: Any

    def wheel_report(self) -> dict[str, Any]:
        """The cell, slots, pins and dwell of a wheel, by JSON key."""
        turned = self.cell_report()
        return {
            **turned,
            "slots": self.slots,
            "pins": self.pins,
            "continuous": self.continuous,
            "dwell_deg": turned["cell_angle_deg"] * (1.0 - self.motion_ratio),
            "transmission_max": float(self.transmission(0.0).g),
        }
