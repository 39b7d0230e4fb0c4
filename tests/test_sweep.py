"""Studies: every case where it belongs, bad ones marked, files as asked for."""

import io
import os
import threading
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest

from both_engines import each_engine
from escapement.base import progress
from escapement.base.errors import InvalidValue, StorageError
from escapement.base.progress import Progress, duration
from escapement.base.status import Status
from escapement.base.units import INCH_POUND
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.engines import solver
from escapement.mechanisms import GearDriven, Geneva
from escapement.model.escapement import Escapement, Inertia
from escapement.study.parse import plan_from
from escapement.study.pool import in_threads
from escapement.study.reader import read_study
from escapement.study.result import RESULTS
from escapement.study.running import Tally, run_plan, sweep, write_plan

TIMER = Escapement(
    Geneva(slots=4), Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND), 0.1 * INCH_POUND, 0.35
)


def fake(escapement, *, engine, initial_speed=0.0, rtol=None, **_):
    """Figures that tell which case they belong to."""
    if escapement.friction > 0.4:
        return Figures(status=Status.PAINLEVE, message="painleve")
    return Figures(
        velocity_max=escapement.friction,
        velocity_min=escapement.torque,
        velocity_mean=escapement.inertia.driver,
        period=initial_speed,
        rise_time=escapement.mechanism.slots,
        settling_time=escapement.mechanism.pins,
    )


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(simulation, "terminal", fake)


@each_engine
def test_a_case_is_what_terminal_says(engine):
    grid = sweep(TIMER, engine=engine, torque=[TIMER.torque, 4 * TIMER.torque], friction=[0.35])
    alone = simulation.terminal(TIMER, engine=engine)
    for name in RESULTS:
        assert grid.results[name].shape == (2, 1)
        assert grid.results[name][0, 0] == pytest.approx(getattr(alone, name), rel=1e-12)
    ratio = grid.results["velocity_max"][1, 0] / grid.results["velocity_max"][0, 0]
    assert ratio == pytest.approx(2.0, rel=1e-8)
    assert grid.attributes["engine"] == engine
    assert grid.attributes["rtol"] == solver.DEFAULT_RTOL[engine]


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("workers", [1, 3])
def test_every_case_lands_where_its_axes_say(tmp_path, workers):
    axes = {
        "torque": np.linspace(1, 2, 7),
        "initial_speed": np.array([0.0, 5.0]),
        "friction": np.array([0.1, 0.2, 0.5]),
        "slots": np.array([4, 3, 6]),
    }
    plan = plan_from(TIMER, axes, engine="ivp")
    grid = run_plan(plan, workers=workers)
    expected = dict(zip(axes, np.meshgrid(*axes.values(), indexing="ij"), strict=True))
    failed = expected["friction"] > 0.4
    places = {"velocity_max": "friction", "velocity_min": "torque"}
    for result, axis in (places | {"period": "initial_speed", "rise_time": "slots"}).items():
        values = np.where(failed, np.nan, expected[axis])
        np.testing.assert_array_equal(grid.results[result], values)
    status = np.where(failed, Status.PAINLEVE, Status.OK)
    np.testing.assert_array_equal(grid.results["status"], status)
    np.testing.assert_array_equal(grid.results["settling_time"][0, 0, 0], [4, 6, 3])
    assert grid.failed == failed.sum()
    assert write_plan(plan, tmp_path / "a.h5", workers=workers) == Tally(126, failed.sum())
    for name, values in read_study(tmp_path / "a.h5").results.items():
        np.testing.assert_array_equal(values, grid.results[name])


def test_a_bad_case_is_marked_and_the_rest_goes_on(monkeypatch):
    troubles = {0.1: ZeroDivisionError, 0.2: ValueError, 0.3: InvalidValue}

    def troubled(escapement, **settings):
        if escapement.friction in troubles:
            raise troubles[escapement.friction]("no")
        return fake(escapement, **settings)

    monkeypatch.setattr(simulation, "terminal", troubled)
    grid = sweep(TIMER, friction=[0.1, 0.2, 0.3, 0.35], engine="ivp")
    bad = Status.NOT_CONVERGED
    assert grid.results["status"].tolist() == [bad, bad, Status.INVALID, Status.OK]
    assert np.isnan(grid.results["velocity_max"]).tolist() == [True, True, True, False]
    monkeypatch.undo()
    grid = sweep(TIMER, slots=[3, 6], pins=[3, 4])
    beyond = Status.PAINLEVE  # three slots at these inertias: friction 0.35 is too much
    assert grid.results["status"].tolist() == [[beyond, beyond], [0, Status.INVALID]]


@pytest.mark.parametrize("engine", ["energy", "ivp"])
def test_a_mechanism_that_has_no_motion_is_marked_too(engine):
    # the pins of 12 stations and 4 lobes go through the wheel's centre
    wheel = GearDriven(12, 3, "hypocycloid")
    model = Escapement(wheel, Inertia(3e-7, 5e-6), torque=0.01, friction=0.05)
    study = sweep(model, lobes=[3, 4], engine=engine)
    assert study.outcomes == {"ok": 1, "invalid": 1}
    assert np.isfinite(study.results["period"]).tolist() == [True, False]


def test_an_error_of_the_program_is_not_hidden(tmp_path, monkeypatch):
    def broken(*_, **__):
        raise TypeError("a mistake")

    monkeypatch.setattr(simulation, "terminal", broken)
    with pytest.raises(TypeError, match="a mistake"):
        sweep(TIMER, friction=[0.1], path=tmp_path / "a.h5", engine="ivp")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("quick")
