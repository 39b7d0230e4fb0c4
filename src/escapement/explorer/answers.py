"""Answers to the served page's questions: the motion of any design, and a cloud of cases."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.text import words
from escapement.base.toml_file import parse_toml
from escapement.dynamics.figure_table import FIGURES
from escapement.dynamics.painleve import friction_limits
from escapement.engines import simulate as simulation
from escapement.explorer import MOST_ENGAGEMENTS, design_of
from escapement.explorer.as_text import numbers_of, text_of
from escapement.explorer.played import played
from escapement.mechanisms import kind_of
from escapement.model.escapement import Escapement
from escapement.model.torque_curve import TorqueCurve
from escapement.study.parse import parse_plan, plan_from
from escapement.study.plan import StudyPlan, unit_kind
from escapement.study.running import run_plan

EXAMPLES: dict[str, dict[str, Any]] = {
    "geneva": {"slots": 4, "crank_radius": 0.02},
    "gear-driven": {"stations": 4, "lobes": 1, "curve": "epicycloid", "fixed_radius": 0.02},
    "elliptical-planetary": {"sun_radius": 0.03, "planet_radius": 0.02},
}
"""Numbers with which the page begins if another kind of mechanism is chosen."""
TOLERANCES = ("friction", "torque", "driver_inertia", "follower_inertia")
CLOUD = ("period", "velocity_mean", "velocity_max", "velocity_min", "handoff_velocity")
MOST_CASES = 100_000
_BINS = (64, 40)
_BLOCK = 5000  # cases that are drawn and solved at a time
_LONGEST = 3.0  # seconds after which no further block is begun, so that the user need not wait


@dataclass
class Answers:
    """Answers to the questions of a served page.

    plan : StudyPlan, optional
        The study whose cases the page shows.
    """

    plan: StudyPlan | None = None

    def motion(self, question: Mapping[str, Any]) -> dict[str, Any]:
        """The motion of a design.

        Parameters
        ----------
        question : Mapping
            Either `text`, a study of one case in TOML, or `case`, the index of a case of the study.
            With `kind` the mechanism is replaced by an example of another kind. `change` has
            numbers in SI by name that replace its own; `engagements` is their number.

        Returns
        -------
        dict
            `text`, `kind` and `design` (numbers by name) of the changed design. If the page can
            compute it, `plain` has the design for the page and `motion` is None; otherwise `plain`
            is None, and `motion` is as `played` gives it.

        Raises
        ------
        InvalidValue
            If the question cannot be understood, or the design breaks a rule.
        """
        count = question.get("engagements") or 20
        change = dict(self._table(question, "change"))
        count = change.pop("engagements", count)
        count = validate.integer("engagements", count, 1, "show fewer", MOST_ENGAGEMENTS)
        return self.shown(*self._escapement(question, change), count)

    @staticmethod
    def shown(escapement: Escapement, speed: float, count: int) -> dict[str, Any]:
        """The answer of `motion` for an escapement."""
        found: dict[str, Any] = {
            "kind": escapement.mechanism.kind,
            "plain": None,
            "motion": None,
        }
        found["text"] = text_of(escapement, speed)
        found["design"] = numbers_of(escapement) | {"initial_speed": speed, "engagements": count}
        try:
            found["plain"] = design_of(escapement, speed, count)
        except InvalidValue:
            motion = simulation.simulate(escapement, count, initial_speed=speed)
            figures = simulation.terminal(escapement, initial_speed=speed)
            found["motion"] = played(motion, figures)
        return found

    def cloud(self, question: Mapping[str, Any]) -> dict[str, Any]:
        """Scatter of a figure if numbers are uniformly distributed between their tolerances.

        Parameters
        ----------
        question : Mapping
            `text`, as for `motion`; `tolerances`, by name, as shares of the numbers; `figure`, one
            of `CLOUD`; and `size`, the number of cases.

        Returns
        -------
        dict
            `counts` of cases in classes of the first number and the figure, the axes `x` and `y`,
            three `quantiles` of the figure, the number of `cases` and of `failed` ones, and the
            `seconds` that they took. If all cases would take more than three seconds, there are
            fewer.
        """
        start = time.perf_counter()
        escapement, speed = self._escapement(question, {})
        figure = validate.choice("figure", question.get("figure"), CLOUD)
        remedy = f"give at most {MOST_CASES}"
        size = validate.integer("size", question.get("size"), 100, remedy, MOST_CASES)
        sample: dict[str, Any] = {"method": "random"}
        for name, share in self._table(question, "tolerances").items():
            validate.choice("tolerances", name, TOLERANCES)
            if _can_vary(escapement, name):
                sample[name] = {"relative_tolerance": share}
        names = [name for name in TOLERANCES if name in sample]
        if not names:
            remedy = "give one of these numbers a tolerance"
            raise validate.fail("tolerances", f"of {', '.join(TOLERANCES)}", "none", remedy)
        blocks = []
        for seed in range(math.ceil(size / _BLOCK)):
            request = {"seed": seed, "size": min(_BLOCK, size - seed * _BLOCK)}
            chosen: dict[str, Any] = {"sample": sample | request, "results": [figure]}
            study = run_plan(plan_from(escapement, {}, initial_speed=speed, **chosen), workers=2)
            blocks.append((study.sampled[names[0]], study.results[figure]))
            if time.perf_counter() - start > _LONGEST:
                break
        across, values = (np.concatenate(columns) for columns in zip(*blocks, strict=True))
        known, size = np.isfinite(values), values.size
        if not known.any():
            raise InvalidValue(
                f"{figure} must have a value in some case, got none in {size}; choose another "
                "design or smaller tolerances"
            )
        counts, x, y = np.histogram2d(across[known], values[known], _BINS)
        return {
            "cases": size,
            "failed": int(size - known.sum()),
            "figure": FIGURES[figure].long_name[0].upper() + FIGURES[figure].long_name[1:],
            "kind": unit_kind(figure),
            "counts": counts.astype(int).tolist(),
            "x": _axis(names[0], x),
            "y": _axis(figure, y),
            "quantiles": np.quantile(values[known], [0.05, 0.5, 0.95]).tolist(),
            "seconds": time.perf_counter() - start,
        }

    def _escapement(
        self, question: Mapping[str, Any], change: dict[str, Any]
    ) -> tuple[Escapement, float]:
        """The escapement in a question, and its initial speed."""
        plan, case = self._plan(question)
        values = plan.values(case)
        for name in change:
            validate.choice("change", name, tuple(values))
        escapement = plan.built(values | change)
        speed = float(change.get("initial_speed", values["initial_speed"]))
        kind = question.get("kind")
        if kind is None or kind == escapement.mechanism.kind:
            return escapement, speed
        return another_kind(escapement, validate.choice("kind", kind, tuple(EXAMPLES))), speed

    def _plan(self, question: Mapping[str, Any]) -> tuple[StudyPlan, int]:
        if question.get("case") is not None:
            if self.plan is None:
                raise validate.fail("case", "left out", question["case"], "no study is open")
            remedy = "choose a case of the study"
            return self.plan, validate.integer(
                "case", question["case"], 0, remedy, self.plan.cases - 1
            )
        text = question.get("text")
        if not isinstance(text, str):
            raise validate.fail("text", "a study in TOML", text, "give it as a text")
        try:
            content = parse_toml(text)
        except ValueError as error:
            raise InvalidValue(f"the text must be valid TOML, {error}") from None
        plan = parse_plan(content)
        if plan.cases != 1:
            rule = "a study of one case"
            raise validate.fail("text", rule, f"{plan.cases} cases", "give each axis one value")
        return plan, 0

    @staticmethod
    def _table(question: Mapping[str, Any], name: str) -> Mapping[str, Any]:
        value = question.get(name) or {}
        if not isinstance(value, Mapping):
            raise validate.fail(name, "numbers by their names", value, "give an object")
        return value


def _can_vary(escapement: Escapement, name: str) -> bool:
    """Whether a number, one of `TOLERANCES`, can vary by a share of itself."""
    if name == "friction":
        return escapement.friction != 0.0 and not escapement.mechanism.meshed
    return name != "torque" or not isinstance(escapement.torque, TorqueCurve)


def _axis(name: str, edges: np.ndarray) -> dict[str, Any]:
    ends = {"low": float(edges[0]), "high": float(edges[-1])}
    return {"words": words(name), "kind": unit_kind(name), **ends}


def another_kind(escapement: Escapement, kind: str) -> Escapement:
    """An escapement with the same drive and the example of another kind of mechanism."""
    wheel = kind_of(kind)(**EXAMPLES[kind])
    kept = {name: escapement.settings[name] for name in ("torque", "load_torque", "friction")}
    if wheel.meshed:
        kept["friction"] = 0.0
        return Escapement(wheel, escapement.inertia, **kept, efficiency=0.9)
    made = Escapement(wheel, escapement.inertia, **kept | {"friction": 0.0})
    # a wheel of another kind may jam at a smaller friction
    most = 0.5 * friction_limits(made)[0]
    kept["friction"] = min(kept["friction"] or 0.1, float(f"{most:.2g}"))
    return Escapement(wheel, escapement.inertia, **kept)
