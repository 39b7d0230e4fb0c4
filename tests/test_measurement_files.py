"""Measurements as files: whatever a CSV holds is read, or refused with its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import escapement as esc
from escapement import measurement
from escapement.base.errors import CannotCreate, InputFileError, InvalidValue
from measurement_tools import PRIKHODKO as DRIVE

ANGLES = np.linspace(0.0, 900.0, 61)
ROWS = [(f"{a:.4f}", f"{0.5 * a:.4f}") for a in ANGLES]


def text(rows=ROWS, head="input_deg,output_deg", between=",", end="\n"):
    lines = ([head] if head else []) + [between.join(row) for row in rows]
    return end.join(lines) + end


@pytest.fixture
def file(tmp_path):
    def write(content):
        path = tmp_path / "data.csv"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


def check(readings, missing=0):
    """The readings are those of `ROWS`."""
    keep = readings.complete
    assert readings.missing == missing
    np.testing.assert_allclose(np.degrees(readings.input[keep]), ANGLES[keep], atol=1e-4)
    np.testing.assert_allclose(np.degrees(readings.output[keep]), 0.5 * ANGLES[keep], atol=1e-4)


COMMA = [tuple(field.replace(".", ",") for field in row) for row in ROWS]
SWAPPED = [(b, a) for a, b in ROWS]
GOOD = {
    "comma": text(),
    "semicolon": text(between=";", head="input;output"),
    "tab": text(between="\t", head="Input (deg)\tOutput (deg)"),
    "blanks": text(between="  ", head="input output"),
    "blanks at the end": text(between="   ", head="input output ", end=" \n"),
    "decimal comma": text(COMMA, between=";", head="input;output"),
    "decimal comma after a tab": text(COMMA, between="\t", head="input\toutput"),
    "no header": text(head=None),
    "other order": text(SWAPPED, head="output_deg,input_deg"),
    "other names": text(SWAPPED, head="follower [°],Driver [°]"),
    "more columns": text([("x", a, "", b) for a, b in ROWS], head="note,input,t,output"),
    "windows": text(end="\r\n"),
    "old mac": text(end="\r"),
    "byte order mark": "\ufeff" + text(),
    "comments": "# made today\n\n" + text().replace("\n30.0000", "\n# pause\n\n30.0000"),
    "no last line end": text().rstrip("\n"),
    "quotes": text([(f'"{a}"', f'"{b}"') for a, b in ROWS], head='"input_deg","output_deg"'),
    "blanks inside": text([(f" {a} ", f"\t{b}") for a, b in ROWS], between=","),
    "exponents": text([(f"{float(a):.8e}", f"{float(b):.8E}") for a, b in ROWS]),
}


@pytest.mark.parametrize("content", GOOD.values(), ids=GOOD)
def test_what_is_understood(file, content):
    check(esc.read_readings(file(content)))


def test_columns_and_units_by_name_or_by_wish(file):
    rows = [tuple(repr(float(np.radians(float(field)))) for field in row) for row in ROWS]
    check(esc.read_readings(file(text(rows, head="input_rad,output (rad)"))))
    path = file(text(rows, head="input,output"))
    check(esc.read_readings(path, angle_unit="rad"))
    mixed = [(a, b) for (a, _), (_, b) in zip(ROWS, rows, strict=True)]
    check(esc.read_readings(file(text(mixed, head="input,output_rad"))))
    path = file(text([(a, a, b, b) for a, b in ROWS], head="in A,in B,out A,out B"))
    check(esc.read_readings(path, input="in B", output="out A"))


@pytest.mark.parametrize("head", ["input,output", "input_deg,output", None])
def test_degrees_are_not_assumed_in_silence(file, head):
    path, said = file(text(head=head)), "the angles have no unit and are taken as degrees"
    assert esc.read_readings(path).remark == said
    assert said in esc.measure(path, DRIVE).message
    assert esc.read_readings(path, angle_unit="deg").remark == ""
    assert esc.read_readings(file(text())).remark == ""


@pytest.mark.parametrize("unit", ["grad", "mrad", "µrad", "arcmin"])
def test_a_foreign_unit_is_not_taken_for_degrees(file, unit):
    path = file(text(head=f"shaft_{unit},wheel_{unit}"))
    names = {"input": f"shaft_{unit}", "output": f"wheel_{unit}"}
    with pytest.raises(InputFileError, match=f"degrees or radians, got 'shaft_{unit}"):
        esc.read_readings(path, **names)
    check(esc.read_readings(path, **names, angle_unit="deg"))


@pytest.mark.parametrize("nothing", ["", "nan", "NaN", "NA", "null", " "])
def test_missing_readings(file, nothing):
    rows = list(ROWS)
    rows[7], rows[9] = (nothing, rows[7][1]), (rows[9][0], nothing)
    check(esc.read_readings(file(text(rows))), missing=2)


def test_lines_are_those_of_the_file(file):
    readings = esc.read_readings(file("# one\n" + text() + "\n\n# end\n"))
    np.testing.assert_array_equal(readings.line, np.arange(3, 64))
    assert not readings.synthetic


def put(line, row):
    """A good file with another line in it; line 1 is the header."""
    lines = text().splitlines()
    lines[line - 1] = row
    return "\n".join(lines) + "\n"


BAD = {
    "other separator": (put(5, "45.0;22.5"), "line 5", "2 fields", "','", "'45.0;22.5'"),
    "decimal comma": (put(5, "45,0,22,5"), "line 5", "2 fields", "'45,0,22,5'"),
    "text": (put(62, "x1,2"), "line 62", "numbers in fields 1 and 2", "'x1,2'"),
    "underscore": (put(3, "1_5,7"), "line 3", "numbers in fields", "'1_5,7'"),
    "infinite": (put(9, "inf,1"), "line 9", "within 1e10 turns", "inf rad"),
    "far away": (put(9, "1e300,1"), "line 9", "input must be within 1e10 turns"),
    "short row": (put(9, "1"), "line 9", "2 fields", "'1'"),
    "second header": (put(9, "input_deg,output_deg"), "line 9", "'input_deg,output_deg'"),
    "long row": (put(9, "1,2" * 99), "line 9", "..."),
    "one column": (text([(a,) for a, _ in ROWS], head="input"), "line 1", "two columns"),
    "three columns of numbers": (text([(a, a, b) for a, b in ROWS], head=None), "line 1", "name"),
    "unknown names": (text(head="x,y"), "line 1", "input or in or driver", "'x,y'"),
    "ambiguous": (text(head="input,in"), "line 1", "one column", "'input,in'"),
    "empty": ("", "must hold rows of angles"),
    "header only": ("input,output\n", "must hold rows of angles"),
    "few rows": (text(ROWS[:19]), "at least 20", "got 19 of 19"),
    "nothing but NaN": (text([("nan", "nan")] * 50), "got 0 of 50"),
    "standstill": (text([("1", "2")] * 50), "input must turn"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\x00", "line 1 must have two columns", "PNG"),
    "zeros in text": (text().encode().replace(b"\n45", b"\n\x0045"), "line 5", "\\x00"),
    "other code": (put(4, "30,15 \xb0").encode("latin-1"), "line 4", "numbers in fields", "15 °"),
}


@pytest.mark.parametrize(("content", "said"), [(c, s) for c, *s in BAD.values()], ids=BAD)
def test_what_is_not_understood(file, content, said):
    with pytest.raises(InputFileError) as caught:
        esc.read_readings(file(content))
    message = str(caught.value)
    assert [words for words in ("data.csv", *said) if words not in message] == []
    assert "\n" not in message
    assert len(message) < 300


@pytest.mark.parametrize("damaged", [5, 40])
def test_a_long_row_is_not_made_good_by_a_short_one(file, damaged):
    rows = [f"{i},{a},{b},20" for i, (a, b) in enumerate(ROWS)]
    rows[damaged] = f"{damaged},5,{','.join(ROWS[damaged])},20"
    rows[20] = rows[20].removesuffix(",20")
    content = "\n".join(["time_s,input_deg,output_deg,temp", *rows]) + "\n"
    with pytest.raises(InputFileError, match=f"line {min(damaged, 20) + 2} must have 4 fields"):
        esc.read_readings(file(content))


GOOD_BYTES = text().encode()


@settings(
    deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    cuts=st.lists(
        st.tuples(
            st.integers(0, len(GOOD_BYTES)),
            st.integers(0, 30),
            st.one_of(st.binary(max_size=12), st.text('0123456789.,;-+eE#"\n\r nai', max_size=12)),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_whatever_happens_to_a_file_it_is_read_or_refused_in_one_line(file, cuts):
    content = GOOD_BYTES
    for place, length, new in cuts:
        piece = new if isinstance(new, bytes) else new.encode()
        content = content[:place] + piece + content[place + length :]
    try:
        readings = esc.read_readings(file(content))
    except (InputFileError, InvalidValue) as error:
        message = str(error)
    else:
        assert readings.input.shape == readings.output.shape == readings.line.shape
        assert (np.diff(readings.line) > 0).all()
        message = "data.csv"
    assert "\n" not in message
    assert "data.csv" in message


def test_wrong_names_and_units(file):
    path = file(text())
    with pytest.raises(InvalidValue, match="different columns"):
        esc.read_readings(path, input="input", output="input")
    with pytest.raises(InvalidValue, match="angle_unit must be one of deg, rad"):
        esc.read_readings(path, angle_unit="degrees")
    with pytest.raises(InputFileError, match="line 1 must name its 2 columns"):
        esc.read_readings(file(text(head=None)), input="input")


def test_written_readings_come_back(tmp_path):
    readings = esc.synthetic_readings(
        DRIVE, seed=4, noise=0.01, missing=0.1, encoder=esc.Encoder(4096)
    )
    path = tmp_path / "made.csv"
    esc.write_readings(readings, path, note="seed 4\n4096 counts")
    first, second, third = path.read_text().splitlines()[:3]
    assert first.startswith("# synthetic")
    assert (second, third) == ("# seed 4", "# 4096 counts")
    again = esc.read_readings(path)
    assert again.synthetic
    np.testing.assert_allclose(again.input, readings.input, atol=1e-8)
    np.testing.assert_allclose(again.output, readings.output, atol=1e-8)
    with pytest.raises(CannotCreate):
        esc.write_readings(readings, path)
    esc.write_readings(esc.Readings(readings.input, readings.output), path, force=True)
    assert "synthetic" not in path.read_text()
    assert not esc.read_readings(path).synthetic


def test_readings_of_the_documentation_are_those_it_says():
    path = Path(__file__).parents[1] / "runs" / "encoder_synthetic.csv"
    kept = esc.read_readings(path)
    made = esc.synthetic_readings(
        DRIVE, seed=2020, samples=148, turns=3.0, encoder=esc.Encoder(4096),
        noise=np.radians(0.9), output_eccentricity=np.radians(1.0), phase=np.radians(20.0),
        offset=np.radians(-50.0), sense=-1, missing=0.02,
    )  # fmt: skip
    assert kept.synthetic
    np.testing.assert_allclose(kept.input, made.input, atol=1e-8)
    np.testing.assert_allclose(kept.output, made.output, atol=1e-8)


def test_errors_as_a_table(tmp_path):
    result = esc.measure(esc.synthetic_readings(DRIVE, seed=4, noise=0.01, missing=0.1), DRIVE)
    measurement.write_errors(result, tmp_path / "errors.csv")
    lines = (tmp_path / "errors.csv").read_text().splitlines()
    assert lines[0].startswith("# synthetic")
    assert lines[1] == "input_deg,output_deg,theory_deg,error_deg"
    table = np.loadtxt(lines[2:], delimiter=",")
    np.testing.assert_allclose(table[:, 3], np.degrees(result.errors), atol=6e-7)
    np.testing.assert_allclose(table[:, 1] - table[:, 2], table[:, 3], atol=2e-6)
