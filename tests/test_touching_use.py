"""What a user does with bodies that touch anywhere: commands, pages, studies, designs, refusals."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from command_scenes import WHEELS, argv_of
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from test_touching_kinds import VERGES

VERGE = esc.Runaway(
    teeth=12, wheel_radius=1.0, tooth_depth=0.22, lead=math.radians(45), back=math.radians(15),
    tip_radius=0.01, span=2.5, pallet_radius=1.02, pin_radius=0.05,
)  # fmt: skip
LOAD = esc.LoadCurve((0.0, 3.0, 2.0 * math.pi), (0.1, 0.2, 0.1))

BODIES = ("--torque", 1.0, "--driver-inertia", 1.0, "--follower-inertia", 0.3)


def test_a_motion_is_drawn_and_played_and_angles_are_told_in_degrees(command):
    argv = argv_of("run", "runaway", WHEELS["runaway"])[1:]
    code, out, err = command("run", *argv, *BODIES, "--engagements", 2, "-o", "m.h5", "--json")
    assert code == 0, err
    assert json.loads(out)["inputs"]["lead_deg"] == 45.0
    for name in ("m.png", "m.html"):
        assert command("plot", "m.h5", "-o", name)[0] == 0
    told = re.search(r'id="data">(.*?)</script>', Path("m.html").read_text("utf-8"), re.DOTALL)
    played = json.loads(told[1])["motion"]
    assert (played["entry"], played["touching"], played["meshed"]) == (0.0, True, False)
    numbers = {name: value for name, value in WHEELS["runaway"].items() if name != "lead"}
    lines = [f"{name} = {value}" for name, value in numbers.items()]
    study = ["torque = 1.0", "[mechanism]", 'kind = "runaway"', *lines, "[inertia]"]
    study += ["driver = 1.0", "follower = 0.3", "[sweep]", "lead = [44, 45]"]
    Path("s.toml").write_text("\n".join(study))
    code, out, err = command("sweep", "s.toml", "--json", "--quiet")
    assert code == 0, err
    inputs = json.loads(out)["inputs"]
    assert inputs["lead_deg"] == pytest.approx([44.0, 45.0])
    assert inputs["back_deg"] == pytest.approx(15.0)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"pin_length": 0.1}, "stresses are told of pins in straight slots"),
        ({"barrel": esc.Train(3.0, 0.9)}, "give 0.9 of the torque"),
        ({"load_train": esc.Train(3.0, 0.9), "load_torque": 0.1}, "give 1/0.9 of the load torque"),
        ({"load_curve": LOAD}, "their follower swings"),
        ({"follower_rest_angle": 0.1}, "give follower_spring or follower_gravity"),
    ],
)
def test_what_bodies_with_outlines_cannot_have_is_told_with_a_remedy(given, told):
    with pytest.raises(InvalidValue, match=told):
        esc.Escapement(VERGE, esc.Inertia(1.0, 0.3), 1.0, **given)


def test_what_needs_a_transmission_is_refused():
    verge = VERGE
    timer = esc.Escapement(verge, esc.Inertia(1.0, 0.3), 1.0)
    with pytest.raises(InvalidValue, match="must have a transmission function"):
        verge.follower_angle(0.1)
    with pytest.raises(InvalidValue, match="must have a transmission function"):
        esc.index(verge, 1.0, 1.0, follower_inertia=1.0)
    beats = esc.Readings.of_beats(range(20))
    with pytest.raises(InvalidValue, match="whose beats are blows"):
        esc.fit_motion(beats, timer, ["torque"])
    with pytest.raises(InvalidValue, match="tell only rate and beat error, without a mechanism"):
        esc.fit_beats(beats, timer)
    with pytest.raises(InvalidValue, match="fit that of the driver, as with --fit friction,torq"):
        esc.synthetic_readings(verge, seed=1)


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (("--beats", "b.csv", "deadbeat", "--wheel-radius", 1), "--wheel-radius must not come"),
        (("--beats", "b.csv", "deadbeat", "--fit", "both"), "--fit must not come with beats"),
        (("a.csv", "runaway", "--pin-radius", 1), "angles of a runaway .* add --fit friction,torq"),
    ],
)
def test_measure_advises_what_pallets_can_have(command, argv, told):
    Path("b.csv").write_text("time\n" + "\n".join(str(0.2 * k) for k in range(30)))
    code, out, err = command("measure", *argv)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert re.search(told, err)


def test_a_motion_with_pallets_tells_its_friction(command):
    motion = esc.simulate(esc.Escapement(VERGE, esc.Inertia(1.0, 0.3), 1.0, friction=0.15), 40)
    time = np.linspace(0.0, motion.end_time, 2000)
    noise = 0.05 * np.random.default_rng(1).standard_normal(time.size)
    state = motion.at(time)
    table = [time, np.degrees(state.theta) + noise, np.degrees(state.phi)]
    head = "time_s,input_deg,output_deg"
    np.savetxt("run_up.csv", np.column_stack(table), "%.6f", ",", header=head, comments="")
    scene = {"data": "run_up.csv", **WISH["mechanism"]}
    del scene["kind"]
    argv = argv_of("measure", "runaway", scene)
    code, out, err = command(*argv)
    assert (code, out) == (2, "")
    assert "--fit friction,torque" in err
    given = "--torque", 1.05, "--driver-inertia", 1.0, "--follower-inertia", 0.3, "--friction", 0.12
    code, out, err = command(*argv, *given, "--fit", "friction,torque", "--json")
    assert code == 0, err
    fitted = json.loads(out)["motion"]["fitted"]
    for name, truth, most in (("friction", 0.15, 0.004), ("torque", 1.0, 0.01)):
        low, high = fitted[name]["interval"]
        assert low < truth < high < low + most


@pytest.mark.parametrize("name", VERGES)
def test_what_is_exported_can_be_read_back_and_moves_alike(name, tmp_path):
    """Whatever the kind, the unit, and the chords of the parts, the motion is the same."""
    verge, inches = VERGES[name], name == "flat"
    esc.export(verge, tmp_path / "a.dxf", inches=inches, segments=True, title="A")
    drawn = esc.read_outlines(tmp_path / "a.dxf")
    assert drawn.driver_fold == verge.teeth
    numbers = {"inertia": esc.Inertia(1.0, 0.2), "torque": 1.0, "friction": 0.15}
    if "lift" in verge.settings:
        numbers = {"inertia": esc.Inertia(1e-4, 1.0), "torque": 0.005, "friction": 0.1}
        numbers |= {"follower_gravity": 1.0, "follower_viscous": 0.02}
    read = esc.Outlines(*drawn, follower_start=verge.start[1])
    own, other = (esc.terminal(esc.Escapement(one, **numbers)) for one in (verge, read))
    assert own.status is other.status is Status.OK
    assert other.period == pytest.approx(own.period, rel=1e-9)
    path = tmp_path / "b.dxf"
    esc.export(read, path)
    once_more = esc.Outlines(*esc.read_outlines(path), follower_start=verge.start[1])
    again = esc.terminal(esc.Escapement(once_more, **numbers))
    assert again.period == pytest.approx(own.period, rel=1e-9)


WISH = {
    "study": "escapement", "torque": 1.0, "friction": [0.05, 0.35],
    "mechanism": {
        "kind": "runaway", "teeth": 12, "wheel_radius": 1.0, "tooth_depth": 0.22, "lead": 45,
        "back": 15, "tip_radius": 0.01, "span": 2.5, "pallet_radius": 1.02, "pin_radius": 0.05,
    },
    "inertia": {"driver": 1.0}, "ranges": {"follower_inertia": [0.2, 20.0]},
    "objectives": ["scatter", "blow_max"],
}  # fmt: skip


@pytest.mark.slow
def test_a_search_finds_the_verge_that_friction_changes_least():
    """The scatter has its least at one inertia, which bisection of its slope finds as well."""
    found = esc.design_drive(WISH, count=6)
    best = found.designs[0]

    def scatter(inertia):
        periods = [
            esc.terminal(esc.Escapement(VERGE, esc.Inertia(1.0, inertia), 1.0, friction=mu)).period
            for mu in np.linspace(0.05, 0.35, 7)
        ]
        return 0.5 * (max(periods) - min(periods)) / periods[3]

    assert best.values["scatter"] == pytest.approx(scatter(best.chosen["follower_inertia"]))
    inertias = [0.2 * 100.0 ** (k / 60) for k in range(61)]
    assert best.values["scatter"] <= min(map(scatter, inertias))
    assert best.drive.friction == pytest.approx(0.2)
    blows = [one.values["blow_max"] for one in found.designs]
    assert blows == sorted(blows, reverse=True)
    esc.plots.plot_designs(found)


@pytest.mark.slow
def test_a_search_chooses_whole_numbers_and_a_span_between_two_of_them():
    given = {n: x for n, x in WISH["mechanism"].items() if n not in ("teeth", "span")}
    wish = WISH | {"mechanism": given | {"span": 2.5}, "objectives": ["scatter"]}
    wish |= {"inertia": {"driver": 1.0, "follower": 7.0}, "ranges": {"teeth": [11, 13]}}
    (best,) = esc.design_drive(wish, count=1).designs
    assert best.chosen["teeth"] in (11, 12, 13)
    given["teeth"] = 12
    wish |= {"mechanism": given, "ranges": {"span": [1.2, 3.8]}}
    (best,) = esc.design_drive(wish, count=1).designs
    assert best.chosen["span"] in (1.5, 2.5, 3.5)


def test_a_wish_for_a_timer_is_refused_with_a_reason():
    for change, told in (
        ({"ranges": {"speed": [1.0, 2.0]}}, "unknown key 'speed'"),
        ({"objectives": ["torque_rms"]}, "objectives must be"),
        ({"friction": [0.3, 0.1]}, "friction must be"),
        ({"friction": 0.2}, "objectives must be"),
    ):
        with pytest.raises(InvalidValue, match=told):
            esc.design_drive(WISH | change)


def test_a_motion_that_comes_to_rest_in_every_pitch_forgets_its_start():
    wheel = esc.Runaway(
        teeth=21, wheel_radius=1.0, tooth_depth=0.22, lead=math.radians(36.1309), tip_radius=0.01,
        back=math.radians(4.33596), span=2.5, pallet_radius=0.98035, pin_radius=0.0295618,
    )  # fmt: skip
    timer = esc.Escapement(wheel, esc.Inertia(1.0, 6.09109), 1.0, friction=0.1)
    assert esc.terminal(timer).contraction == pytest.approx(0.0, abs=1e-9)
    ends = [esc.simulate(timer, 5, initial_speed=w).handoff_velocities[-2:] for w in (0.0, 0.3)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-13)