def test_an_array_of_initial_speeds_is_an_axis():
    grid = sweep(TIMER, initial_speed=[1.0, 2.0], friction=0.2, engine="ivp")
    assert list(grid.axes) == ["friction", "initial_speed"]
    assert grid.results["period"].tolist() == [[1.0, 2.0]]
    grid = sweep(TIMER, initial_speed=3.0, friction=[0.2], engine="ivp")
    assert grid.results["period"] == [3.0]


def test_a_full_disk_ends_the_sweep_and_its_threads(tmp_path, monkeypatch):
    monkeypatch.setattr(simulation, "terminal", fake)
    monkeypatch.setattr("escapement.study.journal.Journal.append", _no_space)
    before = set(threading.enumerate())
    with pytest.raises(StorageError, match="No space left"):
        sweep(TIMER, friction=[0.1, 0.2], engine="ivp", path=tmp_path / "a.h5")
    assert list(tmp_path.iterdir()) == []
    own = set(threading.enumerate()) - before
    for thread in own:
        thread.join(timeout=10.0)  # the sweep does not wait for work that nobody wants any more
    assert not any(thread.is_alive() for thread in own)


def _no_space(*_):
    raise OSError(28, os.strerror(28))


@pytest.mark.usefixtures("quick")
def test_progress_counts_up_to_the_end(capsys):
    seen = []
    frictions = np.linspace(0.1, 0.5, 50)
    sweep(TIMER, friction=frictions, engine="ivp", progress=lambda *counts: seen.append(counts))
    assert [done for done, _, _ in seen] == sorted({done for done, _, _ in seen})
    assert seen[0] == (0, 50, 0)
    assert seen[-1] == (50, 50, int((np.linspace(0.1, 0.5, 50) > 0.4).sum()))
    sweep(TIMER, friction=[0.1], progress=False)
    assert capsys.readouterr() == ("", "")
    sweep(TIMER, friction=[0.1], progress=True)
    output, errors = capsys.readouterr()
    assert output == ""
    assert errors.startswith("100 % 1 of 1 cases, ")


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def show(monkeypatch):
    """What a bar writes that is told of a case at each of some times."""

    def shown(stream, times, **options):
        now = [0.0]
        monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: now[0]))
        with Progress(stream, **options) as bar:
            for count, now[0] in enumerate(times, 1):
                bar(count, len(times), count // 2)
        return stream.getvalue()

    return shown


def test_a_log_gets_an_early_line_one_a_minute_and_one_at_the_end(show):
    lines = show(io.StringIO(), [1, 3, 31, 45, 62, 64, 100]).splitlines()
    counts = [line.split(" cases")[0].strip() for line in lines]
    assert counts == ["28 % 2 of 7", "85 % 6 of 7", "100 % 7 of 7"]
    assert lines[0].endswith("7.5 s left, 1 failed")
    assert lines[-1].endswith("took 1 min 40 s, 3 failed")


def test_compiling_is_told_apart_from_solving(show, monkeypatch):
    class Notice:
        times = iter([0.0, 0.0, *[40.0] * 99])  # nothing was compiled when the bar was made
        spent = property(lambda self: next(self.times))

    monkeypatch.setattr(progress, "notice", Notice())
    lines = show(io.StringIO(), [41, 43, 45, 50]).splitlines()
    assert lines[0].strip() == "50 % 2 of 4 cases, 0.667/s, 3.0 s left, 1 failed"
    assert lines[-1].endswith("4 of 4 cases, 0.4/s, took 10 s, and compiling 40 s, 2 failed")


def test_a_terminal_gets_one_line_that_is_drawn_again(show):
    text = show(Terminal(), [0.05, 0.15, 0.2, 0.3, 0.31])
    assert text.count("\r") == 3
    assert text.endswith("\n")
    assert text.count("\n") == 1
    assert "[##############..........]  60 % 3 of 5 cases, 15/s, 0.1 s left, 1 failed" in text


def test_a_log_for_programs_gets_counts_and_rate_once_a_second_and_at_the_end(show):
    seen = []
    times = [0.5, 0.6, 1.4, 1.6, 4.0, 5.0]
    show(io.StringIO(), times, quiet=True, log=lambda *counts: seen.append(counts))
    assert seen == [(1, 6, 0, 2.0), (4, 6, 2, 2.5), (5, 6, 2, 1.25), (6, 6, 3, 1.2)]


def test_quiet_is_silent_and_a_closed_stream_no_trouble(show):
    assert show(io.StringIO(), [100], quiet=True) == ""
    stream = io.StringIO()
    stream.close()
    with Progress(stream) as bar:
        bar(1, 2, 0)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.04, "0.0 s"), (9.96, "10 s"), (59.6, "1 min 00 s"), (3600, "1 h 00 min"), (1e6, "277 h")],
)
def test_durations_read_well(seconds, text):
    assert duration(seconds).startswith(text)


def test_leaving_waits_for_nothing_that_is_being_solved():
    begun, gate, ended = threading.Event(), threading.Event(), []

    def work(_, number):
        if number > 0:
            begun.set()
            gate.wait(60.0)
            ended.append(number)
        return number

    with in_threads(1) as pool, closing(pool.completed(work, None, range(4))) as solved:
        assert next(solved) == 0
        assert begun.wait(60.0)
    assert ended == []
    gate.set()
