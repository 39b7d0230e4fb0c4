"""The command line as a test sees it: a call in an empty folder, its report, its refusal."""

import json

import pytest

from escapement.cli import main


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
def refusal(command, tmp_path):
    """Runs a command that must end with a code, one line and no file touched: that line."""

    def files():
        return {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}

    def run(code, *argv):
        before = files()
        found, out, err = command(*argv)
        assert (found, out) == (code, ""), err
        assert err.startswith("escapement: error: ")
        assert err.count("\n") == 1
        assert files() == before
        return err

    return run
