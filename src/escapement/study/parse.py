"""From a study file, or its content, to a plan."""

import tomllib
from collections.abc import Collection, Mapping
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from escapement import units, validate
from escapement.errors import InputFileError, InvalidValue
from escapement.files import check_input
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.model import Mechanism
from escapement.quantity import declared
from escapement.solver import Solver
from escapement.study.plan import PlanKind, StudyPlan, model_numbers
from escapement.study.varied import CASE, WIDTHS, axis_values, sample_columns
from escapement.validate import known_keys

MOST_CASES = 10**12

_TOP = ("title", "units", "mechanism", "inertia", "sweep", "sample", "solver")
_SOLVER = tuple(setting.name for setting in fields(Solver))


def load_plan(path: str | PathLike[str]) -> StudyPlan:
    """Read and check a study configuration (TOML).

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read or is not TOML; the message has the line.
    InvalidValue
        When a key is unknown, missing, or its value breaks a rule.
    """
    check_input(path, "study file")
    try:
        # editors on Windows begin a file with a byte order mark
        content = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputFileError(f"study file {path} must be readable, got: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputFileError(
            f"study file {path} must be valid TOML, got: {error}; correct it there"
        ) from None
    try:
        return parse_plan(content)
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def parse_plan(configuration: Mapping[str, Any], mechanism: Mechanism | None = None) -> StudyPlan:
    """Check a study configuration and make a plan of it.

    Parameters
    ----------
    configuration : Mapping
        The content of a study file, in the units that it names.
    mechanism : Mechanism, optional
        Replaces what the [mechanism] table says: for mechanisms of the user's
        own, which no table can describe.

    Raises
    ------
    InvalidValue
        For an unknown key, a missing parameter or a value that breaks its rule.
    """
    kind, machine = _kind(configuration, mechanism)
    system = validate.choice("units", configuration.get("units", "SI"), units.SYSTEMS)
    solver = _solver(_table(configuration, "solver"))
    fixed = _fixed(configuration, kind, _names_varied(configuration, kind))
    varied, forms, fingerprint = _varied(configuration, kind, fixed)
    # of a parameter that lies around it, the nominal value is still part of the study
    around = {name for name, form in forms.get("sample", {}).items() if _lies_around(form)}
    # any other fixed value is replaced by its axis or its distribution
    for name in {name for along in varied.values() for name in along} - around:
        fixed.pop(name, None)
    entries = kind.settings | kind.all_parameters
    plain: dict[str, Any] = {
        "title": _title(configuration, machine["kind"], varied),
        "units": system,
        "mechanism": machine,
    }
    for name, value in fixed.items():
        section = entries[name].section
        (plain.setdefault(section, {}) if section else plain)[entries[name].key] = value
    si = {name: entries[name].to_si(value, system) for name, value in fixed.items()}
    plan = StudyPlan(
        configuration=plain | forms | {"solver": solver.given},
        kind=kind,
        fixed_si=dict.fromkeys(entries) | si,
        varied=varied,
        solver=solver,
        fingerprint=fingerprint,
        own_mechanism=mechanism,
    )
    if plan.cases > MOST_CASES:
        raise InvalidValue(
            f"the grid must have at most {MOST_CASES:.0e} cases, got {plan.cases:.3g}; "
            "shorten an axis"
        )
    return plan


