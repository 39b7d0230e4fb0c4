"""Long motions are computed part by part, and are the same as if computed at once."""

import tracemalloc
from dataclasses import fields, replace

import h5py
import numpy as np
import pytest

import escapement as esc
from escapement.engines.energy import trajectory
from escapement.motion_file import read_motion, write_motion

INERTIA = esc.Inertia(3.389e-7, 5.649e-6)
TIMER = esc.Escapement(esc.Geneva(4), INERTIA, 0.0113, 0.35, spring_rate=1e-8)
STRIKING = esc.Geneva(
    4, crank_radius=0.02, centre_distance_error=-1e-5, slot_angle_errors=(1e-4, 0.0, -2e-4, 0.0)
)
CAM = esc.TorqueCurve((0.0, 1.3, 4.2, 9.0), (0.01, 0.02, 0.005, 0.01), periodic=True)
CASES = {
    "spring": TIMER,
    "settled": replace(TIMER, spring_rate=0.0),
    "dwell": replace(TIMER, mechanism=esc.Geneva(8), driver_drag=1e-9),
    "cam": replace(TIMER, torque=CAM, spring_rate=0.0, friction=0.2),
    "blows": replace(TIMER, mechanism=STRIKING, friction=0.2),
    "stall": replace(TIMER, load_torque=0.003, friction=0.2, spring_rate=6e-6),
    "viscous": replace(TIMER, driver_viscous=1e-6, spring_rate=0.0, friction=0.1),
}


@pytest.fixture(params=CASES)
def both(request, monkeypatch):
    """A motion that consists of many parts, and the same that is computed at once."""
    long, whole = (esc.simulate(CASES[request.param], 150) for _ in range(2))
    assert [*whole.parts()] == [whole]
    # whatever is kept of it was computed at once
    assert len(whole.t) > 0
    assert whole.trajectory.losses.size > 0
    monkeypatch.setattr(trajectory, "_PART", 7)
    assert len([*long.parts()]) > 10
    return long, whole


def equal(found, expected):
    for field in fields(expected):
        one, two = getattr(found, field.name), getattr(expected, field.name)
        if isinstance(two, np.ndarray):
            np.testing.assert_array_equal(one, two, err_msg=field.name)


def test_parts_are_the_whole_cut_up(both):
    long, whole = both
    parts = [part.trajectory for part in long.parts()]
    for name in ("start", "engagement", "sign", "losses"):
        found = np.concatenate([getattr(part, name) for part in parts], axis=-1)
        np.testing.assert_array_equal(found, getattr(whole.trajectory, name), err_msg=name)
    for name in ("reversals", "extrema"):
        expected, events = getattr(whole, name), [getattr(part, name) for part in parts]
        for field in fields(expected):
            found = np.concatenate([getattr(each, field.name) for each in events])
            np.testing.assert_array_equal(found, getattr(expected, field.name))
    np.testing.assert_array_equal(long.t, whole.t)
    assert long.ledger.residual == pytest.approx(whole.ledger.residual, abs=1e-13)


def test_states_do_not_depend_on_what_else_is_asked(both):
    long, whole = both
    times = np.random.default_rng(1).uniform(0.0, whole.end_time, 200)
    times = np.concatenate([times, whole.handoff_times[::9], whole.trajectory.start[::9]])
    trajectory._PART = 512
    expected = whole.at(times)
    trajectory._PART = 7
    equal(long.at(times), expected)
    alone = [long.at(t).theta_dot for t in times[:20]]
    np.testing.assert_array_equal(alone, long.at(times).theta_dot[:20])


@pytest.mark.parametrize("both", ["cam", "blows"], indirect=True)
def test_a_file_of_many_parts_holds_the_same(both, tmp_path):
    long, whole = both
    write_motion(long, tmp_path / "long.h5")
    write_motion(long, tmp_path / "long.csv")
    trajectory._PART = 512
    write_motion(whole, tmp_path / "whole.h5")
    write_motion(whole, tmp_path / "whole.csv")
    assert (tmp_path / "long.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    with h5py.File(tmp_path / "long.h5") as one, h5py.File(tmp_path / "whole.h5") as two:
        assert sorted(one) == sorted(two)
        for name in two:
            np.testing.assert_array_equal(one[name][()], two[name][()], err_msg=name)
            assert one[name].attrs.get("units") == two[name].attrs.get("units")
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(tmp_path / "long.h5", engine="h5netcdf") as data:
        assert data.theta_dot.dims == ("t",)
        np.testing.assert_array_equal(data.t, whole.t)
    again = read_motion(tmp_path / "long.h5")
    times = np.linspace(0.0, whole.end_time, 400)
    scale = 1e-9 * np.abs(whole.theta_dot).max()
    np.testing.assert_allclose(again.at(times).theta_dot, whole.at(times).theta_dot, atol=scale)


def test_a_few_states_of_a_long_motion_cost_a_few_engagements(monkeypatch):
    motion, solved = esc.simulate(TIMER, 100_000), []
    events_of = trajectory.events_of
    monkeypatch.setattr(
        trajectory, "events_of", lambda *args: solved.append(args[4].size) or events_of(*args)
    )
    motion.at([0.0, 0.5 * motion.end_time, motion.end_time])
    # with their neighbours
    assert sum(solved) <= 9


def test_memory_does_not_grow_with_the_motion(monkeypatch, tmp_path):
    monkeypatch.setattr(trajectory, "_PART", 64)
    peaks = []
    for count in (200, 200, 1000):
        motion = esc.simulate(TIMER, count)
        tracemalloc.start()
        write_motion(motion, tmp_path / "motion.h5", force=True)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[2] < 1.3 * peaks[1]


def test_a_motion_that_is_interrupted_while_it_is_written_leaves_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr(trajectory, "_PART", 20)
    path, done = tmp_path / "motion.h5", []
    path.write_bytes(b"precious")

    def stop(*counts):
        done.append(counts)
        if len(done) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_motion(esc.simulate(TIMER, 100), path, force=True, progress=stop)
    assert done == [(20, 100, 0), (40, 100, 0), (60, 100, 0)]
    assert [*tmp_path.iterdir()] == [path]
    assert path.read_bytes() == b"precious"
