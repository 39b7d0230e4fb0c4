"""What the README shows is what happens."""

import re
import shlex
from pathlib import Path

import pytest

from escapement.cli import main

README = Path(__file__).parents[1] / "README.md"
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
CONSOLE = [text for kind, text in BLOCKS if kind == "console"]


def agrees(found: str, shown: str) -> bool:
    """Whether the lines are those shown; "..." stands for any that follow."""
    lines, expected = found.splitlines(), shown.splitlines()
    if expected[-1] == "...":
        expected.pop()
        lines = lines[: len(expected)]
    return lines == expected


@pytest.mark.parametrize("text", CONSOLE, ids=[text.split("\n")[0][2:26] for text in CONSOLE])
def test_console_example(text, capsys, monkeypatch):
    monkeypatch.chdir(README.parent)
    line, shown = text.split("\n", 1)
    program, *argv = shlex.split(line.removeprefix("$ "))
    assert program == "escapement"
    main(argv)
    assert agrees(capsys.readouterr().out, shown)


def test_python_example(capsys):
    (code,) = [text for kind, text in BLOCKS if kind == "python"]
    (shown,) = [text for kind, text in BLOCKS if kind == "text"]
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out == shown


def test_two_command_lines():
    install, test = [text.strip() for kind, text in BLOCKS if kind == "sh"]
    for line in (install, test):
        assert "\n" not in line
        assert line.startswith("python3.11 -m venv .venv && .venv/bin/pip install ")
    assert test.endswith("&& .venv/bin/pytest")
