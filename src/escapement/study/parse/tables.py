"""Tables of a study file: which key belongs in which, and what a study must give."""

from collections.abc import Collection, Mapping, Sequence
from datetime import date
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Numbers, Setting, declared
from escapement.base.validate import known_keys
from escapement.dynamics.figure_table import RUN_TIME
from escapement.engines.solver import Solver
from escapement.mechanisms import KINDS, kind_of
from escapement.mechanisms.wheel_checks import IMPERFECT
from escapement.model.train import ROLES
from escapement.study.plan import CASE, Settings
from escapement.study.subject import ESCAPEMENT, SUBJECTS, Subject, model_numbers, subject_of

SOLVER = declared(Solver)
_TOP = (
    *("title", "date", "units", "study", "results", "mechanism", "inertia", *ROLES),
    *("sweep", "sample", "solver"),
)
Content = Mapping[str, Any]


def table(content: Content, name: str) -> Content:
    """The sub-table `name`, empty where it is absent; of "" the whole content."""
    value = content.get(name, {}) if name else content
    # to ask whether a dict is a Mapping takes a hundred times as long
    if type(value) is not dict and not isinstance(value, Mapping):
        raise validate.fail(name, "a table", value, f"write [{name}] on a line of its own")
    return value


def check_keys(content: Content, settings: Settings) -> None:
    """Refuse a study in which nothing varies, and an unknown key, saying where it belongs."""
    subject, names = subject_of(content), settings.names
    machine = ("kind",) if "mechanism" in names else ("kind", "description")
    beside: dict[str, Collection[str]] = {"sweep": _factors(settings).values(), "": _TOP}
    beside |= {"mechanism": machine, **dict.fromkeys(("inertia", *ROLES), ())}
    beside |= {"solver": SOLVER if subject is ESCAPEMENT else ()}
    for section, others in beside.items():
        keys = settings.axes if section == "sweep" else names.get(section, {})
        given = table(content, section)
        if any(key not in keys and key not in others for key in given):
            where = f"in [{section}]" if section else "at the top level"
            known_keys(given, [*others, *keys], where, _homes(settings, section, subject))
    if not table(content, "sweep") and "sample" not in content:
        raise InvalidValue(
            "the study must sweep at least one parameter, got none; "
            "add an axis (of a study file under [sweep]), for example friction = [0.2, 0.3]"
        )


def _factors(settings: Mapping[str, Setting]) -> dict[str, str]:
    """The axis that scales each list of errors, by the name of the list."""
    return {n: f"{n}_factor" for n in IMPERFECT if isinstance(settings.get(n), Numbers)}


def _homes(settings: Mapping[str, Setting], section: str, subject: Subject) -> dict[str, str]:
    """Where each key belongs that does not belong in this section."""
    machine = {name for name, entry in settings.items() if entry.section == "mechanism"}
    homes: dict[str, str] = {}
    for kind in KINDS:
        for key in (*declared(kind_of(kind)), *kind_of(kind).other_sizes()):
            others = f"{homes[key]} or" if key in homes else "[mechanism] of kind"
            homes[key] = f"{others} {kind!r}"
    for other in SUBJECTS.values():
        for name in other.settings().keys() - settings.keys() if other is not subject else ():
            homes[name] = f"a study with study = {other.name!r}"
    for name in model_numbers().keys() - settings.keys() if subject is ESCAPEMENT else ():
        slot = "with" if model_numbers()[name].slotted else "without"
        homes[name] = f"a study of a mechanism {slot} a slot"
    homes |= dict.fromkeys(("kind", *machine), "[mechanism]") | dict.fromkeys(SOLVER, "[solver]")
    homes |= dict.fromkeys(("size", "seed"), "[sample]")
    for name, axis in _factors(settings).items():
        homes[name] = f"[mechanism], and its factor is {axis!r}"
    for name, entry in settings.items() if section != "sweep" else ():
        where = f"[{entry.section}]" if entry.section else "the top level"
        # a number that the mechanism lacks, such as an efficiency, may belong to a train
        key = homes.get(entry.key, where) if entry.section in ROLES else where
        homes |= {name: f"{where} as {entry.key!r}", entry.key: key}
    return homes


def fixed_values(content: Content, settings: Settings) -> dict[str, Any]:
    """Fixed and nominal values, including defaults; parameters that vary need none."""
    given = {}
    for section, names in settings.names.items():
        for key, value in table(content, section).items():
            if key in names:
                name = names[key]
                given[name] = settings[name].read(settings[name].label, value)
    known = {**table(content, "sweep"), **table(content, "sample"), **given}
    missing = [settings[name] for name in settings.required if name not in known]
    if missing:
        lacking = ", ".join(f"{entry.label} ({entry.long_name})" for entry in missing)
        raise InvalidValue(f"the study lacks {lacking}; give each a fixed value or an axis")
    fixed = settings.defaults | given
    return {name: value for name, value in fixed.items() if value is not None}


def chosen_results(content: Content) -> dict[str, list[str]]:
    """The figures of merit to keep, if they differ from the default ones."""
    subject = subject_of(content)
    if "results" not in content:
        return {}
    given = content["results"]
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise validate.fail("results", "a list of names", given, 'for example ["period"]')
    # the status is always kept, and a name that is given twice is kept once
    every = (validate.choice("results", name, (*subject.figures, "status")) for name in given)
    names = [name for name in dict.fromkeys(every) if name != "status"]
    if RUN_TIME in names and not any("turns" in table(content, x) for x in ("", "sweep", "sample")):
        rule, remedy = "given with the result run_time", "give how often the driver turns"
        raise validate.fail("turns", rule, None, remedy)
    return {"results": names} if names != [*subject.usual] else {}


def title_of(content: Content, kind: str, varied: Mapping[str, Any]) -> str:
    """The title given, or one made from what varies."""
    over = [", ".join(name for name in varied if name != CASE)]
    over += ["a sample of " + ", ".join(varied[CASE])] if CASE in varied else []
    default = f"{kind} {subject_of(content).noun} over {' and '.join(filter(None, over))}"
    title = content.get("title", default)
    if not isinstance(title, str) or not title.isprintable():
        raise validate.fail("title", "one line of text", title, "put it in quotation marks")
    return title


def date_of(content: Content) -> dict[str, str]:
    """The date of the design, if the study gives one."""
    given = content.get("date")
    if given is None:
        return {}
    if not isinstance(given, date | str) or not str(given).isprintable():
        raise validate.fail("date", "a date, or one line of text", given, "write 2026-11-26")
    return {"date": str(given)}