def _table(configuration: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The sub-table `name`, empty where it is absent; of "" the whole configuration."""
    value = configuration.get(name, {}) if name else configuration
    if not isinstance(value, Mapping):
        raise validate.fail(name, "a table", value, f"write [{name}] on a line of its own")
    return value


def _kind(
    configuration: Mapping[str, Any], mechanism: Mechanism | None
) -> tuple[PlanKind, dict[str, Any]]:
    """Kind of the mechanism, and what its table begins with; the keys are checked."""
    machine = {"kind": DEFAULT_KIND, **_table(configuration, "mechanism")}
    if mechanism is not None:
        return PlanKind(None, mechanism.path.table), machine
    name = validate.choice("mechanism.kind", machine["kind"], tuple(KINDS))
    kind = PlanKind.named(name)
    # a key in the wrong table is told where it belongs
    homes, keys = _homes(kind), {"": [*_TOP], "mechanism": ["kind"], "inertia": []}
    for name, entry in (kind.settings | kind.all_parameters).items():
        keys[entry.section].append(entry.key)
        place = f"[{entry.section}]" if entry.section else "the top level"
        homes[entry.key] = place
        if name != entry.key:
            homes[name] = f"{place} as {entry.key!r}"
    for section, known in keys.items():
        place = f"in [{section}]" if section else "at the top level"
        known_keys(_table(configuration, section), known, place, homes)
    return kind, {"kind": machine["kind"]}


def _homes(kind: PlanKind) -> dict[str, str]:
    """Where keys belong that are no parameters of the model, or of another kind of mechanism."""
    owners: dict[str, list[str]] = {}
    for name in KINDS:
        for key in declared(kind_of(name)):
            owners.setdefault(key, []).append(repr(name))
    homes = {key: f"[mechanism] of kind {' or '.join(names)}" for key, names in owners.items()}
    for name, entry in model_numbers().items():
        if not entry.fits(kind.meshed):
            slot = "with" if kind.meshed else "without"
            homes[name] = f"a study of a mechanism {slot} a slot"
    homes |= dict.fromkeys(["kind", *kind.settings], "[mechanism]")
    return homes | dict.fromkeys(_SOLVER, "[solver]") | dict.fromkeys(["size", "seed"], "[sample]")


def _fixed(
    configuration: Mapping[str, Any], kind: PlanKind, varied: Collection[str]
) -> dict[str, Any]:
    """Fixed and nominal values, default ones of numbers included; what varies needs none."""
    fixed, missing = {}, []
    for name, entry in (kind.settings | kind.all_parameters).items():
        section = _table(configuration, entry.section)
        if entry.key in section:
            fixed[name] = entry.read(entry.label, section[entry.key])
        elif entry.required and name not in varied:
            missing.append(f"{entry.label} ({entry.long_name})")
        elif entry.axis and entry.default is not None:
            fixed[name] = entry.default
    if missing:
        raise InvalidValue(
            f"the study lacks {', '.join(missing)}; give each a fixed value or an axis"
        )
    return fixed


def _names_varied(configuration: Mapping[str, Any], kind: PlanKind) -> set[str]:
    """Keys of [sweep] and [sample], which must not share one."""
    swept, drawn = _table(configuration, "sweep"), _table(configuration, "sample")
    known_keys(swept, kind.all_parameters, "in [sweep]", _homes(kind))
    if not swept and "sample" not in configuration:
        raise InvalidValue(
            "the study must sweep at least one parameter, got none; "
            "add an axis (of a study file under [sweep]), for example friction = [0.2, 0.3]"
        )
    for name in drawn:
        if name in swept:
            raise InvalidValue(
                f"{name} must be in [sweep] or in [sample], got both; leave one of them out"
            )
    return {*swept, *drawn}


def _varied(
    configuration: Mapping[str, Any], kind: PlanKind, nominal: Mapping[str, Any]
) -> tuple[dict[str, dict[str, Any]], dict[str, Any], str]:
    """Columns along each dimension, their tables as plain JSON, and the sample's fingerprint."""
    parameters, fingerprint = kind.all_parameters, ""
    varied, swept, forms = {}, {}, {}
    for name, form in _table(configuration, "sweep").items():
        values, swept[name] = axis_values(name, form, parameters[name])
        varied[name] = {name: values}
    if swept:
        forms["sweep"] = swept
    if "sample" in configuration:
        drawn = _table(configuration, "sample")
        varied[CASE], forms["sample"], fingerprint = sample_columns(drawn, parameters, nominal)
    return varied, forms, fingerprint


def _lies_around(form: Any) -> bool:
    """Whether a sampled parameter lies around its nominal value, which then stays fixed."""
    return isinstance(form, Mapping) and not WIDTHS.isdisjoint(form)


def _solver(settings: Mapping[str, Any]) -> Solver:
    known_keys(settings, _SOLVER, "in [solver]")
    return Solver(**settings)


def _title(configuration: Mapping[str, Any], kind: str, varied: Mapping[str, Any]) -> str:
    """The title given, or one made from what varies."""
    over = [", ".join(name for name in varied if name != CASE)]
    over += ["a sample of " + ", ".join(varied[CASE])] if CASE in varied else []
    default = f"{kind} escapement over {' and '.join(filter(None, over))}"
    title = configuration.get("title", default)
    if not isinstance(title, str) or not title.isprintable():
        raise validate.fail("title", "one line of text", title, "put it in quotation marks")
    return title
