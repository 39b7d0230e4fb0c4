"""Continuing a study: which blocks are reused, when it is refused, and who may write."""

import re
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

import crash_tools as tools
from escapement.base.errors import CannotCreate
from escapement.cli import main
from escapement.dynamics.figures_of_merit import Figures
from escapement.engines import simulate as simulation
from escapement.study import journal, running
from escapement.study.parse import plan_from
from escapement.study.reader import read_study
from escapement.study.running import write_plan
from escapement.study.writer import partial_path
from study_tools import IVP_STUDY, TIMER, let_go, without_date


@pytest.fixture
def solved(monkeypatch):
    """Frictions that were solved, in order; the 22nd call is interrupted."""
    frictions = []

    def fake(escapement, **_):
        frictions.append(escapement.friction)
        if len(frictions) == 22:
            raise KeyboardInterrupt
        return Figures(period=escapement.friction)

    monkeypatch.setattr(simulation, "terminal", fake)
    return frictions


def plan(num=40, **options):
    return plan_from(TIMER, {"friction": np.linspace(0.01, 0.3, num)}, engine="ivp", **options)


def interrupted(path, study=None, **options):
    with pytest.raises(KeyboardInterrupt):
        write_plan(plan() if study is None else study, path, **options)
    let_go()


def test_only_what_is_missing_is_computed(tmp_path, solved):
    path = tmp_path / "a.h5"
    interrupted(path)
    solved.clear()
    before = partial_path(path).stat().st_size
    assert before > 0
    solved.extend([0.0] * 30)  # past the interruption
    tally = write_plan(plan(), path, resume=True)
    assert 16 <= tally.resumed < 40
    assert len(solved) - 30 == 40 - tally.resumed
    assert (tally.cases, tally.failed) == (40, 0)
    assert not partial_path(path).exists()
    write_plan(plan(), tmp_path / "b.h5")
    assert without_date(path) == without_date(tmp_path / "b.h5")


@pytest.mark.usefixtures("solved")
@pytest.mark.parametrize(
    ("other", "difference"),
    [
        (plan(title="other"), 'title was "geneva escapement over friction" and is "other"'),
        (plan(30), "sweep.friction was [0.01, "),
        (plan(rtol=1e-8), "solver.rtol was not set and is 1e-08"),
        (
            plan_from(
                replace(TIMER, torque=0.02), {"friction": np.linspace(0.01, 0.3, 40)}, engine="ivp"
            ),
            "torque was 0.0113 and is 0.02",
        ),
    ],
)
def test_another_configuration_is_refused_with_its_difference(tmp_path, other, difference):
    path = tmp_path / "a.h5"
    interrupted(path)
    before = partial_path(path).read_bytes()
    with pytest.raises(CannotCreate) as caught:
        write_plan(other, path, resume=True)
    assert difference in str(caught.value)
    assert "\n" not in str(caught.value)
    assert partial_path(path).read_bytes() == before
    write_plan(plan(), path, resume=True)
    whole = path.read_bytes()
    with pytest.raises(CannotCreate, match="got the complete file of another: ") as caught:
        write_plan(other, path, resume=True)
    assert difference in str(caught.value)
    assert path.read_bytes() == whole


def test_the_order_of_axes_is_part_of_a_study(tmp_path, solved):
    axes = {"friction": [0.1, 0.2] * 20, "slots": [3, 4]}
    interrupted(tmp_path / "a.h5", plan_from(TIMER, axes, engine="ivp", title="t"))
    swapped = plan_from(TIMER, dict(reversed(axes.items())), engine="ivp", title="t")
    with pytest.raises(CannotCreate, match="had the order friction, slots"):
        write_plan(swapped, tmp_path / "a.h5", resume=True)


@pytest.mark.usefixtures("solved")
def test_a_version_with_other_numbers_is_refused(tmp_path, monkeypatch):
    interrupted(tmp_path / "a.h5")
    monkeypatch.setattr(running, "numerics", lambda: "other")
    with pytest.raises(CannotCreate, match=r"the version that began it, 0\.2\.0 \(\w{12}\), got"):
        write_plan(plan(), tmp_path / "a.h5", resume=True)


def test_a_newer_version_with_the_same_numbers_goes_on(tmp_path, solved, monkeypatch):
    interrupted(tmp_path / "a.h5")
    monkeypatch.setattr(running, "__version__", "9.9.9")
    write_plan(plan(), tmp_path / "a.h5", resume=True)
    assert read_study(tmp_path / "a.h5").attributes["package_version"] != "9.9.9"


