"""A command that takes long says that it is at work."""

import io
import time

import pytest

from escapement.base import progress
from escapement.base.progress import Progress
from escapement.cli import _output, _waiting


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def told(monkeypatch):
    """What a command that takes some time says on standard error."""

    def run(stream, work, quiet=False):
        monkeypatch.delenv("ESCAPEMENT_QUIET", raising=False)
        monkeypatch.setattr(_waiting, "_PATIENCE", 0.05)
        monkeypatch.setattr(_waiting, "_REDRAW", 0.05)
        monkeypatch.setattr(_waiting, "_LINE", 0.2)
        monkeypatch.setattr(progress, "stage", "")
        monkeypatch.setattr("sys.stderr", stream)
        with _waiting.shown("budget", quiet):
            work()
        return stream.getvalue()

    return run


def work():
    time.sleep(0.15)
    progress.set_stage("worst case of period")
    time.sleep(0.5)


def test_a_terminal_shows_the_stage_and_the_time_and_is_left_clean(told):
    drawn = told(Terminal(), work).split("\r")
    assert any(text.startswith("escapement: budget, 0.") for text in drawn)
    assert any(text.startswith("escapement: budget: worst case of period, 0.") for text in drawn)
    assert drawn[-2].strip() == drawn[-1] == ""


def test_a_log_gets_a_line_now_and_then(told):
    lines = told(io.StringIO(), work).splitlines()
    assert 2 <= len(lines) <= 4
    assert lines[-1].startswith("escapement: budget: worst case of period, 0.")


def test_nothing_is_said_beside_a_bar_nor_of_short_or_quiet_work(told):
    def counted():
        with Progress(io.StringIO()) as bar:
            bar(1, 2, 0)
            work()

    assert told(io.StringIO(), counted) == ""
    assert told(io.StringIO(), lambda: None) == ""
    assert told(io.StringIO(), work, quiet=True) == ""


def test_nothing_is_drawn_between_results(told):
    stream = Terminal()

    def printed():
        time.sleep(0.2)
        _waiting.end()
        stream.write("RESULTS")
        time.sleep(0.2)

    assert told(stream, printed).endswith("RESULTS")


def test_a_note_has_a_line_of_its_own(told):
    stream = Terminal()

    def noted():
        time.sleep(0.2)
        _output.note("wrote a file")

    assert "\rescapement: wrote a file\n" in told(stream, noted)
