"""Makes a plan from a study file, its content, or a design in Python."""

import re
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.files import AnyPath
from escapement.base.quantity import Numbers, Quantity, Setting, declared
from escapement.base.toml_file import read_toml
from escapement.base.validate import known_keys
from escapement.dynamics.figure_table import FIGURES
from escapement.engines.solver import DEFAULT_ENGINE, Solver, solver_for
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.wheel_checks import IMPERFECT, check_lengths
from escapement.model.escapement import Escapement
from escapement.model.torque_curve import TorqueCurve
from escapement.model.train import ROLES, check_ratios
from escapement.study.elements import part_lists
from escapement.study.plan import StudyPlan, model_numbers, settings_of
from escapement.study.result import DEFAULT
from escapement.study.sizes import with_numbers_of_sizes
from escapement.study.varied import CASE, WIDTHS, axis_values, sample_columns

MOST_CASES = 10**12

_TOP = ("title", "units", "results", "mechanism", "inertia", *ROLES, "sweep", "sample", "solver")
_NUMBERS = declared(Escapement)
_SOLVER = declared(Solver)


def load_plan(path: AnyPath) -> StudyPlan:
    """Read and check a study configuration (TOML).

    Raises
    ------
    MissingInput
        When there is no such file.
    InputFileError
        When it cannot be read or is not TOML; the message has the line.
    InvalidValue
        When a key is unknown, missing, or its value breaks a rule.

    The table [limits], which a budget reads, is left aside.
    """
    return load_tables(path, "limits")[0]


def load_tables(path: AnyPath, *apart: str) -> tuple[StudyPlan, dict[str, Any]]:
    """The plan of a study file, and tables of it that are not the study's; errors as above."""
    content = read_toml(path, "study file")
    try:
        others = {name: _table(content, name) for name in apart}
        for name in apart:
            content.pop(name, None)
        if isinstance(torque := content.get("torque"), dict) and isinstance(
            torque.get("file"), str
        ):
            # its path is relative to the study file
            torque["file"] = Path(path).parent / torque["file"]
        return parse_plan(content), others
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def parse_plan(configuration: Mapping[str, Any], mechanism: Mechanism | None = None) -> StudyPlan:
    """Check a study configuration and make a plan of it.

    Parameters
    ----------
    configuration : Mapping
        The content of a study file, in the units that it names.
    mechanism : Mechanism, optional
        Replaces the [mechanism] table, for mechanisms of the user's own, which no table can
        describe.

    Raises
    ------
    InvalidValue
        For an unknown key, a missing parameter or a value that breaks its rule.
    """
    configuration, curve = _with_first_torque(configuration)
    system = validate.choice("units", configuration.get("units", "SI"), units.SYSTEMS)
    machine_table = _table(configuration, "mechanism")
    machine = {"kind": DEFAULT_KIND, **machine_table}
    build: Any = mechanism
    if mechanism is None:
        machine = {"kind": validate.choice("mechanism.kind", machine["kind"], tuple(KINDS))}
        build = kind_of(machine["kind"])
        configuration = with_numbers_of_sizes(configuration, build, system)
        machine_table = _table(configuration, "mechanism")
    meshed = build.meshed if mechanism is None else mechanism.path.table
    counts = build.counts(machine_table)
    settings: Mapping[str, Setting] = settings_of(build, meshed)
    settings = {name: replace(entry, system=system) for name, entry in settings.items()}
    configuration, settings = part_lists(configuration, settings, counts)
    _check_tables(configuration, settings)
    given = _table(configuration, "solver")
    parameters = {n: e for n, e in settings.items() if isinstance(e, Quantity) and e.axis}
    solver = Solver(**{name: _SOLVER[name].read(name, value) for name, value in given.items()})
    fixed = _fixed(configuration, settings)
    varied, forms, fingerprint = _varied(configuration, parameters, fixed)
    replaced = [name for along in varied.values() for name in along if _replaces(name, forms)]
    fixed = {name: value for name, value in fixed.items() if name not in replaced}
    title = _title(configuration, machine["kind"], varied)
    plain: dict[str, Any] = {"title": title, "units": system, "mechanism": machine}
    plain |= _results(configuration)
    for name, value in fixed.items():
        section = settings[name].section
        (plain.setdefault(section, {}) if section else plain)[settings[name].key] = value
    if curve is not None:
        plain["torque"] = curve.as_table()
        curve = settings["torque"].to_si(curve)
    si = {name: settings[name].to_si(value) for name, value in fixed.items()}
    fixed_si = dict.fromkeys(settings) | si
    plain |= forms
    plan = StudyPlan(
        configuration=plain, build=build, meshed=meshed, parameters=parameters, fixed_si=fixed_si,
        varied=varied, solver=solver, fingerprint=fingerprint, curve=curve,
        replaced=tuple(name for name in replaced if _is_given(settings[name], configuration)),
    )  # fmt: skip
    solver = solver_for("any" if plan.contact else "", solver)
    solver = solver if solver.engine else replace(solver, engine=DEFAULT_ENGINE)
    plain["solver"], plan = solver.given, replace(plan, solver=solver)
    values = fixed | {name: column for along in varied.values() for name, column in along.items()}
    check_ratios(values)
    _check_lengths(plan, {n: value for n, value in values.items() if n in {*parameters, *counts}})
    if plan.cases > MOST_CASES:
        raise InvalidValue(
            f"the grid must have at most {MOST_CASES:.0e} cases, got {plan.cases:.3g}; "
            "shorten an axis"
        )
    return plan


