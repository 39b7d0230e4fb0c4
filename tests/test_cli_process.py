"""Command line as a process: the modules that it loads, signals, and closed pipes."""

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import escapement as esc
from escapement import cli
from study_tools import IVP_STUDY

ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(esc.__file__).parents[1])}
PROGRAM = [sys.executable, "-m", "escapement"]
LONG_STUDY = IVP_STUDY.replace("num = 40", "num = 10000")


def ended(*words, program=PROGRAM, environment=ENVIRONMENT, **options):
    """A process that came to its end, with what it said as text."""
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True} | options
    return subprocess.run([*program, *words], env=environment, **given)


def code(text, *words):
    return ended("-c", text, *words, program=[sys.executable])


HELP = """
import sys
from escapement.cli import COMMANDS, main
for words in ([], *([name] for name in COMMANDS)):
    code = main([*words, "--help"])
    heavy = {"numpy", "scipy", "numba", "matplotlib", "h5py"} & set(sys.modules)
    if heavy or code:
        sys.exit(f"{words}: {code}, {heavy}")
"""


def test_help_loads_nothing_heavy():
    done = code(HELP)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("usage: escapement") == 1 + len(cli.COMMANDS)


def test_module_runs_as_the_script_does():
    assert ended("--version").stdout == f"escapement {esc.__version__}\n"


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX pipes")
def test_reader_that_leaves_early_is_no_error():
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as pipe:
        done = ended("mechanism", stdout=pipe)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_output_that_cannot_be_written():
    with open("/dev/full", "wb") as full:
        done = ended("mechanism", stdout=full)
    assert done.returncode == 74
    assert done.stderr.startswith("escapement: error: input or output failed: ")
    assert done.stderr.count("\n") == 1


LOADING = """
import os, signal, sys
class Finder:
    def find_spec(self, name, *_):
        if name == "numpy":
            try:
                os.kill(os.getpid(), signal.%s)
            except KeyboardInterrupt:
                raise ImportError("numpy") from None
sys.meta_path.insert(0, Finder())
from escapement.cli import program
program()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("name", "number", "said"), [("SIGINT", 130, "interrupted"), ("SIGTERM", 143, "terminated")]
)
def test_a_signal_while_a_library_is_loaded(name, number, said):
    """NumPy makes another error of it."""
    done = code(LOADING % name, "mechanism", "--slots", "5")
    assert (done.returncode, done.stderr) == (number, f"escapement: error: {said}\n")


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_interrupted_sweep_leaves_nothing(tmp_path):
    (tmp_path / "long.toml").write_text(LONG_STUDY)
    arguments = [*PROGRAM, "sweep", "long.toml", "--quiet"]
    with subprocess.Popen(
        arguments, cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True
    ) as process:
        while process.poll() is None and len(list(tmp_path.iterdir())) == 1:
            time.sleep(0.05)
        time.sleep(0.5)  # some case is being solved, and its block would take half a minute
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=10.0)
    assert process.returncode == 130
    assert err == "escapement: error: interrupted\n"
    assert [path.name for path in tmp_path.iterdir()] == ["long.toml"]


@pytest.mark.slow
def test_letters_that_the_terminal_lacks():
    """They are shown by their numbers."""
    done = ended("reproduce", "filemon", environment=ENVIRONMENT | {"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, "")
    assert "\\u" in done.stdout or "\\x" in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use cannot be removed there")
@pytest.mark.parametrize("arguments", [["mechanism", "--plot", "a.png"], ["sweep", "{}/s.toml"]])
def test_working_directory_that_was_removed(tmp_path, arguments):
    (tmp_path / "s.toml").write_text(IVP_STUDY)
    (tmp_path / "gone").mkdir()
    words = [shlex.quote(word.format(tmp_path)) for word in [*PROGRAM, *arguments]]
    line = f"cd gone && rmdir ../gone && {' '.join(words)}"
    done = ended("-c", line, program=["sh"], cwd=tmp_path)
    assert done.returncode == 73
    assert "cannot be created: No such file or directory" in done.stderr
    assert done.stderr.count("\n") == 1
