"""Studies on a real Dask cluster: the same bytes, whatever happens to its workers."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from escapement.base.errors import InvalidValue, StorageError
from escapement.cli import main
from escapement.study import pool, running
from escapement.study.parse import plan_from
from escapement.study.reader import read_study
from escapement.study.running import sweep, write_plan
from escapement.study.writer import partial_path
from study_tools import TIMER, without_date

distributed = pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore"),  # of Dask's own making
]


QUIET = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}


@pytest.fixture(scope="module")
def client():
    """Two workers on this machine."""
    with (
        distributed.LocalCluster(n_workers=2, host="127.0.0.1", **QUIET) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def plan(cases=100_000):
    return plan_from(TIMER, {"friction": np.linspace(0.05, 0.4, cases)})


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """The bytes of the study, computed here."""
    path = tmp_path_factory.mktemp("serial") / "a.h5"
    write_plan(plan(), path, workers=2)
    return without_date(path)


def test_same_bytes_though_a_worker_is_killed(tmp_path, client, serial):
    workers = list(client.run(os.getpid).values())
    killed = []

    def kill_one(done, total, failed):
        if done and not killed:
            killed.append(workers[0])
            os.kill(workers[0], signal.SIGKILL)

    tally = write_plan(plan(), tmp_path / "a.h5", scheduler=client, progress=kill_one)
    assert killed
    assert tally.cases == 100_000
    assert without_date(tmp_path / "a.h5") == serial
    assert list(tmp_path.iterdir()) == [tmp_path / "a.h5"]


def test_a_sample_and_shared_scenes_have_the_same_bytes(tmp_path, client):
    drawn = {"method": "sobol", "size": 1024, "friction": {"low": 0.1, "high": 0.4}}
    drawn |= {"driver_inertia": {"relative_tolerance": 0.05}}
    study = plan_from(TIMER, {"torque": np.linspace(0.005, 0.02, 64)}, sample=drawn)
    write_plan(study, tmp_path / "here.h5", workers=2)
    write_plan(study, tmp_path / "there.h5", scheduler=client)
    assert without_date(tmp_path / "here.h5") == without_date(tmp_path / "there.h5")


def test_a_block_that_ends_every_worker(tmp_path, client, monkeypatch):
    made = {"__name__": "__main__"}  # so that it travels by value
    exec("def fatal(*_):\n    import os\n    os._exit(9)", made)
    monkeypatch.setattr(running, "solve_block", made["fatal"])
    monkeypatch.setattr(client.cluster.scheduler, "allowed_failures", 0)
    with pytest.raises(StorageError, match="a block of cases ended 1 workers"):
        write_plan(plan(10), tmp_path / "a.h5", scheduler=client)
    assert list(tmp_path.iterdir()) == []


def test_local_cluster_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(
        "torque = 0.01\n[mechanism]\nslots = 4\n[inertia]\ndriver = 3e-7\nfollower = 6e-6\n"
        "[sweep]\nfriction = [0.1, 0.2]\n"
    )
    assert main(["sweep", "s.toml", "--scheduler", "local", "--workers", "1", "--quiet"]) == 0
    assert read_study("s.h5").failed == 0
    capsys.readouterr()
    assert main(["sweep", "s.toml", "--scheduler", "tcp://x:1", "--workers", "1"]) == 2
    assert "--workers must not come with --scheduler tcp://x:1" in capsys.readouterr().err


def test_no_scheduler_there(tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "_PATIENCE", 0.5)
    with pytest.raises(StorageError, match="must answer, and did not"):
        sweep(TIMER, friction=[0.1], path=tmp_path / "a.h5", scheduler="tcp://127.0.0.1:9")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("scheduler", [5, b"tcp://127.0.0.1:9"])
def test_what_is_no_scheduler(tmp_path, scheduler):
    with pytest.raises(InvalidValue, match="scheduler must be an address or a client"):
        sweep(TIMER, friction=[0.1], path=tmp_path / "a.h5", scheduler=scheduler)
    assert list(tmp_path.iterdir()) == []


def test_a_client_that_is_closed(tmp_path, client):
    closed = distributed.Client(client.cluster)
    closed.close()
    with pytest.raises(InvalidValue, match="scheduler must be a client that is connected"):
        sweep(TIMER, friction=[0.1], path=tmp_path / "a.h5", scheduler=closed)


def test_a_scheduler_that_is_lost(tmp_path, client, serial):
    path = tmp_path / "a.h5"

    def lose(done, total, failed):
        if done:
            other.close()

    with (
        distributed.LocalCluster(n_workers=1, processes=False, **QUIET) as other,
        distributed.Client(other) as lost,
        pytest.raises(StorageError, match="was lost"),
    ):
        write_plan(plan(), path, scheduler=lost, progress=lose)
    tally = write_plan(plan(), path, scheduler=client, resume=True)
    assert 0 < tally.resumed < tally.cases
    assert without_date(path) == serial


def test_a_script_without_a_guard(tmp_path):
    script = tmp_path / "study.py"
    script.write_text(
        "import escapement as esc\n"
        "timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.35)\n"
        "esc.sweep(timer, friction=[0.1], path='a.h5', scheduler='local', workers=1)\n"
    )
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert done.stderr.splitlines()[-1].endswith("under: if __name__ == '__main__'")
    assert list(tmp_path.iterdir()) == [script]


def test_begun_here_and_continued_there(tmp_path, client, serial):
    path = tmp_path / "a.h5"

    def stop(done, total, failed):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_plan(plan(), path, scheduler=client, progress=stop)
    assert partial_path(path).exists()
    tally = write_plan(plan(), path, scheduler=client, resume=True)
    assert 0 < tally.resumed < tally.cases
    assert without_date(path) == serial
