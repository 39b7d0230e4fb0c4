"""The page that a server sends, with every mechanism, tolerances, and the cases of a study."""

from collections.abc import Callable
from itertools import chain
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Choice, Numbers, Quantity, Setting, Truth, declared
from escapement.base.status import Status
from escapement.base.text import plain, words
from escapement.base.units import spelt
from escapement.dynamics.figure_table import FIGURES
from escapement.explorer import COMPUTED, GROUPS, design_of, explored, filled, read
from escapement.explorer.answers import CLOUD, EXAMPLES, MOST_CASES, TOLERANCES, Answers
from escapement.explorer.serve import Server
from escapement.mechanisms import kind_of
from escapement.model.escapement import AIR, CONTACT, FRICTION, Escapement, Inertia, Run
from escapement.study.plan import StudyPlan
from escapement.study.result import Study

FURTHER = {
    title: tuple(
        name
        for name, entry in declared(Escapement).items()
        if entry.group == title and name not in COMPUTED
    )
    for title in (FRICTION, AIR, CONTACT)
}
"""Fields that the served page has in addition to those of every page."""
MOST_SHOWN = 200_000
_LEAD = (
    "Drag a number: the motion is computed anew by this page, or by the package on this machine if "
    "the page cannot compute it."
)


def server_of(
    escapement: Escapement,
    initial_speed: float = 0.0,
    engagements: int = 20,
    *,
    plan: StudyPlan | None = None,
    study: Study | None = None,
) -> Server:
    """A server of the explorer that begins with a design.

    Parameters
    ----------
    escapement : Escapement
        The design, with any mechanism.
    initial_speed, engagements : float, int
        As for `explorer.page`.
    plan, study : StudyPlan and Study, optional
        A study on a grid, whose cases the page shows.

    Raises
    ------
    InvalidValue
        If the design breaks a rule, or the study is a sample or has more than 200 000 cases.
    """
    answers = Answers(plan)
    shown = None if plan is None or study is None else shown_study(plan, study)
    kinds = {kind: groups_of(kind) for kind in EXAMPLES}
    names = [name for groups in kinds.values() for name in chain(*groups.values())]
    data = explored({"": names}, _entries()) | {"groups": kinds["geneva"]}
    try:
        data["design"] = design_of(escapement, initial_speed, engagements)
        reply = None
    except InvalidValue:
        reply = answers.shown(escapement, initial_speed, engagements)
    server: dict[str, Any] = {
        "kinds": kinds,
        "kind": "geneva",
        "reply": reply,
        "study": shown,
        "sizes": MOST_CASES,
    }
    server["figures"] = [(name, FIGURES[name].long_name.capitalize()) for name in CLOUD]
    parts = read("served.html").replace("<!--TOLERANCES-->", _tolerances())
    parts += read("study.html") if shown else ""

    def page(token: str) -> str:
        return filled("explore", _LEAD, data | {"served": server | {"token": token}}, parts)

    return Server(page, {"/motion": answers.motion, "/cloud": answers.cloud})


def groups_of(kind: str) -> dict[str, list[str]]:
    """Names of the fields for a kind of mechanism, by the titles of their groups."""
    wheel = kind_of(kind)
    names_of_kind = [name for name, entry in declared(wheel).items() if _has_field(entry)]
    entries = _entries()
    found = {"Mechanism": names_of_kind}
    for title in (*GROUPS, *FURTHER):
        if title != "Mechanism" and title not in found:
            names = (*GROUPS.get(title, ()), *FURTHER.get(title, ()))
            found[title] = [name for name in names if entries[name].applies_to(wheel.meshed)]
    return {title: names for title, names in found.items() if names}


def _entries() -> dict[str, Setting]:
    """The declarations of all numbers that have a field, by name."""
    # if two kinds have a number of the same name, its words are those of the first kind
    owners: list[Any] = [*map(kind_of, reversed(EXAMPLES)), Inertia, Escapement, Run]
    return {name: entry for owner in owners for name, entry in declared(owner).items()}


def _has_field(entry: Setting) -> bool:
    return isinstance(entry, Quantity | Truth | Choice) and not isinstance(entry, Numbers)


def _tolerances() -> str:
    """Fields of the tolerances, in percent."""
    given: Callable[[str], float] = {"friction": 10.0, "torque": 5.0}.get  # type: ignore[assignment]
    return "".join(
        f'<label>{words(name).capitalize()} ± <input type="number" name="{name}" min="0" max="50" '
        f'step="any" value="{given(name) or 2.0:g}"> %</label>'
        for name in TOLERANCES
    )


def shown_study(plan: StudyPlan, study: Study) -> dict[str, Any]:
    """Axes and results of a study for the page, in the study's units."""
    if study.sampled:
        remedy = "choose one of its cases with --select"
        raise validate.fail("study", "on a grid to be explored as a whole", "a sample", remedy)
    if study.cases > MOST_SHOWN:
        rule = f"of at most {MOST_SHOWN} cases to be explored as a whole"
        raise validate.fail("study", rule, study.cases, "choose one of its cases with --select")
    answered = study.results["status"] == Status.OK

    def row(name: str, values: Any) -> dict[str, Any]:
        shown = {"words": study.long_names[name].capitalize(), "name": words(name)}
        shown["unit"] = spelt(study.units[name])
        return shown | {"values": plain(values)}

    results = [
        row(name, values.astype(float).ravel())
        for name, values in study.results.items()
        if name != "status" and answered.any()
    ]
    axes = [row(name, values) for name, values in study.axes.items()]
    return {"title": plan.title, "axes": axes, "results": results}
