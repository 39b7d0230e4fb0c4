"""However a running study is interrupted, no finished case is lost and the file is the same.

The functions of `crash_tools` can go through every call and error and through many more instants.
"""

import json
import random
import signal
import subprocess
import sys
import time
from itertools import cycle

import pytest

import crash_tools as tools
from escapement.cli import main
from study_tools import IVP_STUDY, without_date

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals and locks"),
]


# the partial results are the same for every format of the final file
@pytest.mark.parametrize("name", tools.NAMES)
def test_killed_at_random_instants(tmp_path, name):
    kills = 5 if name.endswith(".h5") else 2
    assert tools.kill_until_done(tmp_path / name, kills, random.Random(7)) > 0


@pytest.mark.parametrize(("number", "code"), [(signal.SIGKILL, -9), (signal.SIGTERM, 143)])
def test_a_sweep_that_is_struck_and_resumed_is_that_of_one_run(
    tmp_path, monkeypatch, capsys, number, code
):
    monkeypatch.chdir(tmp_path)
    text = IVP_STUDY.replace("num = 40", "num = 60_000").replace('"ivp"', '"energy"')
    (tmp_path / "s.toml").write_text(text)
    command = [sys.executable, "-m", "escapement", "sweep", "s.toml", "--quiet", "--workers", "1"]
    command += ["--log", "log.jsonl"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        log = tmp_path / "s.h5.partial-wal"
        while not log.exists() or log.stat().st_size < 100_000:
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == code
    assert ("finished cases are kept in s.h5.partial" in errors) == (number == signal.SIGTERM)
    lines = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert (lines[-1]["event"] == "end") == (number == signal.SIGTERM)
    if number == signal.SIGTERM:
        assert lines[-3]["file"].endswith("s.h5.partial")
        assert [lines[-2]["message"], lines[-1]["exit_code"]] == ["terminated", 143]
    assert not (tmp_path / "s.h5").exists()
    assert main(["sweep", "s.toml", "--quiet", "--resume"]) == 0
    assert " of them from an earlier run" in capsys.readouterr().err
    assert main(["sweep", "s.toml", "--quiet", "-o", "t.h5"]) == 0
    assert without_date(tmp_path / "s.h5") == without_date(tmp_path / "t.h5")


@pytest.mark.parametrize("name", tools.NAMES)
@pytest.mark.parametrize("begun", [False, True], ids=["fresh", "resumed"])
def test_a_call_that_fails_costs_one_line(tmp_path, name, begun):
    # a table is written in fewer calls
    calls = [*range(40), *range(40, 140, 20)] if name == "a.h5" else range(48)
    codes = cycle(tools.ERRORS[:5])
    failed = [tools.fail_once(tmp_path / name, call, next(codes), begun) for call in calls]
    assert failed == sorted(failed, reverse=True)
    assert sum(failed) > 35


def test_damaged_partial_results_are_refused_and_the_remedy_works(tmp_path):
    rng = random.Random(3)
    told = [tools.damage_once(tmp_path, rng) for _ in range(60)]
    assert sum(map(bool, told)) > 30
