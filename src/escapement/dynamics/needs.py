"""What a scene needs is part of its type, so that kernels are compiled for that alone.

A scene of kind `Kind.IDEAL` has friction and a load, one of kind `Kind.STEADY` also losses in pins,
bearings and air, and one of kind `Kind.WHOLE` has everything. Numbers that a kind does without
are `Known`: what they decide is decided when a kernel is compiled, and neither passed on nor
computed. `plain_scene` has what a kernel is given, of which `typed_scene` makes a `Scene`.
"""

from collections.abc import Iterable
from enum import IntEnum
from typing import Any

import numpy as np
from numba.extending import overload

from escapement.mechanisms.path import OFFSET, Path
from escapement.model.scene import Scene, scene_tuple
from escapement.numerics.known import Known

FIXED = Scene._fields.index("rho")
"""Fields of a scene that all scenes of a mechanism share; those behind them are numbers."""
NUMBERS = Scene._fields[FIXED:]
"""The numbers of a scene, by name."""
CONSTANT: Any = (0.0, 0.0, 1.0)
"""A constant torque, as `Scene.torque` holds it."""
NO_CURVE: Any = (0.0,)
"""No load that changes, as `Scene.load_curve` holds it."""
_NO, _ONE, _UNKNOWN = Known(0.0), Known(1.0), Known(-1.0)
_LOSSES = dict.fromkeys(
    ("bearing", "driver_drag", "follower_drag", "pin", "driver_journal", "follower_journal"), _NO
)
_REST = {
    **dict.fromkeys(("driver_viscous", "follower_viscous", "motor"), _NO),
    **dict.fromkeys(("barrel", "load_train"), _NO),
    **dict.fromkeys(("gain", "barrel_efficiency", "load_train_efficiency"), _ONE),
    "flow": _UNKNOWN,
}


class Kind(IntEnum):
    """How much a scene needs; each kind can do what those before it can."""

    IDEAL = 0
    STEADY = 1
    WHOLE = 2


_KNOWN: dict[Kind, dict[str, Any]] = {
    Kind.IDEAL: {**_LOSSES, **_REST},
    Kind.STEADY: _REST,
    Kind.WHOLE: {},
}
"""The numbers that scenes of a kind do without."""


def kind_of(path: Path, torque: Any, numbers: Iterable[Any]) -> Kind:
    """The least kind that can do scenes of one path and torque.

    Parameters
    ----------
    path, torque : as in `Scene`.
    numbers : for each of `NUMBERS` a number, or an array of those of many scenes.
    """
    if len(torque) != len(CONSTANT):
        return Kind.WHOLE
    given = dict(zip(NUMBERS, numbers, strict=True))
    for kind in Kind:
        # only a slot through the axis is ideal
        fits = kind > Kind.IDEAL or path.table or path.numbers[OFFSET] == 0.0
        if fits and all(np.all(given[name] == value) for name, value in _KNOWN[kind].items()):
            return kind
    return Kind.WHOLE


def known_scene(scene: Scene, kind: Kind) -> Scene:
    """A scene with `Known` numbers where a kind does without them."""
    if kind == Kind.WHOLE:
        return scene
    return scene._replace(torque=CONSTANT, driver_angle=0.0, load_curve=NO_CURVE, **_KNOWN[kind])


def plain_scene(scene: Scene, kind: Kind) -> tuple[Any, ...]:
    """What kernels need of a scene of a kind, as nested plain tuples; see `scene_tuple`."""
    if kind == Kind.WHOLE:
        return scene_tuple(scene)
    chosen = (getattr(scene, name) for name in NUMBERS if name not in _KNOWN[kind])
    return tuple(scene.path), scene.edges, scene.dwell, *chosen


def _ideal(plain: Any) -> Any:
    path, edges, dwell, rho, plus, minus, load = plain
    return Scene(
        Path(path[0], path[1]), edges, dwell, CONSTANT, 0.0, NO_CURVE, rho, plus, minus, load,
        _NO, _NO, _NO, _NO, _NO, _NO, _NO, _NO, _ONE, _UNKNOWN, _NO, _ONE, _NO, _ONE, _NO,
    )  # fmt: skip


def _steady(plain: Any) -> Any:
    path, edges, dwell, rho, plus, minus, load, bearing, air, wind, pin, one, two = plain
    return Scene(
        Path(path[0], path[1]), edges, dwell, CONSTANT, 0.0, NO_CURVE, rho, plus, minus, load,
        bearing, air, wind, _NO, _NO, pin, one, two, _ONE, _UNKNOWN, _NO, _ONE, _NO, _ONE, _NO,
    )  # fmt: skip


def _whole(plain: Any) -> Any:
    path = plain[0]
    return Scene(Path(path[0], path[1]), *plain[1:])


_MAKERS = {FIXED - 3 + len(NUMBERS) - len(_KNOWN[Kind.IDEAL]): _ideal}
_MAKERS |= {FIXED - 3 + len(NUMBERS) - len(_REST): _steady, len(Scene._fields): _whole}
"""Functions that make a scene, by the length of its plain tuple."""


def typed_scene(plain: Any) -> Any:
    """The scene that belongs to the nested tuples of `plain_scene`, in kernels that allocate."""
    return _MAKERS[len(plain)](plain)


@overload(typed_scene, strict=False)
def _typed_scene(plain: Any) -> Any:
    return _MAKERS[len(plain)]
