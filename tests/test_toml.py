"""TOML files: encodings that are read, and the mended line after a usual slip."""

import pytest

from escapement import load_plan
from escapement.base.toml_file import parse_toml

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
SLIPS = {
    "friction = .3": "friction = 0.3",
    "friction = -.3": "friction = -0.3",
    "friction = 3.": "friction = 3.0",
    "friction = [.2, .25,.3]": "friction = [0.2, 0.25,0.3]",
    "a = { start = .08, stop = .14, num = 25 }": "a = { start = 0.08, stop = 0.14, num = 25 }",
    "friction = 0,3": "friction = 0.3",
    "friction = ,3": "friction = 0.3",
    "torque = −0.1": "torque = -0.1",
    "torque = 5 mN m": 'torque = "5 mN m"',
    "torque = .1 in-lbf  # weak": 'torque = "0.1 in-lbf" # weak',
    "crank_radius = 12mm": 'crank_radius = "12mm"',
    "friction: 0.3": "friction = 0.3",
    "friction .3": "friction = 0.3",
    "internal = True": "internal = true",
    "kind = geneva": 'kind = "geneva"',
    "kind = gear-driven": 'kind = "gear-driven"',
    "units = “SI”": 'units = "SI"',
    r'file = "C:\users\curve.csv"': r"file = 'C:\users\curve.csv'",
}


@pytest.mark.parametrize("line", SLIPS)
def test_a_slip_is_told_with_its_line_and_the_mended_one(line):
    text = f'title = "wrong below"\n\n{line}\n[mechanism]\nslots = 4\n'
    with pytest.raises(ValueError, match="got in line 3") as caught:
        parse_toml(text)
    assert str(caught.value).startswith(f"got in line 3: {line}; TOML asks for ")
    assert str(caught.value).endswith(f": write {SLIPS[line]}")
    assert parse_toml(text.replace(line, SLIPS[line]))["mechanism"] == {"slots": 4}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "friction = 0.3\nfriction = 0.4\n",
            "got in line 2: friction = 0.4; correct it there (Cannot",
        ),
        ("a = [1, 2\nb = ?\n", "correct it there"),
        ("a = ?", "got in line 1: a = ?; correct it there (Invalid value)"),
        ("a = " + "[" * 100_000, "nested too deeply"),
    ],
)
def test_another_error_is_told_with_its_line(text, told):
    with pytest.raises(ValueError, match="got") as caught:
        parse_toml(text)
    assert told in str(caught.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_study_is_read_in_any_encoding_that_marks_itself(tmp_path, encoding):
    path = tmp_path / "study.toml"
    path.write_bytes(STUDY.replace("\n", "\r\n").encode(encoding))
    assert load_plan(path).cases == 3
