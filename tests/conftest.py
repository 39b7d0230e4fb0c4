"""Fixtures of many tests: the command line, and calls that are counted or made to fail."""

import gc
import json
import os
import signal
import subprocess
import sys
from functools import partial

import pytest

import escapement as esc
from escapement.cli import main
from escapement.engines.energy import batch
from escapement.numerics.interpreted import compile_from_now_on
from escapement.numerics.jit import is_all_compiled
from escapement.outlines import part_files
from escapement.outlines.interference import least_gaps

# a shell's background jobs ignore Ctrl-C, and so would the processes that tests interrupt
signal.signal(signal.SIGINT, signal.default_int_handler)

# what is read of standard error, here and of processes, does not depend on what was compiled
os.environ["ESCAPEMENT_QUIET"] = "1"
# results are those of compiled kernels, here and in processes that tests start
os.environ["ESCAPEMENT_COMPILE"] = "1"
compile_from_now_on()

# what is collected lives to the end, so searching it for garbage again and again would be idle
gc.disable()


def pytest_collection_finish():
    """From now on garbage is that of tests."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


def pytest_configure(config):
    """Compile all once before several workers begin, each of which would compile the same."""
    workers = getattr(config.option, "numprocesses", None)
    if workers and not hasattr(config, "workerinput") and not is_all_compiled():
        loud = {name: x for name, x in os.environ.items() if name != "ESCAPEMENT_QUIET"}
        command = [sys.executable, "-m", "escapement", "compile"]
        subprocess.run(command, env=loud, stdout=subprocess.DEVNULL, check=True)


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Runs a command in an empty folder: (exit code, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)

    def run(*argv):
        code = main([str(word) for word in argv])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def report(command):
    """Runs a command that must succeed, with --json: its report."""

    def run(*argv):
        code, out, err = command(*argv, "--json")
        assert code == 0, err
        return json.loads(out)

    return run


@pytest.fixture
def few_angles(monkeypatch):
    """Gaps between bodies are looked for at few driver angles, which takes a seventh of the time.

    The gap between meshing teeth is the same at all angles but for the arcs that stand for them.
    """
    monkeypatch.setattr(part_files, "least_gaps", partial(least_gaps, samples=13))


@pytest.fixture
def refusal(command, tmp_path):
    """Runs a command that must end with a code, one line and no file touched: that line."""

    def files():
        return {path: path.lstat().st_mtime_ns for path in tmp_path.rglob("*")}

    def run(code, *argv):
        before = files()
        found, out, err = command(*argv)
        assert (found, out) == (code, ""), err
        assert err.startswith("escapement: error: ")
        assert err.count("\n") == 1
        assert files() == before
        return err

    return run


@pytest.fixture
def solves(monkeypatch):
    """How many scenes each call of the batch solver was given."""
    counted = []
    solve = batch.solve

    def count(mechanism, numbers, *rest):
        counted.append(numbers.shape[1])
        return solve(mechanism, numbers, *rest)

    monkeypatch.setattr(batch, "solve", count)
    return counted


@pytest.fixture(scope="session")
def compiled():
    """Both engines, ready to run: compiling them is not what a test waits for."""
    timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, friction=0.35)
    for engine in ("energy", "ivp"):
        esc.simulate(timer, 2, engine=engine).at(0.0)
        esc.terminal(timer, engine=engine)
    esc.sweep(timer, friction=[0.3])


@pytest.fixture
def patience(compiled):
    """No call may hang: twenty seconds of the processor, where the system can count them."""
    if not hasattr(signal, "SIGPROF"):
        yield
        return

    def stop(*_):
        raise TimeoutError("twenty seconds without an answer")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, 20.0)
    yield
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    signal.signal(signal.SIGPROF, before)