def _replaces(name: str, forms: Mapping[str, Any]) -> bool:
    """Whether an axis or a distribution takes the place of a number's fixed value.

    A nominal value around which a sample lies is still part of the study.
    """
    form = forms.get("sample", {}).get(name)
    return not isinstance(form, dict) or WIDTHS.isdisjoint(form)


def _is_given(entry: Setting, configuration: Mapping[str, Any]) -> bool:
    """Whether a study gives a fixed value of a setting."""
    return entry.key in _table(configuration, entry.section)


def _check_lengths(plan: StudyPlan, values: Mapping[str, Any]) -> None:
    """Refuse lengths without that of the mechanism, and a factor on a list that has no errors."""
    greatest: dict[str, float] = {}
    for name, value in values.items():
        # a list that varies is identified by its numbers
        name = re.sub(r"_\d+$", "", name)
        greatest[name] = max(greatest.get(name, 0.0), float(np.max(np.abs(value), initial=0.0)))
    for name in values:
        of = name.removesuffix("_factor")
        if of != name and not greatest.get(of):
            remedy = f"give {of} under [mechanism], or draw them in [sample]"
            raise validate.fail(name, f"a factor on {of} that are not all 0", "none", remedy)
    check_lengths(greatest, plan.lengths["crank_radius"], plan.build.plain_crank)


def _with_first_torque(
    configuration: Mapping[str, Any],
) -> tuple[Mapping[str, Any], TorqueCurve | None]:
    """The configuration with a number for the torque, and the torque curve, if there is one.

    The results of a study are those of the torque at the start of the motion.
    """
    given = configuration.get("torque")
    if not isinstance(given, Mapping | TorqueCurve):
        return configuration, None
    for name in ("sweep", "sample"):
        if "torque" in _table(configuration, name):
            raise InvalidValue(
                f"torque must be a curve or in [{name}], got both; leave one of them out"
            )
    curve = given if isinstance(given, TorqueCurve) else TorqueCurve.from_table(given)
    return {**configuration, "torque": curve.torque[0]}, curve


