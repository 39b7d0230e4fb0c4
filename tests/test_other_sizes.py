"""Sizes in place of a mechanism's own numbers: one of them, converted, on both ways in."""

import json
import math

import pytest

import escapement as esc
from escapement.base.errors import InvalidValue, UnknownArgument
from escapement.base.quantity import declared
from escapement.cli import main
from escapement.mechanisms import KINDS, kind_of
from escapement.study.parse import parse_plan

SINE, TANGENT = math.sin(math.pi / 6), math.tan(math.pi / 5)
# what is given, and what it says in the package's own numbers
SAME = [
    ({"slots": 6, "centre_distance": "60 mm"}, {"slots": 6, "crank_radius": 0.06 * SINE}),
    ({"slots": 5, "wheel_radius": "25 mm"}, {"slots": 5, "crank_radius": 0.025 * TANGENT}),
    ({"slots": 5, "wheel_diameter": 0.05}, {"slots": 5, "crank_radius": 0.025 * TANGENT}),
    (
        {"slots": 5, "wheel_radius": 0.025, "pin_diameter": "4 mm", "clearance": "0.2 mm"},
        {
            "slots": 5, "pin_radius": 0.002, "clearance": 2e-4,
            "crank_radius": math.sqrt(0.025**2 - 0.0021**2) * TANGENT,
        },
    ),
    (
        {"slots": 4, "crank_diameter": 0.04, "pin_radius": 1e-3, "roller_diameter": 0.003},
        {"slots": 4, "crank_radius": 0.02, "pin_radius": 1e-3, "roller_radius": 0.0015},
    ),
    (
        {"slots": 6, "internal": True, "pins": 1, "centre_distance": 0.03},
        {"slots": 6, "internal": True, "pins": 1, "crank_radius": 0.03 * SINE},
    ),
    (
        {"kind": "gear-driven", "stations": 12, "lobes": 3, "curve": "hypocycloid",
         "fixed_diameter": "60 mm", "pin_diameter": "1 mm"},
        {"kind": "gear-driven", "stations": 12, "lobes": 3, "curve": "hypocycloid",
         "fixed_radius": 0.03, "pin_radius": 5e-4},
    ),
    (
        {"kind": "elliptical-planetary", "sun_diameter": 0.032, "planet_diameter": 0.018},
        {"kind": "elliptical-planetary", "sun_radius": 0.016, "planet_radius": 0.009},
    ),
]  # fmt: skip
IDS = ["-".join(given) for given, _ in SAME]
MODEL = ["--torque", "0.01", "--driver-inertia", "1e-6", "--follower-inertia", "1e-6"]


def words_of(table):
    words = []
    for name, value in table.items():
        if name != "kind":
            words.append(f"--{name.replace('_', '-')}")
        words += [] if value is True else [str(value)]
    return words


def study_of(table, **changes):
    study = {"mechanism": table, "inertia": {"driver": 1e-6, "follower": 1e-6}, "torque": 0.01}
    return study | {"sweep": {"load_torque": [0.0]}} | changes


