"""From a study file, or its content, to a plan."""

import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from escapement import units, validate
from escapement.errors import InputFileError, InvalidValue, MissingInput
from escapement.mechanisms import DEFAULT_KIND, KINDS
from escapement.model import Mechanism
from escapement.quantity import Quantity
from escapement.solver import Solver
from escapement.study.axes import axis_values
from escapement.study.parameters import PlanKind, homes
from escapement.study.plan import StudyPlan
from escapement.study.sample import Sample, parse_sample
from escapement.validate import known_keys

_BARE_POINT = re.compile(r"(?<![\w.])[+-]?(\.\d+|\d+\.)(?![\w.])")


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
    content = _toml(Path(path))
    try:
        return parse_plan(content)
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def _toml(path: Path) -> dict[str, Any]:
    try:
        data = path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        raise MissingInput(f"study file {path} does not exist; check its name") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputFileError(
            f"study file {path} must be a readable file, got: {reason}; name a TOML file"
        ) from None
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        reason = f"a byte that is not UTF-8 (at line {line})"
    except RecursionError:
        reason = "values nested too deeply"
    except ValueError as error:
        reason = str(error)
    remedy = _bare_point(data, reason) or "correct that line"
    raise InputFileError(f"study file {path} must be valid TOML, got: {reason}; {remedy}")


def _bare_point(data: bytes, reason: str) -> str:
    """What to write for a number with nothing before or after its point; empty for no such."""
    line = re.search(r"at line (\d+)", reason)
    if line is None:
        return ""
    text = data.splitlines()[int(line[1]) - 1].decode(errors="replace").partition("#")[0]
    found = _BARE_POINT.search(text)
    if found is None:
        return ""
    number = found[1]
    return f"write {number + '0' if number.endswith('.') else '0' + number}, not {number}"


MOST_CASES = 10**12
_SECTIONS = ("mechanism", "inertia", "sweep", "sample", "solver")


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
    machine = dict(table(configuration, "mechanism"))
    if mechanism is None:
        machine.setdefault("kind", DEFAULT_KIND)
        kind = PlanKind.named(validate.choice("mechanism.kind", machine["kind"], tuple(KINDS)))
        _check_keys(configuration, kind)
        machine = {"kind": machine["kind"]} | _options(machine, kind)
    else:
        kind = PlanKind.of(mechanism)
    system = validate.choice("units", configuration.get("units", "SI"), units.SYSTEMS)
    parameters = kind.all_parameters
    axes, forms = _axes(table(configuration, "sweep"), parameters, _homes(kind))
    drawn = table(configuration, "sample")
    if not axes and "sample" not in configuration:
        raise InvalidValue(
            "the study must sweep at least one parameter, got none; "
            "add an axis (of a study file under [sweep]), for example friction = [0.2, 0.3]"
        )
    values = _values(configuration, parameters, {*axes, *drawn})
    sample = _sample(drawn, parameters, axes, values) if "sample" in configuration else None
    sampled = [*sample.values] if sample else []
    replaced = {*axes, *sampled} - (sample.around if sample else set())
    over = ", ".join(axes) + " and " * bool(axes and sampled)
    over += "a sample of " * bool(sampled) + ", ".join(sampled)
    title = configuration.get("title", f"{machine['kind']} escapement over {over}")
    plan = StudyPlan(
        title=_title(title),
        unit_system=system,
        kind=kind,
        machine=machine,
        fixed={name: value for name, value in values.items() if name not in replaced},
        axes=axes,
        forms=forms,
        solver=_solver(table(configuration, "solver")),
        sample=sample,
        own_mechanism=mechanism,
    )
    if plan.cases > MOST_CASES:
        raise InvalidValue(
            f"the grid must have at most {MOST_CASES:.0e} cases, got {plan.cases:.3g}; "
            "shorten an axis"
        )
    return plan


def _homes(kind: PlanKind) -> dict[str, str]:
    """Where keys belong that are no parameters of the model."""
    settings = dict.fromkeys((setting.name for setting in fields(Solver)), "[solver]")
    return homes(kind) | settings | dict.fromkeys(["size", "seed"], "[sample]")


def _check_keys(configuration: Mapping[str, Any], kind: PlanKind) -> None:
    """Refuse keys that no part of a study has, naming where each would belong."""
    known = _homes(kind)
    keys: dict[str, list[str]] = {"": ["title", "units", *_SECTIONS], "inertia": []}
    keys["mechanism"] = ["kind", *kind.options]
    for name, parameter in kind.all_parameters.items():
        keys[parameter.section].append(parameter.key)
        where = f"[{parameter.section}]" if parameter.section else "the top level"
        known[parameter.key] = where
        if name != parameter.key:
            known[name] = f"{where} as {parameter.key!r}"
    known_keys(configuration, keys[""], "at the top level", known)
    for section in ("mechanism", "inertia"):
        known_keys(table(configuration, section), keys[section], f"in [{section}]", known)


def table(configuration: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The sub-table `name`, empty where it is absent."""
    value = configuration.get(name, {})
    if not isinstance(value, Mapping):
        raise validate.fail(name, "a table", value, f"write [{name}] on a line of its own")
    return value


def _options(machine: Mapping[str, Any], kind: PlanKind) -> dict[str, Any]:
    for name, option in kind.options.items():
        if option.required and name not in machine:
            raise InvalidValue(f"the study lacks mechanism.{name}; write it in [mechanism]")
    return {
        name: option.read(option.label, machine[name])
        for name, option in kind.options.items()
        if name in machine
    }


def _axes(
    forms: Mapping[str, Any], parameters: Mapping[str, Quantity], homes: Mapping[str, str]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Values and JSON form of every axis, in order."""
    known_keys(forms, parameters, "in [sweep]", homes)
    parsed = {name: axis_values(name, form, parameters[name]) for name, form in forms.items()}
    axes = {name: values for name, (values, _) in parsed.items()}
    return axes, {name: form for name, (_, form) in parsed.items()}


def _sample(
    drawn: Mapping[str, Any],
    parameters: Mapping[str, Quantity],
    axes: Mapping[str, Any],
    nominal: Mapping[str, float],
) -> Sample:
    both = [name for name in drawn if name in axes]
    if both:
        raise InvalidValue(
            f"{both[0]} must be in [sweep] or in [sample], got both; leave one of them out"
        )
    return parse_sample(drawn, parameters, nominal)


def _values(
    configuration: Mapping[str, Any], parameters: Mapping[str, Quantity], varied: Collection[str]
) -> dict[str, float]:
    """Fixed and nominal values, the default ones included; what varies needs none."""
    fixed, missing = {}, []
    for name, parameter in parameters.items():
        section = table(configuration, parameter.section) if parameter.section else configuration
        if parameter.key in section:
            fixed[name] = parameter.read(parameter.label, section[parameter.key])
        elif parameter.default is not None:
            fixed[name] = parameter.default
        elif parameter.required and name not in varied:
            missing.append(f"{parameter.label} ({parameter.long_name})")
    if missing:
        raise InvalidValue(
            f"the study lacks {', '.join(missing)}; give each a fixed value or an axis"
        )
    return fixed


def _solver(settings: Mapping[str, Any]) -> Solver:
    known_keys(settings, tuple(field.name for field in fields(Solver)), "in [solver]")
    return Solver(**settings)


def _title(title: Any) -> str:
    if not isinstance(title, str) or not title.isprintable():
        raise validate.fail("title", "one line of text", title, "put it in quotation marks")
    return title
