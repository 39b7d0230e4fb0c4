"""A sweep that is interrupted ends at once, and keeps what is done."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import CancelledError

import numpy as np
import pytest

from escapement import simulation
from escapement.metrics import Figures
from escapement.study.evaluate import Evaluator, in_threads
from escapement.study.sweep import plan_from
from natural_units import drive

INTERRUPTED = """
import sys, time
from escapement import simulation
from escapement.metrics import Figures
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
        while not partial.exists() or b"ESCblk" not in partial.read_bytes():
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)  # the whole takes half an hour
    assert process.returncode == 130, errors
    assert re.fullmatch(r" +\d+ % \d+ of 100000 cases, .*\n", errors)
    assert list(tmp_path.iterdir()) == [tmp_path / "a.h5.partial"]


def test_closing_waits_for_nothing_that_is_being_solved():
    begun, gate, ended, told = threading.Event(), threading.Event(), [], []

    def work(number):
        if number > 0:
            begun.set()
            gate.wait(60.0)
            ended.append(number)
        return number

    blocks = in_threads(work, range(4), 1, lambda: told.append(True))
    assert next(blocks) == 0
    assert begun.wait(60.0)
    blocks.close()
    assert (ended, told) == ([], [True])
    gate.set()


def test_a_block_that_nobody_wants_ends_with_its_case(monkeypatch):
    evaluate = Evaluator(plan_from(drive(), {"friction": np.linspace(0.1, 0.3, 9)}, engine="ivp"))
    solved = []

    def stopped_meanwhile(escapement, **_):
        solved.append(escapement.friction)
        evaluate.stop()
        return Figures()

    monkeypatch.setattr(simulation, "terminal", stopped_meanwhile)
    with pytest.raises(CancelledError):
        evaluate(0, 9)
    assert len(solved) == 1
