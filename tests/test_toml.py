"""TOML files: encodings that are read, and the line of a slip."""

import pytest

from escapement import load_plan
from escapement.base.errors import InputFileError
from escapement.base.toml_file import parse_toml, read_toml

STUDY = """units = "SI"
friction = 0.3
[mechanism]
slots = 4
[inertia]
driver = 3.39e-7
follower = 5.65e-6
[sweep]
torque = [0.008, 0.0113, 0.02]
"""
SLIPS = (
    *("friction = .3", "friction = 3.", "friction = 0,3", "torque = 5 mN m", "friction: 0.3"),
    *("friction .3", "internal = True", "kind = geneva"),
)


@pytest.mark.parametrize("line", SLIPS)
def test_a_slip_is_told_with_its_line_and_the_rules(line):
    text = f'title = "wrong below"\n\n{line}\n[mechanism]\nslots = 4\n'
    with pytest.raises(ValueError, match="got in line 3") as caught:
        parse_toml(text)
    assert str(caught.value).startswith(f"got in line 3: {line} (")
    assert "TOML asks for KEY = VALUE, " in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "friction = 0.3\nfriction = 0.4\n",
            "got in line 2: friction = 0.4 (Cannot",
        ),
        ("a = [1, 2\nb = ?\n", "got in line 2: b = ? ("),
        ("a = ?", "got in line 1: a = ? (Invalid value)"),
        ("a = " + "[" * 100_000, "nested too deeply"),
    ],
)
def test_another_error_is_told_with_its_line(text, told):
    with pytest.raises(ValueError, match="got") as caught:
        parse_toml(text)
    assert told in str(caught.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_study_is_read_in_the_usual_encodings(tmp_path, encoding):
    path = tmp_path / "study.toml"
    study = f'title = "Prüfung"\n{STUDY}'
    path.write_bytes(study.replace("\n", "\r\n").encode(encoding))
    assert load_plan(path).title == "Prüfung"


def test_byte_order_marks_of_joined_files_are_left_out(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("[", "\ufeff["), encoding="utf-8")
    with pytest.raises(InputFileError, match="got in line 9: torque = "):
        read_toml(path, "study file")  # a mark within a line is an error
    path.write_text(STUDY.replace("\n[", "\n\ufeff["), encoding="utf-8")
    assert load_plan(path).cases == 3
