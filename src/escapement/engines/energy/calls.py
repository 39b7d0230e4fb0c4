"""The two long kernels of the engine, which all others call by address."""

from functools import cache

from escapement.by_address import by_address
from escapement.engines.energy import events as _events
from escapement.engines.energy import march as _march

_LOSS = "UniTuple(f8, 2)"
march, _march_address = by_address(
    _march.march,
    0,
    f"(f8[::1], i8, f8[::1], f8[::1], f8[:, :, ::1], f8, {_LOSS}, f8, f8, f8, f8, f8, f8, i8,"
    " f8[:, ::1], i8)",
)
place, _place_address = by_address(
    _events.place, 1, f"(f8[:, ::1], i8, f8[::1], f8[::1], f8, {_LOSS}, f8)"
)


@cache
def addresses() -> tuple[int, int]:
    """What the calls take first, in this process."""
    return _march_address(), _place_address()
