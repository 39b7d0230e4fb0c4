"""What a scene needs is part of its type, so that kernels are compiled for that alone.

A scene of kind `Kind.STEADY` has a constant torque and load, and losses in pins, bearings and air,
one of kind `Kind.WHOLE` has everything but a torque over the speed, and one of kind `Kind.SPEED`
has that too. In the longest kernels, numbers that a kind does without are
`Known`: what they decide is decided when a kernel is compiled, and neither passed on nor computed.
All other kernels are compiled once, for scenes of any kind.
"""

from enum import IntEnum
from typing import Any

import numba
import numpy as np
from numba.extending import intrinsic

from escapement.model.scene import Scene
from escapement.numerics.jit import in_both_forms
from escapement.numerics.known import Known

FIXED = Scene._fields.index("rho")
"""Fields of a scene that all scenes of a mechanism share; those behind them are numbers."""
NUMBERS = Scene._fields[FIXED:]
"""The numbers of a scene, by name."""
CONSTANT: Any = (0.0, 0.0, 1.0)
"""A constant torque, as `Scene.torque` holds it."""
NO_CURVE: Any = (0.0,)
"""No load that changes, and no fall of the torque, as `Scene.load_curve` and `fall` hold it."""
_NO, _ONE, _UNKNOWN = Known(0.0), Known(1.0), Known(-1.0)
_REST = {
    **dict.fromkeys(("driver_viscous", "follower_viscous", "motor"), _NO),
    **dict.fromkeys(("barrel", "load_train"), _NO),
    **dict.fromkeys(("gain", "barrel_efficiency", "load_train_efficiency"), _ONE),
    "flow": _UNKNOWN,
}
_AT_ALL_SPEEDS = {"pace": _NO}


class Kind(IntEnum):
    """How much a scene needs; each kind can do what those before it can."""

    STEADY = 0
    WHOLE = 1
    SPEED = 2


_KNOWN: dict[Kind, dict[str, Any]] = {
    Kind.STEADY: {**_REST, **_AT_ALL_SPEEDS},
    Kind.WHOLE: _AT_ALL_SPEEDS,
    Kind.SPEED: {},
}
"""The numbers that scenes of a kind do without."""
_PLAIN = np.array([float(_KNOWN[Kind.STEADY].get(name, np.nan)) for name in NUMBERS])
_WITHOUT = {kind: [NUMBERS.index(name) for name in known] for kind, known in _KNOWN.items()}


def kind_of(torque: Any, numbers: Any) -> Kind:
    """The least kind that can do scenes of one torque.

    Parameters
    ----------
    torque : as in `Scene`.
    numbers : for each of `NUMBERS` a number, or an array of those of many scenes.
    """
    least = Kind.STEADY if len(torque) == len(CONSTANT) else Kind.WHOLE
    plain = (np.reshape(numbers, (len(NUMBERS), -1)) == _PLAIN[:, None]).all(axis=1)
    for kind in Kind:
        if kind >= least and plain[_WITHOUT[kind]].all():
            return kind
    return Kind.SPEED


_typeof: Any = numba.typeof
_named_tuple: Any = numba.types.NamedTuple


def _in_python(scene: Scene, _kind: Any) -> Scene:
    return scene


@intrinsic
def _compiled(_context: Any, scene: Any, kind: Any) -> Any:
    known: dict[str, Any] = _KNOWN[Kind(int(kind.value))]
    if not known:
        return scene(scene, kind), lambda context, builder, signature, values: values[0]
    fixed = {**known, "fall": NO_CURVE}
    if "motor" in known:
        fixed |= {"torque": CONSTANT, "driver_angle": 0.0, "load_curve": NO_CURVE}
    kinds: list[Any] = [*scene.types]
    for name, value in fixed.items():
        kinds[scene.fields.index(name)] = _typeof(value)

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        made, result = context.get_constant_undef(signature.return_type), signature.return_type
        for k, name in enumerate(scene.fields):
            value = builder.extract_value(values[0], k)
            if name in fixed:
                value = context.get_constant_generic(builder, result[k], fixed[name])
            made = builder.insert_value(made, value, k)
        return made

    return _named_tuple(kinds, Scene)(scene, kind), emit


needed_scene = in_both_forms(_compiled, _in_python)
"""needed_scene(scene, kind) is a scene with `Known` numbers where a `KINDS` does without them.

Kernels that are compiled for the kind go on with it; in Python it is the scene itself.
"""
KINDS = tuple(Known(float(kind)) for kind in Kind)
"""The kinds as numbers whose value is part of their type."""
