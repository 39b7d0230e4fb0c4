"""Whatever strikes a running study, nothing finished is lost and the file is the same.

A sample of `benchmarks/crash.py`, which goes through every call, error and many instants.
"""

import random
import resource
import signal
import subprocess
import sys
from itertools import cycle
from pathlib import Path

import pytest

import crash_tools as tools

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals and locks")


def test_killed_at_ten_random_instants(tmp_path):
    assert tools.kill_until_done(tmp_path / "a.h5", 10, random.Random(7)) > 0


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_asked_to_end(tmp_path, number):
    told = tools.kill_one(tmp_path / "a.h5", 0.02, number)
    assert not set(told) & set(tools.missing(tmp_path / "a.h5"))


@pytest.mark.parametrize("begun", [False, True], ids=["fresh", "resumed"])
def test_a_call_that_fails_costs_one_line(tmp_path, begun):
    calls = [*range(40), *range(40, 140, 20)]
    codes = cycle(tools.ERRORS[:5])
    assert all(tools.fail_once(tmp_path, call, next(codes), begun) for call in calls)


@pytest.mark.filterwarnings("ignore:a.h5.partial is damaged")
def test_random_damage_is_found(tmp_path):
    rng = random.Random(3)
    lost = [tools.damage_once(tmp_path, rng) for _ in range(100)]
    assert max(lost) <= 5
    assert sum(lost) > 5


@pytest.mark.filterwarnings("ignore:a.h5.partial is damaged")
def test_damage_costs_what_it_hits_and_no_more(tmp_path):
    path = tmp_path / "a.h5"
    tools.leave_half(path)
    partial = tools.partial_path(path)
    data = bytearray(partial.read_bytes())
    half = data.rfind(b"\x78\x01")  # the begin of a deflated chunk
    data[half + 10] ^= 4
    partial.write_bytes(data)
    assert len(tools.missing(path)) == 6
    assert len(tools.missing(path)) == 6  # what was saved is whole


LIMITED = """
import resource, sys
sys.path.insert(0, {folder!r})
import crash_tools as tools
from pathlib import Path
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
try:
    tools.write(Path({path!r}), tools.small_study(), resume=True)
except tools.EscapementError as error:
    print(error)
    sys.exit(error.exit_code)
"""


@pytest.mark.parametrize("limit", [0, 100, 10_000, 30_000])
def test_a_limit_on_the_size_of_files(tmp_path, limit):
    path = tmp_path / "a.h5"
    code = LIMITED.format(folder=str(Path(__file__).parent), limit=limit, path=str(path))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (74, "")
    assert done.stdout.startswith(f"writing {path} failed: ")
    assert done.stdout.count("\n") == 1
    assert tools.partial_path(path).exists() == (limit > 20_000)
    assert ("is kept in a.h5.partial" in done.stdout) == (limit > 20_000)
    assert ("nothing was left behind" in done.stdout) == (limit < 20_000)
    tools.write(path, tools.small_study(), resume=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.h5"]
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != limit
