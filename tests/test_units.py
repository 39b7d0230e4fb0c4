"""Numbers with their units: exact, refused in one line, and the same wherever they are typed."""

import json
import math
import re
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from escapement.base.errors import InvalidValue
from escapement.base.spoken import as_spoken
from escapement.base.units import (
    INCH,
    INCH_POUND,
    POUND_FORCE,
    SYSTEMS,
    factor,
    measured,
    printed,
    unit_name,
)
from escapement.study.parse import load_plan, parse_plan

KINDS = (
    *("torque", "inertia", "length", "force", "power", "drag", "viscous", "speed"),
    *("acceleration", "time", "angle", "degrees", "energy"),
)


def si(text, kind):
    return measured("it", text, kind, "SI", "do that")


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        *((text, "torque", 0.005) for text in ("5 mN m", "5mNm", "5 mN*m", "5 mN·m", "5e0 N mm")),
        *((text, "inertia", 35e-7) for text in ("35 g cm2", "35 g*cm^2", "35 gcm²", "3.5 kg mm2")),
        *((text, "speed", 3.0) for text in ("3 rad/s", "3 rad s-1", "3 rad s⁻¹", "0.003 rad/ms")),
        *((text, "angle", math.pi / 6.0) for text in ("30 deg", "30°", "30 degree")),
        ("60 rpm", "speed", 2.0 * math.pi),
        ("1 rev/min", "speed", math.pi / 30.0),
        ("2 in", "length", 0.0508),
        ("−2 µm", "length", -2e-6),
        ("1 lbf", "force", 4.4482216152605),
        ("1 kgf", "force", 9.80665),
        ("16 ozf-in", "torque", 0.1129848290276167),
        ("1 lb in2", "inertia", 0.45359237 * 0.0254**2),
        ("0.1 in-lbf-s^2", "inertia", 0.01129848290276167),
        ("5 N m s²/rad²", "drag", 5.0),
        ("30 %", "ratio", 0.3),
    ],
)
def test_a_number_with_its_unit_is_exact(text, kind, value):
    assert si(text, kind) == pytest.approx(value, rel=3e-16)


@given(st.floats(1e-9, 1e9), st.sampled_from(["mN m", "N mm", "kN um"]))
def test_prefixes_move_the_decimal_point_and_nothing_else(number, unit):
    assert si(f"{number!r} {unit}", "torque") == float(Decimal(repr(number)) / 1000)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_the_package_writes_may_be_typed(kind, system):
    for name in (printed(kind, system), unit_name(kind, system)):
        assert measured("it", f"0.7 {name}", kind, system, "") == 0.7
    scale = factor(kind, system)
    assert si(f"1 {unit_name(kind, system)}", kind) * factor(kind, "SI") == pytest.approx(scale)


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("5 N", "in N m or a unit of the same kind"),
        ("5 N m/rad", "in N m or a unit of the same kind"),
        ("5 kg m2", "in N m or a unit of the same kind"),
        ("5 Newton", "in a known unit ('ewton' is no unit)"),
        ("0,1", "a number with a decimal point"),
        ("0,1 N m", "a number with a decimal point"),
        ("N m", "a finite number"),
    ],
)
def test_a_refusal_names_the_unit_that_is_wanted(text, rule):
    with pytest.raises(InvalidValue) as caught:
        si(text, "torque")
    said, _, remedy = str(caught.value).partition("; ")
    assert said == f"it must be {rule}, got {text!r}"
    assert remedy == (f"write {text.replace(',', '.')!r}" if "," in text else "do that")


STUDY = """
units = "{system}"
torque = {torque}
initial_speed = "60 rpm"
[mechanism]
slots = 4
crank_radius = {radius}
[inertia]
driver = {driver}
follower = "35 g cm2"
[solver]
engine = "ivp"
max_step = "2 ms"
[sweep]
pin_radius = ["1 mm", {pin}]
follower_bearing_radius = {{ start = {start}, stop = "2 mm", num = 3 }}
[sample]
method = "sobol"
size = 2
friction = {{ low = "20 %", high = 0.3 }}
load_torque = {{ tolerance = "1 mN m" }}
driver_inertia = {{ relative_tolerance = "5 %" }}
"""
TYPED = ('"5 mN m"', '"20 mm"', '"0.3 kg mm2"', '"1.5 mm"', '"0 mm"')
BARE = (0.005, 0.02, 3e-7, 0.0015, 0.0)


