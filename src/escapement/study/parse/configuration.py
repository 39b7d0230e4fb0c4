"""The content of a study file, and the plan that it describes."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from escapement.base import units, validate
from escapement.base.errors import InvalidValue
from escapement.base.files import AnyPath
from escapement.base.quantity import Quantity, Setting
from escapement.base.toml_file import read_toml
from escapement.constant_speed.index_case import refuse_with_curve
from escapement.engines.solver import DEFAULT_ENGINE, choose_solver, solver_for, with_engine
from escapement.mechanisms import DEFAULT_KIND, KINDS, kind_of
from escapement.mechanisms.protocol import Mechanism
from escapement.mechanisms.wheel_checks import IMPERFECT, MEASURED, check_lengths
from escapement.model.checks import is_given
from escapement.model.load_curve import Load
from escapement.model.torque_curve import TorqueCurve
from escapement.model.train import check_ratios
from escapement.study.parse.columns import WIDTHS, axis_values
from escapement.study.parse.mechanism_table import part_lists, with_numbers_of_sizes
from escapement.study.parse.sample import sample_columns
from escapement.study.parse.tables import (
    SOLVER,
    Content,
    check_keys,
    chosen_results,
    date_of,
    fixed_values,
    table,
    title_of,
)
from escapement.study.plan import CASE, StudyPlan, settings_of
from escapement.study.subject import ESCAPEMENT, subject_of

MOST_CASES = 10**12


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


def load_tables(path: AnyPath, *apart: str, lone: bool = False) -> tuple[StudyPlan, dict[str, Any]]:
    """The plan of a study file, and tables of it that are not the study's; errors as above.

    lone : whether the file may describe one case, without an axis or a sample.
    """
    content = read_toml(path, "study file")
    try:
        others = {name: table(content, name) for name in apart}
        for name in apart:
            content.pop(name, None)
        if lone and content.keys().isdisjoint(("sweep", "sample")):
            content["sweep"] = {"initial_speed": [content.pop("initial_speed", 0.0)]}
        for curve in (content.get("torque"), content.get("load_curve")):
            if isinstance(curve, dict) and isinstance(curve.get("file"), str):
                # its path is relative to the study file
                curve["file"] = Path(path).parent / curve["file"]
        return parse_plan(content), others
    except InvalidValue as error:
        raise InvalidValue(f"{path}: {error}") from None


def parse_plan(configuration: Mapping[str, Any], mechanism: Mechanism | None = None) -> StudyPlan:
    """Check the content of a study file, and plan it.

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
    content, curve = _with_first_torque(configuration)
    system = validate.choice("units", content.get("units", "SI"), units.SYSTEMS)
    machine, build = {"kind": DEFAULT_KIND, **table(content, "mechanism")}, cast(Any, mechanism)
    if mechanism is None:
        machine = {"kind": validate.choice("mechanism.kind", machine["kind"], tuple(KINDS))}
        build = kind_of(machine["kind"])
        content = with_numbers_of_sizes(content, build, system)
    meshed = build.meshed if mechanism is None else mechanism.meshed
    named = {x for part in ("mechanism", "sweep", "sample") for x in table(content, part)}
    listed = any(name.startswith(IMPERFECT) for name in named)
    counts = build.counts(table(content, "mechanism")) if listed else {}
    subject = subject_of(content)
    every = settings_of(build, meshed, system, subject)
    content, settings = part_lists(content, every, counts)
    check_keys(content, settings)
    given = table(content, "solver")
    parameters = settings.axes
    read = {name: SOLVER[name].read(name, value) for name, value in given.items()}
    solver = choose_solver(None, *map(read.get, SOLVER))
    fixed = fixed_values(content, settings)
    varied, forms, fingerprint = _varied(content, parameters, fixed)
    replaced = [name for along in varied.values() for name in along if _replaces(name, forms)]
    fixed = {name: value for name, value in fixed.items() if name not in replaced}
    plain: dict[str, Any] = {"title": title_of(content, machine["kind"], varied), "units": system}
    plain |= date_of(content)
    plain |= {"study": subject.name} if subject is not ESCAPEMENT else {}
    plain |= {"mechanism": machine} | chosen_results(content)
    for name, value in fixed.items():
        section = settings[name].section
        shown = value.as_table() if isinstance(value, Load) else value
        (plain.setdefault(section, {}) if section else plain)[settings[name].key] = shown
    if curve is not None:
        plain["torque"] = curve.as_table()
        curve = settings["torque"].to_si(curve)
    plain |= forms
    fixed_si = {name: settings[name].to_si(value) for name, value in fixed.items()}
    plan = StudyPlan(
        configuration=plain, build=build, meshed=meshed, parameters=parameters,
        fixed_si=dict.fromkeys(settings) | fixed_si, varied=varied, solver=solver,
        fingerprint=fingerprint, curve=curve,
        replaced=tuple(name for name in replaced if _is_given(settings[name], content)),
    )  # fmt: skip
    if subject is not ESCAPEMENT:
        _check_drives(plan)
    solver = solver_for(plan.contact if subject is ESCAPEMENT else "", solver)
    solver = solver if solver.engine else with_engine(solver, DEFAULT_ENGINE)
    vars(plan)["solver"] = solver  # a copy would convert all columns once more
    if subject is ESCAPEMENT:
        plain["solver"] = solver.given
    values = fixed | {name: column for along in varied.values() for name, column in along.items()}
    check_ratios(values)
    _check_lengths(plan, {n: x for n, x in values.items() if n in parameters or n in counts})
    if plan.cases > MOST_CASES:
        raise InvalidValue(
            f"the grid must have at most {MOST_CASES:.0e} cases, got {plan.cases:.3g}; "
            "shorten an axis"
        )
    return plan


