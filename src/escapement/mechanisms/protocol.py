"""What an escapement needs to know of a mechanism."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from escapement.base import validate
from escapement.mechanisms.path import Meeting, Path, smooth_intervals, writeable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    FloatArray = NDArray[np.float64]
else:
    FloatArray = Any  # importing NumPy takes longer than the rest of help


@runtime_checkable
class Mechanism(Protocol):
    """What an escapement needs to know of a mechanism.

    A *cell* is the driver angle between one pin's entry and the next one's,
    dwell included. Driver angles are local to the cell and measured from dead
    centre; the follower angle is oriented so that it grows.
    """

    @property
    def cell_angle(self) -> float:
        """Driver angle of one cell [rad]."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Entry, every kink of the sliding speed of a thin pin, exit [rad], ascending.

        Between neighbours the transmission is analytic. From the exit to the
        end of the cell the follower is locked.
        """

    @property
    def follower_step(self) -> float:
        """Follower angle per cell [rad]."""

    @property
    def path(self) -> Path:
        """What kernels evaluate the transmission from: a pin path or a table."""

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle [rad], zero at dead centre."""


_MECHANISM = ("cell_angle", "breaks", "follower_step", "path", "follower_angle")


def is_mechanism(thing: object) -> bool:
    """Whether an object, not a class, has all attributes of a mechanism; none is evaluated.

    `isinstance` would evaluate the path, which a mechanism with a geometry but no dynamics
    refuses.
    """
    own = vars(thing) if hasattr(thing, "__dict__") else {}
    has = (hasattr(type(thing), name) or own.get(name) is not None for name in _MECHANISM)
    return all(has) and not isinstance(thing, type)


def checked(mechanism: Any, perfect: bool = True) -> Any:
    """`mechanism`, or an error if it is not one; errors of parts must not be ignored silently."""
    if not is_mechanism(mechanism):
        raise validate.fail("mechanism", "a mechanism", mechanism, "give for example Geneva(4)")
    if perfect and not getattr(mechanism, "perfect", True):
        remedy = "leave out its errors, which simulate and terminal take into account"
        raise validate.fail("mechanism", "without errors of its parts here", mechanism, remedy)
    return mechanism


def dwell_angle(mechanism: Mechanism) -> float:
    """Driver angle of a cell in which the follower is locked [rad]."""
    dwell = mechanism.cell_angle - (mechanism.breaks[-1] - mechanism.breaks[0])
    # angles in radians are rounded, so a dwell of 0 may come out as one or two units of rounding
    return float(dwell) if dwell > 1e-12 else 0.0


def meetings_of(mechanism: Any) -> tuple[Meeting, ...]:
    """The engagements after which a mechanism repeats itself, one if its parts are perfect."""
    if not getattr(mechanism, "perfect", True):
        return mechanism.meetings  # type: ignore[no-any-return]
    path, dwell = writeable(mechanism.path), dwell_angle(mechanism)
    edges = smooth_intervals(path, mechanism.breaks)
    return (
        Meeting(
            path=path, edges=edges, dwell=dwell, late=0.0, turned=mechanism.follower_angle,
            kind="pick-up" if dwell > 0.0 else "overlap", jump=0.0, radius=math.nan,
        ),
    )  # fmt: skip
