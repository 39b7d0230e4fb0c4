"""Settings of the engines, which are checked here without loading an engine."""

import math
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Choice, Declared, quantity, setting

ENGINES = ("energy", "ivp", "contact", "two_bodies")
DEFAULT_ENGINE = "energy"
DEFAULT_RTOL = {"energy": 1e-12, "ivp": 1e-10, "contact": 1e-10, "two_bodies": 1e-12}
LOOSEST = 1e-8
"""Greatest relative error of an engagement by "energy": a larger one would save no time."""
METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")


@dataclass(frozen=True)
class Solver(Declared):
    """Which engine, and how accurately; None leaves a choice to the engine.

    Parameters
    ----------
    engine : str, optional
        "energy" (fast), "ivp" (the reference), "contact" (clearance and compliant contact) or
        "two_bodies" (outlines). By default the scene chooses: "two_bodies" where both bodies have
        outlines, "contact" where others have clearance or stiffness, else "energy".
    rtol : float, optional
        Relative error asked for, in [1e-13, 1). Where less accuracy saves no time there is none:
        "energy" solves every engagement to 1e-8 or better, "contact" with rigid walls to 1e-7,
        "ivp" gives SciPy at most 1e-9, and outlines with stiffness are solved to 1e-10 at best.
    atol, method, max_step : optional
        For "ivp" only, as in SciPy's solve_ivp: absolute tolerance [rad, rad/s, J], at
        most 1 unless a longest step is given, method, and longest step [s].

    Raises
    ------
    InvalidValue
        When a setting breaks its rule.
    """

    section = "solver"

    engine: str | None = field(default=None, metadata=setting(Choice(
        long_name="energy, the fast one, ivp, the reference, contact, with clearance, or "
        "two_bodies, with outlines",
        allowed=ENGINES, metavar="NAME", note=" (default: what the scene needs)"
    )))  # fmt: skip
    rtol: float | None = field(default=None, metadata=quantity(
        "relative error of handoff times and speeds", minimum=1e-13, maximum=1.0, below=True,
        axis=False, metavar="R", remedy="1e-10 is a good choice",
        note=f" (default: {DEFAULT_RTOL['energy']:g}, else {DEFAULT_RTOL['ivp']:g}); energy "
        f"solves every engagement to {LOOSEST:g} or better"
    ))  # fmt: skip
    atol: float | None = field(default=None, metadata=quantity(
        "absolute tolerance as in SciPy's solve_ivp", axis=False, metavar="A", note=", with ivp",
        remedy="leave it out for a fitting one"
    ))  # fmt: skip
    method: str | None = field(default=None, metadata=setting(Choice(
        long_name=f"{METHODS[0]} (default), {', '.join(METHODS[1:])}", allowed=METHODS,
        metavar="NAME", note=", with ivp"
    )))  # fmt: skip
    max_step: float | None = field(default=None, metadata=quantity(
        "longest step", "time", exclusive=True, axis=False, note=", with ivp",
        remedy="give the longest step"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        self.check_fields()
        for name in ("atol", "method", "max_step"):
            value = getattr(self, name)
            if value is not None and self.engine != "ivp":
                rule = f"left out with engine {self.engine or DEFAULT_ENGINE!r}"
                raise validate.fail(name, rule, value, "or choose engine 'ivp'")
        if self.max_step is None and self.atol is not None and self.atol > 1.0:
            # 1 rad is most of an engagement: the error would no longer limit the steps
            rule = "at most 1 unless max_step is given"
            raise validate.fail("atol", rule, self.atol, "leave it out for a fitting one")

    @property
    def given(self) -> dict[str, Any]:
        """The settings that are not left to the engine."""
        every = ((setting.name, getattr(self, setting.name)) for setting in fields(self))
        return {name: value for name, value in every if value is not None}

    @property
    def tolerance(self) -> float:
        """Relative error asked for, by default that of the engine [-]."""
        engine = self.engine or DEFAULT_ENGINE
        return DEFAULT_RTOL[engine] if self.rtol is None else self.rtol

    @cached_property
    def arguments(self) -> dict[str, Any]:
        """Keyword arguments of an engine's functions, with defaults filled in."""
        if self.engine != "ivp":
            return {"rtol": self.tolerance}
        return {
            "rtol": self.tolerance,
            "atol": self.atol,
            "method": self.method or METHODS[0],
            "max_step": math.inf if self.max_step is None else self.max_step,
        }


def solver_for(contact: str, solver: Solver) -> Solver:
    """The settings with the engine that a scene needs.

    Parameters
    ----------
    contact : str
        The law of contact of the scene, as `Escapement.contact` says; "" for none.
    solver : Solver
        The given settings; their engine may be None.

    Raises
    ------
    InvalidValue
        If they name an engine that cannot compute the scene.
    """
    engine = solver.engine
    outlines = contact.endswith("outlines")
    if outlines != (engine == "two_bodies") and (engine or outlines):
        if engine is None:
            return with_engine(solver, "two_bodies")
        needed = "'two_bodies' for bodies that touch with their outlines, and for no others"
        raise validate.fail("engine", needed, engine, "leave it out")
    if engine is None:
        return with_engine(solver, "contact") if contact else solver
    if engine == "two_bodies":
        return solver
    if contact and engine != "contact":
        rule = "'contact' with clearance or stiffness"
        raise validate.fail("engine", rule, engine, "leave it out, or set both to 0")
    if not contact and engine == "contact":
        rule = "'energy' or 'ivp' without clearance or stiffness"
        raise validate.fail("engine", rule, engine, "leave it out, or give one of the two")
    return solver


@lru_cache
def with_engine(solver: Solver, engine: str) -> Solver:
    """The same settings with another engine."""
    return replace(solver, engine=engine)


def choose_solver(solver: Solver | None, *separate: Any) -> Solver:
    """The given `solver`, or one made from separate settings, of which None means not given.

    The separate settings are in the order of the fields of `Solver`.

    Raises
    ------
    InvalidValue
        When both are given, or a setting breaks its rule.
    """
    return DEFAULT_SOLVER if solver is None and separate == _NOTHING else _kept(solver, *separate)


DEFAULT_SOLVER, _NOTHING = Solver(), (None,) * len(fields(Solver))


# checked settings are kept: their check takes longer than solving an engagement
@lru_cache(typed=True)
def _kept(solver: Solver | None, *separate: Any) -> Solver:
    pairs = zip(fields(Solver), separate, strict=False)
    given = {setting.name: value for setting, value in pairs if value is not None}
    if solver is None:
        return Solver(**given)
    if not isinstance(solver, Solver):
        raise validate.fail("solver", "a Solver", solver, "give for example Solver(rtol=1e-10)")
    if given:
        raise InvalidValue(
            f"solver must not come with {', '.join(given)}, got both; "
            "make all settings part of the Solver, or leave solver out"
        )
    return solver