@pytest.mark.usefixtures("solved")
def test_partial_results_are_not_dropped_unless_forced(tmp_path):
    path = tmp_path / "a.h5"
    interrupted(path)
    with pytest.raises(
        CannotCreate, match=r"continue with resume=True \(--resume\) or start over with force=True"
    ):
        write_plan(plan(), path)
    assert write_plan(plan(), path, force=True).resumed == 0
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.h5"]


def test_nothing_to_resume_starts_afresh_and_all_done_does_nothing(tmp_path, solved):
    solved.extend([0.0] * 30)
    path = tmp_path / "a.h5"
    assert write_plan(plan(), path, resume=True).resumed == 0
    before = path.read_bytes()
    solved.clear()
    assert write_plan(plan(), path, resume=True).resumed == 40
    assert solved == []
    assert path.read_bytes() == before
    (tmp_path / "b.h5").write_text("no study")
    with pytest.raises(CannotCreate, match="must not exist yet"):
        write_plan(plan(), tmp_path / "b.h5", resume=True)
    assert path.read_bytes() == before
    assert sorted(tmp_path.iterdir()) == [path, tmp_path / "b.h5"]


def notes(path):
    path.write_text("my own notes, of some length")


def database(path):
    with closing(sqlite3.connect(path)) as made, made:
        made.execute("CREATE TABLE notes (text)")


@pytest.mark.parametrize("make", [notes, database])
def test_a_file_of_someone_else_is_not_taken_for_partial_results(tmp_path, make):
    partial = partial_path(tmp_path / "a.h5")
    make(partial)
    before = partial.read_bytes()
    for options in ({}, {"resume": True}, {"force": True}):
        with pytest.raises(CannotCreate, match="no partial result; move it away"):
            tools.write(tmp_path / "a.h5", tools.small_study(), **options)
    assert partial.read_bytes() == before
    assert list(tmp_path.iterdir()) == [partial]


def test_the_second_of_two_is_told_so(tmp_path, monkeypatch):
    """A link and its file are one output."""
    monkeypatch.setattr(journal, "_PATIENCE", 0.2)
    path, link = tmp_path / "real.h5", tmp_path / "link.h5"
    link.symlink_to(path)
    with tools.start_writer(path, pause=60.0) as first:
        assert first.stdout.readline() == "begun\n"
        assert first.stdout.readline() == "0\n"
        before = partial_path(path).read_bytes()
        for options in ({}, {"resume": True}, {"force": True}):
            with pytest.raises(CannotCreate, match="another process is writing it") as caught:
                tools.write(link, tools.small_study(), **options)
            assert "\n" not in str(caught.value)
        assert partial_path(path).read_bytes() == before
        first.kill()
    assert tools.missing(path) == list(range(1, 10))  # a dead process holds no lock


def test_resume_on_the_command_line(tmp_path, solved, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(IVP_STUDY)
    assert main(["sweep", "s.toml", "--quiet", "--workers", "1"]) == 130
    assert capsys.readouterr().err.splitlines() == [
        "escapement: finished cases are kept in s.h5.partial; continue with --resume",
        "escapement: error: interrupted",
    ]
    assert main(["sweep", "s.toml", "--quiet"]) == 73
    assert "continue with resume=True (--resume)" in capsys.readouterr().err
    assert main(["sweep", "s.toml", "--resume"]) == 0
    errors = capsys.readouterr().err
    assert re.search(
        r"40 cases in s.h5, \d+ of them above, \d+ of them from an earlier run", errors
    )
    assert main(["sweep", "s.toml", "--resume", "--json"]) == 0
    assert '"resumed": 40' in capsys.readouterr().out


@pytest.mark.slow
def test_a_link_and_its_file_are_one_output(tmp_path):
    (tmp_path / "link.h5").symlink_to(tmp_path / "real.h5")
    with tools.start_writer(tmp_path / "real.h5", pause=60.0) as first:
        first.stdout.readline()
        first.stdout.readline()
        with pytest.raises(CannotCreate, match="is writing it"):
            tools.write(tmp_path / "link.h5", tools.small_study())
        first.kill()


def test_files_with_names_like_those_of_partial_results_are_not_touched(tmp_path):
    for name in ("a.h5.unfinished", "a.unfinished", ".escapement-0123456789abcdef.partial"):
        (tmp_path / name).write_text("my own notes")
    (tmp_path / "b.h5.unfinished").symlink_to("a.unfinished")
    before = {path: path.read_text() for path in tmp_path.iterdir()}
    for name in ("a.h5", "b.h5"):
        tools.write(tmp_path / name, tools.small_study())
        (tmp_path / name).unlink()
    assert {path: path.read_text() for path in tmp_path.iterdir()} == before
