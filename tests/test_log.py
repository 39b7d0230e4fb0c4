"""What a command does, as JSON lines for job scripts."""

import io
import json
import warnings

import pytest

from escapement.cli import _log
from study_tools import IVP_STUDY

STUDY = IVP_STUDY.replace("num = 40", "num = 3").replace('"ivp"', '"energy"')


@pytest.fixture
def logged(command, tmp_path):
    """Runs a command with --log: its exit code and the lines it adds."""
    (tmp_path / "s.toml").write_text(STUDY)
    path, known = tmp_path / "log.jsonl", 0

    def run(*argv):
        nonlocal known
        code, _, err = command(*argv, "--log", path)
        lines = path.read_text(encoding="utf-8").splitlines()
        added, known = [json.loads(line) for line in lines[known:]], len(lines)
        assert all(line["time"].endswith("+00:00") for line in added)
        return code, added, err

    return run


def test_a_study_from_start_to_end_and_once_more(logged):
    code, lines, _ = logged("sweep", "s.toml", "--quiet")
    begun, *shown, saved, note, end = lines
    assert code == 0
    assert (begun["event"], begun["arguments"][:2]) == ("start", ["sweep", "s.toml"])
    assert [line["event"] for line in shown] == ["progress"] * len(shown)
    assert {"done": 3, "total": 3, "failed": 0}.items() <= shown[-1].items()
    assert shown[-1]["rate"] > 0.0
    assert (saved["event"], saved["file"]) == ("saved", "s.h5")
    assert (note["event"], note["message"]) == ("note", "3 cases in s.h5")
    assert (end["event"], end["exit_code"]) == ("end", 0)
    assert end["seconds"] >= 0.0
    # a job that is put in the queue again adds to its log
    code, lines, err = logged("sweep", "s.toml")
    assert [line["event"] for line in lines] == ["start", "error", "end"]
    assert err == f"escapement: error: {lines[1]['message']}\n"
    assert code == lines[2]["exit_code"] == 73


def test_other_commands_tell_what_they_saved(logged):
    model = ("--torque", 0.01, "--driver-inertia", 3e-7, "--follower-inertia", 6e-6)
    _, lines, _ = logged("run", *model, "--friction", 0.3, "-o", "m.h5", "--plot", "m.png")
    events = [line["event"] for line in lines]
    # the energy is balanced first, because it may change the status in the file
    assert events == ["start", "progress", "progress", "saved", "saved", "end"]
    assert [line["file"] for line in lines[3:5]] == ["m.h5", "m.png"]


def test_a_warning_is_logged(logged, monkeypatch):
    def warn(_path):
        warnings.simplefilter("always")
        warnings.warn("of a\nlibrary", stacklevel=1)
        raise MemoryError

    monkeypatch.setattr("escapement.load_plan", warn)
    _, lines, _ = logged("sweep", "s.toml")
    assert [(line["event"], line.get("message")) for line in lines[1:2]] == [
        ("warning", "of a library")
    ]
    assert lines[-1]["exit_code"] == 74


@pytest.mark.parametrize("content", [b"units = 'SI'\n", b"\x89HDF\r\n"])
def test_another_file_is_no_log(refusal, tmp_path, content):
    (tmp_path / "other").write_bytes(content)
    said = refusal(73, "mechanism", "--log", "other")
    assert "log other must be new or a log, got another file; name another" in said


def test_a_log_that_fails_does_not_end_the_work(logged, monkeypatch):
    class Full(io.StringIO):
        def write(self, _):
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(_log, "open", lambda *_, **__: Full(), raising=False)
    monkeypatch.setattr("pathlib.Path.read_text", lambda *_, **__: "")
    code, _, err = logged("mechanism")
    assert (code, err) == (0, "escapement: warning: the log ends here: No space left on device\n")