@pytest.mark.parametrize(("given", "own"), SAME, ids=IDS)
def test_the_command_line_converts_and_echoes(given, own, capsys):
    assert main(["run", *words_of(given), *MODEL, "--engagements", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["inputs"]
    for name, value in own.items():
        found = told[name]["SI"] if isinstance(told[name], dict) else told[name]
        same = str(value) if name in ("kind", "curve", "lobes") else pytest.approx(value, rel=1e-14)
        assert found == same
    assert main(["mechanism", *words_of(given), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    for name in ("wheel_radius", "centre_distance"):
        if name in given:  # the command prints what was typed
            typed = float(str(given[name]).removesuffix(" mm"))
            typed *= 1e-3 if "mm" in str(given[name]) else 1.0
            assert told[name] == pytest.approx(typed, rel=1e-14)


@pytest.mark.parametrize("units", ["SI", "in-lbf-s"])
@pytest.mark.parametrize(("given", "own"), SAME, ids=IDS)
def test_a_study_file_converts(given, own, units):
    inch = 1.0 if units == "SI" else 0.0254

    def in_units(table):
        return {
            name: value / inch if isinstance(value, float) else value
            for name, value in table.items()
        }

    plan = parse_plan(study_of(in_units(given), units=units))
    same = parse_plan(study_of(in_units(own), units=units))
    assert plan.escapement(0).mechanism.kind == own.get("kind", "geneva")
    one, other = (p.escapement(0).mechanism for p in (plan, same))
    for name in declared(type(one)):
        value, expected = getattr(one, name), getattr(other, name)
        assert value == (pytest.approx(expected, rel=1e-14) if type(value) is float else expected)


def test_every_radius_of_every_kind_has_a_diameter():
    for kind in map(kind_of, KINDS):
        radii = [n for n in kind.options() if n.endswith("_radius") and n != "wheel_radius"]
        assert {n.replace("_radius", "_diameter") for n in radii} <= {*kind.other_sizes()}


CONFLICTS = [
    ({"slots": 6, "centre_distance": 0.06, "crank_radius": 0.03},
     "centre_distance must not come with crank_radius, got both"),
    ({"slots": 5, "wheel_radius": 0.025, "centre_distance": 0.03},
     "wheel_radius must not come with centre_distance, got both"),
    ({"slots": 5, "crank_radius": 0.02, "pin_radius": 1e-3, "pin_diameter": 2e-3},
     "pin_diameter must not come with pin_radius, got both"),
    ({"slots": 5, "wheel_radius": 1e-3, "pin_radius": 2e-3},
     "wheel_radius must be greater than half the width of a slot, 0.002 m, got 0.001"),
    ({"slots": 5, "wheel_radius": -1.0}, "wheel_radius must be greater than 0"),
    ({"kind": "gear-driven", "stations": 12, "lobes": 3, "curve": "hypocycloid",
      "wheel_radius": 0.02}, "wheel_radius"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "said"), CONFLICTS)
def test_a_conflict_is_one_line_on_both_ways_in(given, said, capsys):
    assert main(["mechanism", *words_of(given)]) == 2
    err = capsys.readouterr().err
    assert said in err.replace("--", "").replace("wheel-radius", "wheel_radius")
    assert err.count("\n") == 1
    with pytest.raises(InvalidValue, match=said):
        parse_plan(study_of(given))


def test_a_size_is_refused_where_its_conversion_varies():
    for swept, given in (
        ({"slots": [4, 5]}, {"centre_distance": 0.06}),
        ({"pin_radius": [1e-3, 2e-3]}, {"slots": 5, "wheel_radius": 0.03}),
    ):
        name = next(iter(swept))
        with pytest.raises(InvalidValue, match=f"must be left out where {name} varies, got .*give"):
            parse_plan(study_of(given, sweep=swept))
    with pytest.raises(InvalidValue, match="centre_distance must be together with one number of"):
        parse_plan(study_of({"centre_distance": 0.06}))
    with pytest.raises(
        InvalidValue, match=r"unknown key 'pin_diameter' in \[sweep\]; it belongs in"
    ):
        parse_plan(study_of({"slots": 4, "crank_radius": 0.02}, sweep={"pin_diameter": [1e-3]}))


def test_python_says_how_to_give_them():
    with pytest.raises(UnknownArgument, match=r"give crank_radius, or Geneva\.from_options"):
        esc.Geneva(6, centre_distance=0.06)
    assert esc.Geneva.from_options(slots=6, centre_distance=0.06) == esc.Geneva(
        6, crank_radius=0.06 * math.sin(math.pi / 6)
    )
    with pytest.raises(UnknownArgument, match="did you mean 'crank_radius'"):
        esc.Geneva(6, cronk_radius=0.06)
