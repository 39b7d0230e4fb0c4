"""Designs side by side: similarity, shares, sensitivities, and the command."""

import json
import math
from dataclasses import replace

import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.cli import main
from escapement.model.numbers import numbers_of, with_number
from escapement.model.similar import similar

TIMER = esc.Escapement(
    esc.Geneva(4, crank_radius=0.0127), esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.3,
    driver_drag=1e-9, follower_viscous=1e-7, driver_bearing_torque=1e-4, load_torque=1e-4,
)  # fmt: skip
PLAIN = esc.Escapement(TIMER.mechanism, TIMER.inertia, TIMER.torque, friction=0.3)
OTHER = replace(
    TIMER, mechanism=esc.Geneva(6, crank_radius=0.02), inertia=esc.Inertia(1e-6, 2e-6), friction=0.2
)


def test_similar_escapements_have_the_same_motion_in_another_time():
    one, other = esc.terminal(TIMER), esc.terminal(similar(TIMER, 3.0, 0.5))
    assert other.period == pytest.approx(0.5 * one.period, rel=1e-12)
    assert other.velocity_max == pytest.approx(2.0 * one.velocity_max, rel=1e-12)
    assert other.contact_force_max == pytest.approx(3.0 * one.contact_force_max, rel=1e-12)
    assert other.jam_margin == pytest.approx(one.jam_margin, rel=1e-12)


def test_similarity_takes_trains_curves_and_motors_along():
    barrel = esc.Train(4.0, inertia=1e-6)
    curve = esc.TorqueCurve((0.0, 5.0, 10.0), (0.05, 0.04, 0.05), periodic=True)
    timer = replace(TIMER, barrel=barrel, torque=curve, load_torque=0.0)
    one, other = esc.simulate(timer, 6), esc.simulate(similar(timer, 3.0, 0.5), 6)
    assert other.end_time == pytest.approx(0.5 * one.end_time, rel=1e-11)
    motor = replace(TIMER, no_load_speed=400.0)
    assert esc.terminal(similar(motor, 3.0, 0.5)).period == pytest.approx(
        0.5 * esc.terminal(motor).period, rel=1e-11
    )


@pytest.fixture(scope="module")
def own():
    return esc.compare(PLAIN, OTHER)


def test_designs_at_one_clock_keep_what_similarity_keeps(own):
    scaled = esc.compare(PLAIN, OTHER, equal_period=True)
    for one in scaled:
        assert one.values["period"] == pytest.approx(own[0].values["period"], rel=1e-12)
        assert one.values["torque"] == pytest.approx(PLAIN.torque, rel=1e-12)
    kept = ("turn_deg", "friction_share", "period_by_friction", "period_by_torque")
    for name in kept:
        assert scaled[1].values[name] == pytest.approx(own[1].values[name], rel=1e-7)
    assert own[0].name == "geneva 1"


def test_what_is_compared_is_what_differences_and_ledger_say(own):
    one, _ = own
    step = 1e-4

    def slope(less, more, width=2.0 * step):
        ends = [math.log(esc.terminal(timer).period) for timer in (less, more)]
        return (ends[1] - ends[0]) / width

    for name in ("torque", "friction", "driver_inertia", "follower_inertia"):
        value = numbers_of(PLAIN)[name]
        both = (with_number(PLAIN, name, (1.0 + way * step) * value) for way in (-1.0, 1.0))
        assert one.values[f"period_by_{name}"] == pytest.approx(slope(*both), abs=1e-6)
    apart = PLAIN.mechanism.centre_distance * 0.0127
    for way, key in ((1.0, ""), (-1.0, "shorter_")):
        # the period bends strongly here, so that the step is short
        share = way * 1e-7
        moved = replace(PLAIN.mechanism, centre_distance_error=share * apart)
        found = slope(PLAIN, replace(PLAIN, mechanism=moved), share)
        told = one.values[f"period_by_{key}centre_distance"]
        assert math.isnan(told) or told == pytest.approx(found, rel=2e-3)
    ledger = one.figures.motion.ledger
    assert one.values["friction_share"] == pytest.approx(ledger.friction / ledger.work)
    assert one.values["friction_share"] == pytest.approx(1.0)
    assert one.values["blow_share"] == 0.0
    assert one.reasons["period_with_rebound"] == "pins fit their slots exactly, without blows"
    missing = {name for name, value in one.values.items() if math.isnan(value)}
    assert missing - {"period_by_shorter_centre_distance"} == {*one.reasons}


def test_a_friction_of_zero_and_a_wheel_without_a_size_are_told():
    bare = esc.Escapement(esc.Geneva(4), TIMER.inertia, TIMER.torque, driver_drag=1e-9)
    one, _ = esc.compare(bare, bare)
    assert one.reasons["period_by_friction"] == "there is no friction in the contact"
    assert "its size" in one.reasons["period_by_centre_distance"]
    assert one.reasons["contact_force_max"] == "a force needs a crank_radius"
    with pytest.raises(InvalidValue, match="escapements must be two or more designs, got 1"):
        esc.compare(TIMER)
    with pytest.raises(InvalidValue, match="design 2 must have a terminal cycle"):
        esc.compare(TIMER, replace(TIMER, friction=0.9))


DESIGN = """
torque = 0.0113
friction = {friction}
[mechanism]
slots = 4
crank_radius = 0.0127
[inertia]
driver = 3.39e-7
follower = 5.65e-6
"""
TOLERANCES = """
[sample]
method = "random"
size = 200
friction = { tolerance = 0.05 }
[limits]
period = { relative_tolerance = 0.02 }
"""


def test_the_command_tells_each_design_and_its_yield(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text(DESIGN.format(friction=0.3))
    (tmp_path / "b.toml").write_text(DESIGN.format(friction=0.2) + TOLERANCES)
    files = ["a.toml", "b.toml"]
    assert main(["compare", *files, "--equal-period", "--json", "--plot", "out.png"]) == 0
    told = json.loads(capsys.readouterr().out)
    one, other = told["designs"]
    assert [one["design"], other["design"]] == ["a", "b"]
    assert other["period"] == pytest.approx(one["period"], rel=1e-12)
    assert 0.05 < other["yield_period"] < 1.0
    assert one["contact_force_max_in_blows"] is None
    assert "a: no acceleration_max_in_blows" in told["message"]
    assert (tmp_path / "out.png").exists()
    assert main(["compare", *files]) == 0
    out = capsys.readouterr().out
    assert "period by friction" in out
    assert " b" in out.splitlines()[out.splitlines().index("") + 1] or " b" in out


def test_the_command_takes_a_stiffness(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sizes = "crank_radius = 0.0127\npin_radius = 0.001\nclearance = 2e-5"
    for name, friction in (("a.toml", 0.3), ("b.toml", 0.2)):
        text = DESIGN.format(friction=friction).replace("crank_radius = 0.0127", sizes)
        (tmp_path / name).write_text(text)
    assert main(["compare", "a.toml", "b.toml", "--stiffness", "1e6", "--json"]) == 0
    for one in json.loads(capsys.readouterr().out)["designs"]:
        assert one["contact_force_max_in_blows"] > one["contact_force_max"]


def test_a_study_of_several_cases_is_no_design(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(DESIGN.format(friction=0.3) + "[sweep]\nload_torque = [0.0, 1e-4]\n")
    assert main(["compare", str(path), str(path)]) == 2
    err = capsys.readouterr().err
    assert "a design to compare must be one case, got 2; leave [sweep] out" in err
    assert err.count("\n") == 1
