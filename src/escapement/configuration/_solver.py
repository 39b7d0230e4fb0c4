"""Settings of the engine, checked without loading an engine."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from escapement import _validate
from escapement.configuration._keys import check_keys
from escapement.errors import InvalidValue

ENGINES = ("energy", "ivp")
METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
DEFAULT_ENGINE = "energy"


@dataclass(frozen=True)
class Solver:
    """Which engine, and how accurately; None leaves a choice to the engine.

    engine : "energy" (fast) or "ivp" (the reference).
    rtol : relative error asked for, in [1e-13, 1).
    atol, method, max_step : for "ivp" only, as in scipy's solve_ivp; step in [s].
    """

    engine: str = DEFAULT_ENGINE
    rtol: float | None = None
    atol: float | None = None
    method: str | None = None
    max_step: float | None = None

    def __post_init__(self) -> None:
        _validate.choice("engine", self.engine, ENGINES)
        checks = {
            "rtol": _tolerance,
            "atol": lambda v: _validate.non_negative("atol", v, "leave it out"),
            "method": lambda v: _validate.choice("method", v, METHODS),
            "max_step": lambda v: _validate.positive("max_step", v, "give the longest step in s"),
        }
        for name, check in checks.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, check(value))
        if self.engine != "ivp":
            self._refuse_settings_of_ivp()

    def _refuse_settings_of_ivp(self) -> None:
        for name in ("atol", "method", "max_step"):
            if getattr(self, name) is not None:
                raise InvalidValue(
                    f"{name} must be left out with engine {self.engine!r}, got "
                    f"{getattr(self, name)!r}; only engine 'ivp' has it"
                )

    @property
    def given(self) -> dict[str, Any]:
        """The settings that are not left to the engine."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def parse_solver(table: Mapping[str, Any]) -> Solver:
    """Solver from the [solver] table of a study; raises InvalidValue."""
    check_keys(table, tuple(field.name for field in fields(Solver)), "in [solver]")
    return Solver(**table)


def _tolerance(value: Any) -> float:
    tolerance = _validate.number("rtol", value, "1e-10 is a good choice")
    if not 1e-13 <= tolerance < 1.0:
        raise _validate.fail("rtol", "at least 1e-13 and below 1", value, "1e-10 is a good choice")
    return tolerance
