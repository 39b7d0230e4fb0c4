"""Studies of indexing drives, and the search for one: many drives as one by one."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.constant_speed.index_record import record_of
from escapement.study.subject import DRIVE

WHEEL = {"slots": 6, "pins": 1, "crank_radius": 0.05, "clearance": 1e-4}
NUMBERS = {
    "follower_inertia": 0.4, "load_torque": 2.0, "friction": 0.08, "pressure_pin_radius": 0.008,
    "pin_length": 0.012, "pressure_limit": 300e6, "load_frequency": 15.0, "load_damping": 0.02,
    "locking_radius": 0.03, "locking_angle": 0.3, "locking_friction": 0.1, "running_time": 3600.0,
}  # fmt: skip


def drive(wheel=None, **more):
    return esc.index(esc.Geneva(**WHEEL | (wheel or {})), **{"speed": 6.0} | NUMBERS | more)


AXES = {
    "speed": [2.0, 7.0], "follower_inertia": [0.1, 1.0], "load_torque": [0.0, 3.0],
    "slots": [4, 7], "crank_radius": [0.05, 0.07], "clearance": [0.0, 2e-4],
    "friction": [0.0, 0.2], "load_frequency": [0.0, 20.0], "pin_length": [0.01, 0.02],
    "follower_drag": [0.0, 0.02], "efficiency": [0.8, 1.0], "load_damping": [0.0, 0.1],
}  # fmt: skip
"""Two values of many numbers; the locking disc and the damping need their partners."""


def test_every_case_is_that_of_a_drive_alone():
    rng = np.random.default_rng(3)
    names = [*DRIVE.figures]
    for _ in range(12):
        chosen = sorted(rng.choice([*AXES], 2, replace=False).tolist())
        axes = {name: AXES[name] for name in chosen}
        study = esc.sweep(drive(), results=names, **axes)
        assert study.failed == 0
        for i, j in np.ndindex(2, 2):
            values = {chosen[0]: axes[chosen[0]][i], chosen[1]: axes[chosen[1]][j]}
            wheel = {name: values.pop(name) for name in (*WHEEL,) if name in values}
            if values.get("load_frequency") == 0.0:
                values |= {"load_damping": 0.0}
            one = record_of(drive(wheel, **values)).values
            for name in names:
                found = study[name][i, j]
                expected = one.get(name, math.nan)
                assert found == pytest.approx(expected, rel=1e-11, abs=1e-13, nan_ok=True), name


def test_a_case_that_cannot_be_has_a_status_and_no_figures():
    study = esc.sweep(drive(), pins=[1, 3], clearance=[0.0, 1e-4], load_frequency=[0.0, 9.0])
    assert study.outcomes == {"ok": 5, "invalid": 3}
    assert np.isnan(study["torque_max"][1, 1]).all()
    wide = esc.sweep(drive(), pin_radius=[0.01, 0.04])
    assert [*wide.outcomes] == ["ok", "invalid"]


FILE = """
study = "index"
units = "mm"
speed = 60
load_torque = 2000
follower_inertia = 400000
wheel_material = "bronze"
pin_length = 12
pressure_pin_radius = 8
results = ["torque_rms", "pressure_max", "torque_max_deg"]
[mechanism]
slots = 6
pins = 1
[sweep]
crank_radius = [40, 50]
friction = [0.0, 0.08]
"""


def test_a_file_is_swept_drawn_and_read(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(FILE)
    code, out, err = command("sweep", "study.toml", "--json")
    assert code == 0, err
    study = esc.read_study("study.h5")
    assert study.units["torque_rms"] == "N mm"
    assert study.units["torque_max_deg"] == "degree"
    assert json.loads(out)["cases"] == 4
    numbers = {"follower_inertia": 0.4, "pin_length": 0.012, "pressure_pin_radius": 0.008}
    one = esc.index(
        esc.Geneva(6, pins=1, crank_radius=0.04), 2.0 * math.pi, 2.0, wheel_material="bronze",
        friction=0.08, **numbers,
    )  # fmt: skip
    assert study["pressure_max"][0, 1] == pytest.approx(1e-6 * one.pressure_max, rel=1e-12)
    assert study["torque_rms"][0, 1] == pytest.approx(1e3 * one.torque_rms, rel=1e-12)
    degrees = math.degrees(one.torque_max_angle)
    assert study["torque_max_deg"][0, 1] == pytest.approx(degrees, rel=1e-11)
    # defaults are those of Python, whatever the units
    assert esc.load_plan("study.toml").values(0)["load_tolerance"] == pytest.approx(1e-3, rel=1e-12)
    assert command("plot", "study.h5", "-o", "study.png")[0] == 0
    code, _, err = command("run", "--from", "study.h5", "--select", "friction=0,crank_radius=40")
    assert (code, "got one of an indexing drive" in err) == (2, True)


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("torque = 1", "it belongs in a study with study = 'escapement'"),
        ("initial_speed = 1", "it belongs in a study with study = 'escapement'"),
        ('study = "drive"', "study must be"),
        ('results = ["period"]', "results must be"),
        ("mechanism.centre_distance_error = 1e-5", "must be perfect in a study, got errors"),
    ],
)
def test_a_study_refuses_what_a_drive_has_not(refusal, tmp_path, monkeypatch, key, message):
    monkeypatch.chdir(tmp_path)
    name = key.partition(" ")[0]
    kept = "\n".join(line for line in FILE.splitlines() if not line.startswith(f"{name} ="))
    kept = kept.replace("[mechanism]\n", "[mechanism]\n" + key.partition("mechanism.")[2] + "\n")
    key = "" if key.startswith("mechanism") else key
    Path("study.toml").write_text(f"{key}\n{kept}")
    assert message in refusal(2, "sweep", "study.toml")


def test_a_drive_has_no_initial_speed_and_no_engine():
    with pytest.raises(InvalidValue, match="initial_speed must be 0 for an indexing drive"):
        esc.sweep(drive(), speed=[1.0, 2.0], initial_speed=3.0)
    with pytest.raises(InvalidValue, match=r"unknown key 'engine' in \[solver\]"):
        esc.sweep(drive(), speed=[1.0, 2.0], engine="ivp")


WISH = {
    "load_torque": 2.0, "follower_inertia": 0.4, "pin_length": 0.012, "pressure_limit": 300e6,
    "mechanism": {"slots": 6, "pins": 1},
    "ranges": {"speed": [1.0, 9.0], "crank_radius": [0.03, 0.1]},
    "bounds": {"torque_rms": 3.0}, "objectives": ["index_time", "pin_diameter_needed"],
}  # fmt: skip


def test_a_search_ends_at_the_bound_and_at_the_end_of_a_range():
    """A fast drive is limited by its torque, a thin pin needs a great crank and a slow drive."""
    found = esc.design_drive(WISH)
    fast, slow = found.designs[0], found.designs[-1]
    # at the bound: the speed at which the torque is 3 N m, by bisection
    low, high = 1.0, 9.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        one = esc.index(esc.Geneva(6, pins=1), middle, 2.0, follower_inertia=0.4)
        low, high = (middle, high) if one.torque_rms < 3.0 else (low, middle)
    assert fast.chosen["speed"] == pytest.approx(low, rel=1e-3)
    assert fast.values["torque_rms"] <= 3.0
    assert slow.chosen["speed"] == pytest.approx(1.0, rel=1e-3)
    assert slow.chosen["crank_radius"] == pytest.approx(0.1, rel=1e-3)
    times = [one.values["index_time"] for one in found.designs]
    pins = [one.values["pin_diameter_needed"] for one in found.designs]
    assert times == sorted(times)
    assert pins == sorted(pins, reverse=True)
    for one in found.designs:
        assert one.drive.pin_diameter_needed == pytest.approx(
            one.values["pin_diameter_needed"], rel=1e-11
        )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ranges": {}}, "ranges must be a table of numbers to search"),
        ({"ranges": {"spead": [1, 2]}}, "unknown key 'spead' in \\[ranges\\]"),
        ({"ranges": {"speed": [2, 1]}}, "speed must be \\[low, high\\]"),
        ({"ranges": {"speed": 3.0}}, "speed must be two ends"),
        ({"bounds": {"period": 1.0}}, "unknown key 'period' in \\[bounds\\]"),
        ({"objectives": ["mass"]}, "objectives must be"),
    ],
)
def test_a_wish_is_refused_with_a_reason(change, message):
    with pytest.raises(InvalidValue, match=message):
        esc.design_drive(WISH | change)


def test_a_bound_that_nothing_satisfies_is_named():
    found = esc.design_drive(WISH | {"bounds": {"torque_rms": 0.1}})
    assert found.designs == ()
    assert "torque_rms must be at most 0.1 N m, and the least found is" in found.message
    found = esc.design_drive(WISH | {"bounds": {"pressure_max": 1e9}})
    assert "pressure_max does not exist" in found.message


def test_the_command_finds_drives_and_draws_them(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = 'study = "index"\nunits = "mm"\nload_torque = 2000\nfollower_inertia = 4e5\n'
    text += 'objectives = ["torque_rms"]\n[mechanism]\nslots = 6\npins = 1\n'
    Path("wish.toml").write_text(text + "[ranges]\nspeed = [30, 60]\n")
    argv = ("design", "wish.toml", "--json", "--plot", "d.png", "-o", "d.csv")
    code, out, err = command(*argv)
    assert code == 0, err
    (best,) = json.loads(out)["designs"]
    assert best["speed"] == pytest.approx(30.0, rel=1e-3)
    assert Path("d.png").exists()
    assert Path("d.csv").read_text().startswith("speed,torque_rms")
    assert "--report must be left out" in command("design", "wish.toml", "--report", "r.html")[2]


def test_a_cam_turns_the_same_load_in_the_same_time():
    wheel = drive({"clearance": 0.0}, friction=0.0)
    for law, greatest in (("cycloidal", 2.0), ("modified-sine", 1.7596)):
        cam = esc.cam_drive(wheel, law)
        for name in ("index_time", "dwell_time", "inertia_ratio"):
            assert getattr(cam, name) == pytest.approx(getattr(wheel, name), rel=1e-12)
        # the greatest slope of its law, times the mean speed
        mean = math.pi / 3.0 / cam.index_time
        assert cam.follower_velocity_max == pytest.approx(greatest * mean, rel=3e-5)
        turned = np.ptp(cam.at(np.array([*cam.mechanism.breaks])[[0, -1]]).phi)
        assert turned == pytest.approx(math.pi / 3.0, rel=1e-9)
    with pytest.raises(InvalidValue, match="law must be"):
        esc.cam_drive(wheel, "sine")
    two = esc.index(esc.Geneva(6, pins=2), 6.0, follower_inertia=0.4)
    with pytest.raises(InvalidValue, match="indexes must be one in a turn"):
        esc.cam_drive(two, "cycloidal")


def test_two_columns_on_the_command_line(command, report, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["--slots", 6, "--pins", 1, "--speed", 6, "--load-torque", 2, "--follower-inertia", 0.4]
    words += ["--load-frequency", 15, "--against", "cycloidal"]
    record = report("index", *words, "--plot", "a.png")
    other = esc.cam_drive(
        esc.index(esc.Geneva(6, pins=1), 6.0, 2.0, follower_inertia=0.4, load_frequency=15.0),
        "cycloidal",
    )
    assert record["against"]["law"] == "cycloidal"
    assert record["against"]["torque_rms"] == pytest.approx(other.torque_rms, rel=1e-12)
    out = command("index", *words)[1]
    (line,) = [line for line in out.splitlines() if line.startswith("torque rms")]
    assert line.split()[2:] == [f"{record['torque_rms']:.6g}", f"{other.torque_rms:.6g}", "N", "m"]


def test_two_reversals_are_found_however_close():
    for slots in (4, 6, 9):
        wheel = esc.Geneva(slots, pins=1)
        limit = esc.index(wheel, 1.0, 1.0, follower_inertia=1.0).reversal_limits[0]
        for excess in (1e-3, 1e-6, 1e-9):
            found = esc.index(wheel, 1.0, 1.0, follower_inertia=limit * (1.0 + excess))
            assert (found.reversals.size, found.zone) == (2, 2)
            less = esc.index(wheel, 1.0, 1.0, follower_inertia=limit * (1.0 - excess))
            assert (less.reversals.size, less.zone) == (0, 1)


def test_a_textbook_example():
    """Hibbeler, Engineering Mechanics: Statics and Dynamics, 14th edition, problem 16-152.

    At the pin's entry into a wheel of six slots, whose axis is 4 in away, at 4 rad/s: the pin has
    the acceleration 36.96 in/s^2, all of it across the slot.
    """
    found = esc.index(esc.Geneva(6, pins=1), 4.0, follower_inertia=1.0).at([-math.pi / 3.0])
    assert found.phi_dot == pytest.approx(0.0, abs=1e-12)
    assert 4.0 * found.phi_ddot == pytest.approx(36.96, abs=0.01)


def test_torque_is_the_integral_of_its_law():
    """Judged by quadrature and the closed form g = c (cos x - c)/(1 + c^2 - 2 c cos x)."""
    study = esc.sweep(
        esc.index(esc.Geneva(5, pins=1), 3.0, 0.5, follower_inertia=0.2),
        speed=[1.0, 4.0], load_torque=[0.0, 2.0], results=["torque_rms", "torque_mean_cycle"],
    )  # fmt: skip
    c, half = math.sin(math.pi / 5), math.pi / 2 - math.pi / 5

    def torque(x, speed, load):
        lengthy = 1.0 + c * c - 2.0 * c * math.cos(x)
        bend = c * (c * c - 1.0) * math.sin(x) / lengthy**2
        return c * (math.cos(x) - c) / lengthy * (load + 0.2 * bend * speed**2)

    for i, speed in enumerate((1.0, 4.0)):
        for j, load in enumerate((0.0, 2.0)):
            square = quad(lambda x: torque(x, speed, load) ** 2, -half, half, epsabs=0)[0]  # noqa: B023
            expected = math.sqrt(square / (2.0 * math.pi))
            assert study["torque_rms"][i, j] == pytest.approx(expected, rel=1e-10)
            assert study["torque_mean_cycle"][i, j] == pytest.approx(load / 5.0, abs=1e-12)
