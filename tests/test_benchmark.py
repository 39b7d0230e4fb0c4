"""The benchmark measures what it says: its reference, its error, its solvers, its files.

Nothing here looks at a time.
"""

import json
import math
import sys
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from escapement.base.errors import StorageError
from escapement.benchmark import work_precision, write_csv
from escapement.benchmark.problems import PROBLEMS, REFERENCE, MeasuredSolver, package_solvers
from escapement.benchmark.work_precision import Point, standings, time_at
from escapement.cli import main

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import peers  # noqa: E402

MEYER = PROBLEMS[0]
OWN = list(package_solvers())
ALL = [*OWN, *peers.peer_solvers()]
RTOL = {"ivp": 1e-6, "energy": 1e-6, "heyoka": 1e-8}

PAIRS = [(s, p) for s in ALL for p in PROBLEMS if p is MEYER or s.family != "solve_ivp"]


def point(error, time, solver="x", rtol=1e-9):
    return Point("meyer", solver, solver, "", "", rtol, error, time, 1.0)


def test_references_belong_to_the_problems_as_stated():
    """The first is the tests' own in inch-pounds: only the rounding of its inputs differs."""
    text = files("escapement.benchmark").joinpath(REFERENCE).read_text(encoding="utf-8")
    for problem in PROBLEMS:
        record = json.loads(text)[problem.name]
        for name in ("friction", "slots", "driver_inertia", "follower_inertia", "torque"):
            assert record[name] == pytest.approx(getattr(problem, name), rel=4e-16)
        assert record["pins"] == problem.escapement.mechanism.pins
        assert float(record["error"]) <= 1e-20
        assert [len(values) for values in problem.reference] == [problem.engagements] * 2
    path = Path(__file__).with_name("reference") / "motions.json"
    cases = {case["name"]: case for case in json.loads(path.read_text(encoding="utf-8"))}
    case = cases["meyer four pins"]
    expected = [[float(x) for x in case[name]] for name in ("handoff_times", "handoff_velocities")]
    np.testing.assert_allclose(MEYER.reference, expected, rtol=1e-15)


def test_error_is_the_largest_relative_one():
    times, speeds = (values.copy() for values in MEYER.reference)
    assert MEYER.error(times, speeds) == 0.0
    speeds[3] *= 1.0 + 1e-6
    assert MEYER.error(times, speeds) == pytest.approx(1e-6)
    assert math.isnan(MEYER.error(times[:-1], speeds[:-1]))


@pytest.mark.parametrize(
    ("solver", "problem"), PAIRS, ids=[f"{c.solver}, {p.name}" for c, p in PAIRS]
)
def test_solvers_solve_the_problem(solver, problem):
    rtol = RTOL.get(solver.family, 1e-4)
    run = solver.prepare(problem, rtol)
    error = problem.error(*run())
    assert error < 100 * rtol
    if solver.family == "heyoka":
        assert problem.error(*run()) == error  # a reset leaves nothing behind


def test_the_package_measures_its_engines_and_scipy_and_the_peers_that_are_installed():
    assert {solver.family for solver in OWN} == {"energy", "ivp", "solve_ivp"}
    here = {"heyoka"} if find_spec("heyoka") else set()
    assert {solver.family for solver in peers.peer_solvers()} == here
    assert len({solver.solver for solver in ALL}) == len(ALL)


def test_a_further_solver_stands_in_every_table(tmp_path, monkeypatch):
    monkeypatch.setattr(work_precision, "QUICK_SOLVERS", ("energy",))
    further = MeasuredSolver("heyoka", "heyoka", "Taylor", "LLVM", -6, -6, OWN[0].prepare)
    results = work_precision.run(quick=True, further=[further])
    assert {row.solver for row in results.standings} == {"energy", "heyoka"}
    written = {path.name for path in work_precision.write(results, tmp_path)}
    tables = {"machine.json", "standings.csv", "work_precision.csv"}
    assert written == tables | {"work_precision.svg"}
    header = (tmp_path / "standings.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header == "problem,solver,error,time,ratio,first"


def test_time_at_an_error_lies_between_the_best_points_around_it():
    line = [point(1e-8, 1.0), point(1e-12, 4.0)]
    assert time_at(line, 1e-10) == pytest.approx(2.0)
    assert time_at(line, 1e-6) == 1.0
    assert math.isnan(time_at(line, 1e-13))
    # a point that another beats in both does not count
    line = [point(1e-8, 5.0), point(1e-9, 2.0), point(1e-11, 8.0), point(1e-10, 9.0)]
    assert time_at(line, 1e-8) == pytest.approx(2.0)
    assert time_at(line, 1e-10) == pytest.approx(4.0)


def test_energy_stands_at_its_default_tolerance_and_the_others_at_the_error():
    points = [
        point(1e-7, 1.0, "energy", 1e-6),
        point(1e-15, 2.0, "energy", 1e-12),
        point(1e-8, 10.0, "peer"),
        point(1e-12, 40.0, "peer"),
        point(1e-3, 1.0, "coarse"),
    ]
    energy, peer, coarse = standings(points)
    assert (energy.solver, energy.time, energy.error) == ("energy", 2.0, 1e-15)
    assert (peer.solver, peer.error) == ("peer", 1e-10)
    assert (peer.time, peer.ratio) == pytest.approx((20.0, 10.0))
    assert coarse.solver == "coarse"
    assert math.isnan(coarse.time)


def test_tables_leave_out_what_does_not_exist(tmp_path):
    path = write_csv(tmp_path / "a.csv", [point(math.nan, 0.5)])
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[1] == "meyer,x,x,,,1e-09,,0.5,1"


def test_what_was_measured_is_kept_where_it_can_be(tmp_path, monkeypatch, capsys):
    """On a full disk it is shown; where nobody reads it, it is written."""
    folder, written = tmp_path / "new", []

    def full(results, folder):
        raise StorageError("the disk is full")

    def left(record):
        raise BrokenPipeError

    results = work_precision.Results({}, True, [])
    monkeypatch.setattr(work_precision, "run", lambda **_: results)
    monkeypatch.setattr(work_precision, "write", full)
    assert main(["bench", "--quick", "-o", str(folder), "--json"]) == 74
    assert json.loads(capsys.readouterr().out)["quick"] is True
    monkeypatch.setattr(
        work_precision, "write", lambda results, folder: written.append(folder) or []
    )
    monkeypatch.setattr("escapement.cli._output.print_json", left)
    assert main(["bench", "--quick", "-o", str(folder), "--json"]) == 0
    assert written == [folder]
