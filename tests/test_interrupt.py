"""A sweep that is interrupted ends at once, and keeps what is done."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import closing

import pytest

from escapement.study.pool import in_threads

pytestmark = pytest.mark.slow

INTERRUPTED = """
import sys, time
from escapement.engines import simulate as simulation
from escapement.dynamics.figures_of_merit import Figures
sys.path.insert(0, {folder!r})
from test_sweep import TIMER, sweep
def slow(*_, **__):
    time.sleep(0.02)
    return Figures()
simulation.terminal = slow
try:
    print("started", flush=True)
    sweep(TIMER, friction=[0.1] * 100_000, path={path!r}, progress=True, engine="ivp")
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals differ")
def test_ctrl_c_ends_a_sweep_at_once_and_keeps_what_is_done(tmp_path):
    code = INTERRUPTED.format(folder=os.path.dirname(__file__), path=str(tmp_path / "a.h5"))
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    with process:
        assert process.stdout.readline() == "started\n"
        partial = tmp_path / "a.h5.partial"
        # blocks are in it after a second
        while not partial.exists() or partial.stat().st_size < 30_000:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)  # the whole takes half an hour
    assert process.returncode == 130, errors
    assert re.fullmatch(r"( +\d+ % \d+ of 100000 cases, .*\n)+", errors)
    assert list(tmp_path.iterdir()) == [tmp_path / "a.h5.partial"]


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