def plan_from(
    escapement: Escapement,
    axes: Mapping[str, ArrayLike | Mapping[str, Any]],
    *,
    sample: Mapping[str, Any] | None = None,
    initial_speed: ArrayLike = 0.0,
    results: Sequence[str] | None = None,
    title: str | None = None,
    **solver: Any,
) -> StudyPlan:
    """Plan a study of `escapement` over `axes`.

    Parameters
    ----------
    escapement : Escapement
        The nominal design; an axis replaces its value. Settings that the mechanism chose, such as
        the pins of `Geneva(slots=4)`, are chosen again in each case.
    axes : Mapping
        Name of each axis and its values [SI]: numbers, or start, stop and num.
    sample : Mapping, optional
        Parameters that vary together, at every point of the grid: the [sample] table
        of a study, in SI, spread around the values of `escapement`.
    initial_speed : float or array
        Driver speed at the first pin entry [rad/s], >= 0; an array is the last axis.
    results : sequence of str, optional
        Figures of merit to keep. Default: `result.DEFAULT`.
    title : str, optional
        One line for people.
    **solver : optional
        Fields of `Solver`.

    Raises
    ------
    InvalidValue
        When an argument breaks its rule.
    """
    if not isinstance(escapement, Escapement):
        raise validate.fail("escapement", "an Escapement", escapement, "see escapement.Escapement")
    machine, described = _describe(escapement.mechanism)
    speed, axes = {"initial_speed": initial_speed}, dict(axes)
    if np.ndim(initial_speed) > 0:
        axes, speed = axes | speed, {}
    given = escapement.settings.items()
    numbers = {name: value for name, value in given if value != _NUMBERS[name].default}
    tables = {"mechanism": machine, "inertia": asdict(escapement.inertia), "sweep": axes}
    tables |= {role: asdict(train) for role, train in escapement.trains.items()}
    chosen = {"title": title, "results": results, "sample": sample, "solver": solver}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    return parse_plan(speed | numbers | tables | chosen, mechanism=described)


def _describe(mechanism: Mechanism) -> tuple[dict[str, Any], Mechanism | None]:
    """A mechanism as a [mechanism] table, or the mechanism itself if it is of no known kind."""
    for name in KINDS:
        if type(mechanism) is kind_of(name):
            return {"kind": name} | _chosen(mechanism), None
    # the numbers distinguish two mechanisms with the same repr
    cell = (*mechanism.breaks, mechanism.cell_angle, mechanism.follower_step)
    checksum = zlib.crc32(np.concatenate([mechanism.path.numbers, cell]).tobytes())
    # an address in memory differs from process to process
    text = re.sub(r" at 0x[0-9a-fA-F]+", "", repr(mechanism))
    description = f"{text}, checksum {checksum:08x}"
    return {"kind": type(mechanism).__qualname__, "description": description}, mechanism


def _chosen(mechanism: Any) -> dict[str, Any]:
    """The settings that were given, or that the mechanism would not have chosen by itself."""
    kind = type(mechanism)
    chosen = dict(mechanism.settings)
    for name, setting in declared(kind).items():
        if setting.required or name in mechanism.given:
            continue
        without = {key: value for key, value in chosen.items() if key != name}
        with suppress(InvalidValue):  # there may be no such mechanism without it
            if kind(**without).settings[name] == chosen[name]:
                chosen = without
    return chosen