def _check_drives(plan: StudyPlan) -> None:
    """Raise InvalidValue for what many indexing drives cannot be computed with at once."""
    if not plan.perfect:
        raise InvalidValue(
            "the parts of an indexing drive must be perfect in a study, got errors of them; "
            "leave them out"
        )
    if plan.fixed_si.get("load_curve") is not None:
        refuse_with_curve(plan.every("locking_radius"))


def _replaces(name: str, forms: Mapping[str, Any]) -> bool:
    """Whether an axis or a distribution takes the place of a number's fixed value.

    A nominal value around which a sample lies is still part of the study.
    """
    form = forms.get("sample", {}).get(name)
    return not isinstance(form, dict) or WIDTHS.isdisjoint(form)


def _is_given(entry: Setting, content: Content) -> bool:
    """Whether a study gives a fixed value of a setting."""
    return entry.key in table(content, entry.section)


def _check_lengths(plan: StudyPlan, values: Mapping[str, Any]) -> None:
    """Refuse lengths without that of the mechanism, and a factor on a list that has no errors."""
    greatest: dict[str, float] = {}
    for name, value in values.items():
        if name[-1].isdigit():  # a list that varies is identified by its numbers
            name = re.sub(r"_\d+$", "", name)
        if name not in MEASURED:
            continue
        size = float(np.max(np.abs(value), initial=0.0)) if is_given(value) else 0.0
        greatest[name] = max(greatest.get(name, 0.0), size)
    for name in values:
        if name.endswith("_factor") and not greatest.get(of := name.removesuffix("_factor")):
            remedy = f"give {of} under [mechanism], or draw them in [sample]"
            raise validate.fail(name, f"a factor on {of} that are not all 0", "none", remedy)
    check_lengths(greatest, plan.lengths["crank_radius"], plan.build.plain_crank)


def _with_first_torque(content: Content) -> tuple[Content, TorqueCurve | None]:
    """The configuration with a number for the torque, and the torque curve, if there is one.

    The results of a study are those of the torque at the start of the motion.
    """
    given = content.get("torque")
    if not isinstance(given, Mapping | TorqueCurve):
        return content, None
    for name in ("sweep", "sample"):
        if "torque" in table(content, name):
            raise InvalidValue(
                f"torque must be a curve or in [{name}], got both; leave one of them out"
            )
    curve = given if isinstance(given, TorqueCurve) else TorqueCurve.from_table(given)
    return {**content, "torque": curve.at_rest[0]}, curve


def _varied(
    content: Content, parameters: Mapping[str, Quantity], nominal: Mapping[str, Any]
) -> tuple[dict[str, dict[str, Any]], dict[str, Any], str]:
    """Columns along each dimension, their tables as plain JSON, and the sample's fingerprint."""
    varied, forms, fingerprint = {}, {}, ""
    if swept := table(content, "sweep"):
        axes = {name: axis_values(form, parameters[name]) for name, form in swept.items()}
        varied = {name: {name: values} for name, (values, _) in axes.items()}
        forms["sweep"] = {name: plain for name, (_, plain) in axes.items()}
    if "sample" in content:
        drawn = table(content, "sample")
        for name in filter(swept.__contains__, drawn):
            raise InvalidValue(
                f"{name} must be in [sweep] or in [sample], got both; leave one of them out"
            )
        varied[CASE], forms["sample"], fingerprint = sample_columns(drawn, parameters, nominal)
    return varied, forms, fingerprint
