"""Every number of a study file, a budget's file and a wish acts on a result or is refused.

The numbers of a file are changed one by one, those of lists too.
"""

import copy
import math
import re
from pathlib import Path

import pytest

import escapement as esc
from command_scenes import CHANGED, TOUCHING, motions, write_inputs
from escapement.base.errors import EscapementError
from escapement.dynamics.figure_table import FIGURES, RUN_TIME
from escapement.inverse_design import timer_search
from escapement.inverse_design.requirement import load_requirement
from escapement.mechanisms import KINDS, kind_of
from escapement.study.parse import load_tables
from escapement.study.plan import settings_of
from escapement.study.running import run_plan
from escapement.tolerance.tolerance_budget import budget_of
from test_every_number import alike

pytestmark = pytest.mark.slow


def toml(value):
    """A value as TOML writes it, tables in one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(x)}" for key, x in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)


def write(content):
    path = Path("file.toml")
    path.write_text("".join(f"{key} = {toml(x)}\n" for key, x in content.items()))
    return path


def numbers_in(content, path=()):
    """The places of all numbers and truth values, as keys and indices."""
    if isinstance(content, dict | list | tuple):
        items = content.items() if isinstance(content, dict) else enumerate(content)
        for key, value in items:
            yield from numbers_in(value, (*path, key))
    elif isinstance(content, bool | int | float):
        yield path


def changed(content, path):
    """The content with another value of one number."""
    other = copy.deepcopy(content)
    table = other
    for key in path[:-1]:
        table = table[key]
    value = table[path[-1]]
    by_name = CHANGED.get(path[-1]) if path[0] == "solver" else None
    small = 1e-4 if value == 0.0 else 1.1 * value
    table[path[-1]] = by_name or (
        not value if isinstance(value, bool) else value + 1 if isinstance(value, int) else small
    )
    return other


def tried_in(content, tried=None):
    """The places of the numbers to change; of long lists only some."""
    for path in numbers_in(content):
        names = {key for key in path if isinstance(key, str)}
        if {"theta", "phi"} & names and path[-1] % 29:
            continue
        if tried is None or not tried.isdisjoint(names):
            yield path


def check(content, results_of, exact=(), tried=None):
    """Every number changes what `results_of` gives for a file, or is refused by name.

    If the results have a message, a number that it names as idle need not change them.
    """
    base, wrong = results_of(write(content)), []
    assert alike(results_of(write(content)), base)
    paths = [*tried_in(content, tried)]
    for path in paths:
        names = [key for key in path if isinstance(key, str)]
        try:
            found = results_of(write(changed(content, path)))
        except EscapementError as error:
            said, table = str(error), content[path[0]]
            beside = table if isinstance(table, dict) else ()
            if "\n" in said or not any(name in said for name in (*names, *beside)):
                wrong.append(f"{path}: {said}")
            continue
        same = found == base if path[0] in exact else alike(found, base)
        if same and not re.search(rf"{names[-1]}\w* has no effect", base.get("message", "")):
            wrong.append(f"{path}: silent")
    assert paths
    assert "\n".join(wrong) == ""


def results_of_study(path):
    plan = esc.load_plan(path)
    study = run_plan(plan)
    found = {**study.results, **study.axes, **study.sampled}
    return {name: x.tolist() for name, x in found.items() if name != "case"} | {
        "message": f"{plan.idle}; {plan.unused}"
    }


def content_of(kind, scene, varied):
    """A study file of a scene of the command line, which varies one of its numbers."""
    build = kind_of(kind)
    entries = settings_of(build, build.meshed)
    sizes = {name: size.entry for name, size in build.other_sizes().items()}
    results = [name for name in FIGURES if name != RUN_TIME]  # which needs a number of turns
    content = {"results": results, "mechanism": {"kind": kind}}
    for name, value in scene.items():
        if name == "table":
            cell = esc.Tabulated.from_csv(value, measured=scene.get("measured", False))
            content["mechanism"] |= {"theta": [*cell.theta], "phi": [*cell.phi]}
        entry = (entries | sizes).get(name)
        if entry is None or name in varied:
            continue
        if isinstance(value, str) and "," in value:
            value = [*map(float, value.split(","))]
        if entry.unit == "angle" and not isinstance(value, list):
            value = math.radians(value)
        (content.setdefault(entry.section, {}) if entry.section else content)[entry.key] = value
    return content | {"sweep": varied}


def scenes_of(kind):
    """Study files in which every number acts, and the names to try where not all are."""
    # flat pallets, the last scene of a runaway, stall with these inertias
    for k, scene in enumerate(motions(kind, {})[: 2 if kind in TOUCHING else None]):
        varied = {"load_torque": [2e-4]} if k == 0 else {"initial_speed": [1.0]}
        content = content_of(kind, scene, varied)
        tried = scene.get("tried")
        entries = settings_of(kind_of(kind), kind_of(kind).meshed)
        yield content, tried and {entries[n].key if n in entries else n for n in tried}


# a study gives the chains of outlines as rows of numbers, and the command line a drawing
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "outlines"])
def test_every_number_of_a_study_acts_or_is_refused(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_inputs("sweep", kind)
    for content, tried in scenes_of(kind):
        check(content, results_of_study, tried=tried)


NUMBERS = {
    "torque": 0.0113, "friction": 0.2, "load_torque": 1e-4, "results": ["period", "rise_time"],
    "inertia": {"driver": 1e-6, "follower": 5e-6},
    "mechanism": {"slots": 6, "pins": 2, "crank_radius": 0.02, "pin_radius": 0.001},
}  # fmt: skip
AROUND = {
    "friction": {"relative_tolerance": 0.1},
    "torque": {"standard_deviation": 1e-3, "low": 0.0111, "high": 0.0115},
    "load_torque": {"relative_standard_deviation": 0.1, "low": 0.9e-4, "high": 1.1e-4},
    "driver_inertia": {"log_standard_deviation": 0.1, "low": 0.9e-6, "high": 1.1e-6},
    "follower_inertia": {"low": 4e-6, "high": 6e-6, "log": True},
    "pin_radius": {"tolerance": 1e-4},
}
"""Every form of a distribution."""
DRAWN = {"method": "random", "size": 6, "seed": 1, "correlations": [["friction", "torque", 0.5]]}
FILES = {
    "axes": NUMBERS | {"sweep": {
        "friction": {"start": 0.1, "stop": 0.2, "num": 2},
        "torque": {"start": 0.01, "stop": 0.02, "num": 3, "log": True},
        "slots": [6, 8], "load_torque": [1e-4],
    }},
    "sample": NUMBERS | {"sample": {**DRAWN, **AROUND}},
    "hypercubes": NUMBERS | {"sample": {
        "method": "latin-hypercube", "size": 12, "hypercubes": 2, "friction": AROUND["friction"],
    }},
    "list": NUMBERS | {"sample": {
        "method": "list", "friction": [0.1, 0.2], "torque": [0.01, 0.02],
    }},
    "errors": NUMBERS | {
        "mechanism": {**NUMBERS["mechanism"], "slot_offsets": [0.0, 0.0, 1e-5, 0.0, 0.0, 0.0]},
        "sweep": {"slot_offsets_factor": [0.0, 1.0]},
    },
}  # fmt: skip
"""Study files with every form of an axis and of a distribution."""


@pytest.mark.parametrize("name", FILES)
def test_every_number_of_an_axis_or_a_sample_acts_or_is_refused(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check(FILES[name], results_of_study)


def test_every_number_of_a_solver_acts_or_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    solver = {"engine": "ivp", "rtol": 1e-6, "atol": 1e-9, "max_step": 0.01}
    content = NUMBERS | {"results": ["period"], "solver": solver, "sweep": {"friction": [0.2]}}
    check(content, results_of_study, exact=("solver",), tried={*solver})


def results_of_motion(path):
    """Of a case as `run --from` gives it."""
    motion = esc.simulate(esc.load_plan(path).escapement(0), 6)
    return {"handoffs": motion.handoff_times.tolist(), "speeds": motion.handoff_velocities.tolist()}


def test_every_number_of_a_torque_curve_acts_or_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    curve = {"angle": [0.0, 1.0, 2.0, 3.0], "torque": [0.01, 0.012, 0.011, 0.01], "periodic": True}
    content = NUMBERS | {"torque": curve, "sweep": {"friction": [0.2]}}
    check(content, results_of_motion, tried={"torque"})
    plan = esc.load_plan(write(content))
    assert "the torque behind the start has no effect on results" in plan.idle


def results_of_budget(path):
    plan, tables = load_tables(path, "limits")
    found = budget_of(plan, tables["limits"])
    figures = {name: vars(scatter) for name, scatter in found.figures.items()}
    return figures | {"failed": [*found.failed], "message": plan.unused}


def test_every_number_of_a_budget_acts_or_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    forms = {name: AROUND[name] for name in ("friction", "torque", "follower_inertia")}
    sample = {"method": "random", "size": 100, "seed": 1, **forms}
    limits = {"period": [0.006, 0.0065]}
    content = NUMBERS | {"results": ["period"], "sample": sample, "limits": limits}
    check(content, results_of_budget)


WISH = {
    "period": 0.05, "torque": 0.01, "slots": [4, 5], "friction": [0.2, 0.3], "pin": 0.05,
    "crank_radius": [0.005, 0.02], "inertia_ratio": [0.05, 5.0], "density": 7850.0,
    "objectives": ["scatter", "contact_force_max"], "internal": False,
}  # fmt: skip
RUN_DOWN = {"total_time": 5.0, "turns": 20.0, "torque_lost": 0.1, "torque": [0.01, 0.02]}
LOSSES = {
    "driver_thickness": 0.003, "follower_thickness": [0.001, 0.003], "roller_radius": 0.0012,
    "driver_drag": 1e-10, "follower_drag": 1e-9, "driver_bearing_torque": 1e-4,
    "driver_bearing_radius": 0.001, "driver_bearing_friction": 0.1,
    "follower_bearing_radius": 0.001, "follower_bearing_friction": 0.1,
}  # fmt: skip
MOST = "scatter", "contact_force_max", "size", "mass", "rise_time_98"
BOTH = "driver_inertia", "follower_inertia", "driver_thickness", "follower_thickness"
BOUNDS = {
    **dict.fromkeys(MOST, 100.0), **{name: [1e-9, 1.0] for name in BOTH},
    "thinnest_wall": 1e-9, "jam_margin": 1e-3,
}  # fmt: skip
"""Bounds within which every design lies."""


def results_of_wish(path):
    """What `design` finds, with fewer points and steps than it has by itself."""
    found = esc.design(load_requirement(path)[0], count=4)
    values = [one.values | {"torque": one.timer.torque} for one in found.designs]
    return {"values": values, "message": found.message}


@pytest.fixture
def short_search(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, small in {"SAMPLE": 5, "_STEPS": 2}.items():
        monkeypatch.setattr(timer_search, name, small)


def test_every_number_of_a_wish_acts_or_is_refused(short_search):
    check(WISH, results_of_wish)
    without = {name: x for name, x in WISH.items() if name != "period"} | {"slots": 4}
    check(without | RUN_DOWN, results_of_wish, tried={*RUN_DOWN})
    lossy = {"slots": 4, "inertia_ratio": [0.01, 10.0], "torque": [0.001, 0.1]} | LOSSES
    check(WISH | lossy, results_of_wish, tried={*LOSSES})


def test_every_bound_of_a_wish_excludes_designs(short_search):
    """An end that excludes every design of the nearest ones is named."""
    content = WISH | {"slots": 4}
    assert results_of_wish(write(content | {"bounds": BOUNDS}))["values"]
    for name, bound in BOUNDS.items():
        ends = [[1e-9, 1e-8], [0.99, 1.0]] if name in BOTH else [1e-8 if name in MOST else 0.999]
        for end in ends:
            found = results_of_wish(write(content | {"bounds": BOUNDS | {name: end}}))
            assert not found["values"], (name, end)
            assert name in found["message"]
        assert bound != end