def _table(configuration: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The sub-table `name`, empty where it is absent; of "" the whole configuration."""
    value = configuration.get(name, {}) if name else configuration
    if not isinstance(value, Mapping):
        raise validate.fail(name, "a table", value, f"write [{name}] on a line of its own")
    return value


def _check_tables(configuration: Mapping[str, Any], settings: Mapping[str, Setting]) -> None:
    """Refuse a study in which nothing varies, and an unknown key, saying where it belongs."""
    machine = {name for name, entry in settings.items() if entry.section == "mechanism"}
    homes: dict[str, str] = {}
    for kind in KINDS:
        for key in (*declared(kind_of(kind)), *kind_of(kind).other_sizes()):
            others = f"{homes[key]} or" if key in homes else "[mechanism] of kind"
            homes[key] = f"{others} {kind!r}"
    for name in model_numbers().keys() - settings.keys():
        slot = "with" if model_numbers()[name].slotted else "without"
        homes[name] = f"a study of a mechanism {slot} a slot"
    homes |= dict.fromkeys(("kind", *machine), "[mechanism]") | dict.fromkeys(_SOLVER, "[solver]")
    homes |= dict.fromkeys(("size", "seed"), "[sample]")
    swept = _table(configuration, "sweep")
    factors = {
        name: f"{name}_factor" for name in IMPERFECT if isinstance(settings.get(name), Numbers)
    }
    homes |= {name: f"[mechanism], and its factor is {axis!r}" for name, axis in factors.items()}
    axes = [name for name, entry in settings.items() if entry.axis]
    known_keys(swept, [*axes, *factors.values()], "in [sweep]", homes)
    kept = ["kind"] if machine else ["kind", "description"]
    keys: dict[str, list[str]] = {"": [*_TOP], "mechanism": kept, "inertia": []}
    keys |= {where: [] for where in ROLES} | {"solver": [*_SOLVER]}
    for name, entry in settings.items():
        keys[entry.section].append(entry.key)
        where = f"[{entry.section}]" if entry.section else "the top level"
        # a number that the mechanism lacks, such as an efficiency, may belong to a train
        key = homes.get(entry.key, where) if entry.section in ROLES else where
        homes |= {name: f"{where} as {entry.key!r}", entry.key: key}
    for section, known in keys.items():
        where = f"in [{section}]" if section else "at the top level"
        known_keys(_table(configuration, section), known, where, homes)
    if not swept and "sample" not in configuration:
        raise InvalidValue(
            "the study must sweep at least one parameter, got none; "
            "add an axis (of a study file under [sweep]), for example friction = [0.2, 0.3]"
        )


def _fixed(configuration: Mapping[str, Any], settings: Mapping[str, Setting]) -> dict[str, Any]:
    """Fixed and nominal values, including defaults; parameters that vary need none."""
    varied = {**_table(configuration, "sweep"), **_table(configuration, "sample")}
    fixed, missing = {}, []
    for name, entry in settings.items():
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


def _varied(
    configuration: Mapping[str, Any], parameters: Mapping[str, Quantity], nominal: Mapping[str, Any]
) -> tuple[dict[str, dict[str, Any]], dict[str, Any], str]:
    """Columns along each dimension, their tables as plain JSON, and the sample's fingerprint."""
    varied, forms, fingerprint = {}, {}, ""
    if swept := _table(configuration, "sweep"):
        axes = {name: axis_values(form, parameters[name]) for name, form in swept.items()}
        varied = {name: {name: values} for name, (values, _) in axes.items()}
        forms["sweep"] = {name: plain for name, (_, plain) in axes.items()}
    if "sample" in configuration:
        drawn = _table(configuration, "sample")
        for name in filter(swept.__contains__, drawn):
            raise InvalidValue(
                f"{name} must be in [sweep] or in [sample], got both; leave one of them out"
            )
        varied[CASE], forms["sample"], fingerprint = sample_columns(drawn, parameters, nominal)
    return varied, forms, fingerprint


def _results(configuration: Mapping[str, Any]) -> dict[str, list[str]]:
    """The figures of merit to keep, if they differ from the default ones."""
    given = configuration.get("results", DEFAULT)
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise validate.fail("results", "a list of names", given, 'for example ["period"]')
    # the status is always kept, and a name that is given twice is kept once
    every = (validate.choice("results", name, (*FIGURES, "status")) for name in given)
    names = [name for name in dict.fromkeys(every) if name != "status"]
    return {"results": names} if names != [*DEFAULT] else {}


def _title(configuration: Mapping[str, Any], kind: str, varied: Mapping[str, Any]) -> str:
    """The title given, or one made from what varies."""
    over = [", ".join(name for name in varied if name != CASE)]
    over += ["a sample of " + ", ".join(varied[CASE])] if CASE in varied else []
    default = f"{kind} escapement over {' and '.join(filter(None, over))}"
    title = configuration.get("title", default)
    if not isinstance(title, str) or not title.isprintable():
        raise validate.fail("title", "one line of text", title, "put it in quotation marks")
    return title
