"""A command that takes long says that it is at work."""

import io
import time

import pytest

from escapement.base import progress
from escapement.base.progress import Progress
from escapement.cli import _waiting


@pytest.fixture
def told(monkeypatch):
    """What a command that takes some time says on standard error."""

    def run(work, quiet=False, terminal=True, command="budget"):
        stream = io.StringIO()
        monkeypatch.delenv("ESCAPEMENT_QUIET", raising=False)
        monkeypatch.setattr(_waiting, "_PATIENCE", 0.05)
        monkeypatch.setattr(_waiting, "_AGAIN", 0.2)
        monkeypatch.setattr(progress, "stage", "")
        monkeypatch.setattr("sys.stderr", stream)
        monkeypatch.setattr("os.isatty", lambda _: terminal)
        with _waiting.shown(command, quiet):
            work()
        return stream.getvalue()

    return run


def work():
    time.sleep(0.15)
    progress.set_stage("worst case of period")
    time.sleep(0.5)


@pytest.mark.slow
def test_long_work_is_told_now_and_then(told):
    lines = told(work).splitlines()
    assert 2 <= len(lines) <= 4
    assert lines[0].startswith("escapement: budget, 0.")
    later = told(work, terminal=False).splitlines()
    assert 1 <= len(later) <= 3
    assert later[0].startswith("escapement: budget: worst case of period, 0.")
    assert lines[-1].startswith("escapement: budget: worst case of period, 0.")
    assert told(work, command="compile").splitlines()[-1].startswith("escapement: compile, 0.")


@pytest.mark.slow
def test_nothing_is_said_beside_a_bar_nor_of_short_or_quiet_work_nor_between_results(told):
    def counted():
        with Progress(io.StringIO()) as bar:
            bar(1, 2, 0)
            work()

    def printed():
        _waiting.end()
        work()

    assert told(counted) == told(printed) == told(lambda: None) == told(work, quiet=True) == ""