def plan_of(tmp_path, system, values):
    names = ("torque", "radius", "driver", "pin", "start")
    text = STUDY.format(system=system, **dict(zip(names, values, strict=True)))
    text = text.replace("[mechanism]", 'load_torque = "2 mN m"\n[mechanism]')
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    return load_plan(tmp_path / "s.toml")


def test_a_study_takes_units_everywhere(tmp_path):
    bare, typed, inches = (
        plan_of(tmp_path, system, values)
        for system, values in (("SI", BARE), ("SI", TYPED), ("in-lbf-s", TYPED))
    )
    assert typed.configuration == bare.configuration
    assert parse_plan(json.loads(json.dumps(typed.configuration))).configuration
    assert typed.solver.max_step == 0.002
    for case in range(typed.cases):
        assert typed.values(case) == bare.values(case)
        for name, value in inches.values(case).items():
            wanted = typed.values(case)[name]
            assert value == (wanted and pytest.approx(wanted, rel=1e-14)), name


@pytest.mark.parametrize(
    ("text", "kind", "si"),
    [
        ("10 oz-in", "torque", 10 * INCH * POUND_FORCE / 16),
        ("10 ozf-in", "torque", 10 * INCH * POUND_FORCE / 16),
        ("2 lb-in", "torque", 2 * INCH_POUND),
        ("2 in-lb", "torque", 2 * INCH_POUND),
        ("2 in lbs", "torque", 2 * INCH_POUND),
        ("1 ft-lb", "torque", 12 * INCH_POUND),
        ("3 kg cm", "torque", 3 * 9.80665 * 0.01),
        ("7 g mm", "torque", 7 * 9.80665e-6),
        ("1000 dyn cm", "torque", 1e-4),
        ("2 oz-in/rad", "rate", 2 * INCH * POUND_FORCE / 16),
        ("5 lb/in", "stiffness", 5 * POUND_FORCE / INCH),
        ("0.01 oz-in-s2", "inertia", 0.01 * INCH_POUND / 16),
        ("35 g cm2", "inertia", 35e-7),
        ("2 lb in2", "inertia", 2 * 0.45359237 * INCH**2),
        ("7850 kg/m3", "density", 7850.0),
    ],
)
def test_weights_are_read_as_forces_where_a_force_is_asked_for(text, kind, si):
    assert measured("x", text, kind, "SI", "") == pytest.approx(si, rel=1e-15)


def test_the_command_line_takes_units(command):
    bare = ["--torque", "0.005", "--driver-inertia", "3e-7", "--follower-inertia", "35e-7"]
    typed = ["--torque", "5 mN m", "--driver-inertia", "0.3 kg mm2", "--follower-inertia=35 g cm2"]
    rest = ["--friction", "30 %", "--duration", "50 ms", "--json"]
    records = [json.loads(command("run", *given, *rest)[1]) for given in (bare, typed)]
    assert records[0] == records[1]
    # a unit of its own counts whatever the others are in, and wherever those are named
    inches = json.loads(command("run", "--units", "in-lbf-s", *typed, *rest)[1])
    assert inches["inputs"]["torque"]["SI"] == pytest.approx(0.005, rel=1e-15)
    assert inches["period"] == pytest.approx(records[0]["period"], rel=1e-12)


def test_an_angle_in_degrees_may_come_in_radians(command, tmp_path):
    for name, angle in (("a", "-20"), ("b", "-20 deg"), ("c", f"{math.radians(-20.0)} rad")):
        assert command("mechanism", "--plot", f"{name}.svg", "--angle", angle)[0] == 0
    first, *others = (path.read_bytes() for path in sorted(tmp_path.glob("*.svg")))
    assert others == [first, first]


def test_the_command_line_refuses_a_wrong_unit(refusal):
    said = refusal(2, "run", "--torque", "5 kg", "--units", "in-lbf-s")
    assert "--torque must be in in-lbf or a unit of the same kind, got '5 kg'; give the" in said
    assert "--friction must be a number with a decimal point, got '0,35'; write '0.35'" in refusal(
        2, "run", "--friction", "0,35"
    )
    assert "--torque must be greater than 0, got '-5 mN m'" in refusal(
        2, "run", "--torque", "-5 mN m"
    )


def test_messages_speak_the_users_system(command):
    sizes = ["--slots", "4", "--pins", "1", "--crank-radius", "1", "--pin-radius", "0.9"]
    for system, unit in (("SI", "m"), ("in-lbf-s", "in")):
        code, _, err = command("mechanism", *sizes, "--units", system)
        assert code == 2
        assert re.search(rf"less than [\d.]+ {unit}, where .* got 0.9 {unit};", err), err
    assert as_spoken(0.0254, "length") == "0.0254 m"
