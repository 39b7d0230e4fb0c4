"""`escapement measure`: its report, its files, and one line for each mistake."""

import json
import math
import re

import pytest

import escapement as esc
from escapement.base.columns import NAMES
from measurement_tools import DEG
from measurement_tools import PRIKHODKO as DRIVE

KIND = ["elliptical-planetary", "--sun-radius", ".016", "--planet-radius", ".009"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder with readings of the planetary drive and of a Geneva wheel, and others."""
    monkeypatch.chdir(tmp_path)
    readings = esc.synthetic_readings(
        DRIVE, seed=7, samples=300, turns=4.5, noise=0.5 * DEG, output_eccentricity=0.5 * DEG,
        phase=12 * DEG, offset=30 * DEG, sense=-1, missing=0.02, encoder=esc.Encoder(4096),
    )  # fmt: skip
    esc.write_readings(readings, "planetary.csv")
    wheel = esc.synthetic_readings(esc.Geneva(4), seed=7, noise=0.1 * DEG)
    esc.write_readings(esc.Readings(wheel.input, wheel.output), "geneva.csv")
    (tmp_path / "broken.csv").write_text("input,output\n1,2\n3;4\n")
    (tmp_path / "there.csv").write_text("mine")
    (tmp_path / "folder").mkdir()
    return tmp_path


@pytest.fixture
def measure(command):
    """Runs the command: its report, and what it remarks on stderr."""

    def run(*argv):
        code, out, err = command("measure", *argv, "--json")
        assert code == 0, err
        return json.loads(out), err

    return run


def test_report(measure):
    found, err = measure("planetary.csv", *KIND, "--resolution", "4096", "--linearity", ".003")
    result = esc.measure("planetary.csv", DRIVE, encoder=esc.Encoder(4096, 0.003))
    assert found["samples"] == result.errors.size == 300 - found["missing"]
    assert found["synthetic"] is True
    assert found["sense"] == -1
    assert found["phase_deg"] == pytest.approx(12.0, abs=4 * found["phase_error_deg"])
    assert found["offset_deg"] == pytest.approx(30.0, abs=4 * found["offset_error_deg"])
    assert found["standard_deviation_deg"] == pytest.approx(math.degrees(result.standard_deviation))
    lists = [found[key] for key in ("observed", "expected", "bin_edges_deg")]
    assert [found["bins"], *map(len, lists)] == [10, 10, 10, 11]
    assert sum(found["observed"]) == found["samples"]
    tests = ("chi_squared_published", "anderson_darling")
    assert [found[test]["degrees_of_freedom"] for test in tests] == [7, None]
    assert found["anderson_darling"]["p_value"] == float(result.anderson_darling_test.p_value)
    (once,) = [e for e in found["shaft_errors"] if (e["shaft"], e["order"]) == ("output", 1)]
    assert once["amplitude_deg"] == pytest.approx(0.5, abs=4 * once["standard_error_deg"])
    assert found["periodogram_peak"]["false_alarm_probability"] < 1e-6
    share = math.degrees(result.sensor_share.standard)
    assert found["sensor"]["standard_deg"] == pytest.approx(share)
    low, high = found["interval_deg"]
    assert low == pytest.approx(-high)
    assert err == f"escapement: {result.message}\n"
    assert "synthetic data" in err
    assert "once a turn of the output" in found["verdict"]
    assert not found["good"]


def test_the_kind_may_stand_after_an_option(measure):
    assert measure("planetary.csv", *KIND[1:], KIND[0]) == measure("planetary.csv", *KIND)


def test_units_change_lengths_only(measure):
    inches = ["--sun-radius", str(0.016 / 0.0254), "--planet-radius", str(0.009 / 0.0254)]
    a, _ = measure("planetary.csv", *KIND)
    b, _ = measure("planetary.csv", KIND[0], *inches, "--units", "in-lbf-s")
    assert b["standard_deviation_deg"] == pytest.approx(a["standard_deviation_deg"], rel=1e-9)
    assert b["sensor"] is None


def test_default_kind_known_zeros_and_classes(measure):
    found, err = measure(
        "geneva.csv", "--phase", "0", "--offset", "-.1", "--bins", "6",
        "--confidence", ".9",
    )  # fmt: skip
    assert err == ""
    assert found["synthetic"] is False
    assert (found["phase_deg"], found["phase_error_deg"]) == (0.0, 0.0)
    assert found["mean_deg"] == pytest.approx(0.1, abs=0.05)
    assert found["bins"] == 6
    half = 1.6448536 * found["standard_deviation_deg"]
    assert found["interval_deg"][1] - found["mean_deg"] == pytest.approx(half)
    assert found["message"] == ""


def test_a_reading_far_out_and_shafts_not_judged_are_in_the_message(measure):
    once = esc.synthetic_readings(DRIVE, samples=2000, turns=0.9, noise=1e-3, seed=4)
    once.output[77] += 0.5
    esc.write_readings(once, "far_out.csv", force=True)
    found, err = measure("far_out.csv", *KIND)
    assert found["chi_squared_published"]["statistic"] is None
    (away,) = re.findall(r"error of 28\.6 degrees is (\d+) standard deviations", found["message"])
    assert int(away) == round(found["error_max_deg"] / found["standard_deviation_deg"])
    silent = {e["shaft"] for e in found["shaft_errors"] if e["p_value"] is None}
    assert silent == {"input", "output"}
    assert "repeat with the input and the output are not judged" in found["message"]
    assert found["message"] in err


def test_table_says_what_json_says(measure, command):
    found, _ = measure("planetary.csv", *KIND)
    out = command("measure", "planetary.csv", *KIND)[1]
    values = [found["standard_deviation_deg"], found["anderson_darling"]["p_value"]]
    values += [
        wave["amplitude_deg"] for wave in (found["periodogram_peak"], *found["shaft_errors"])
    ]
    assert [value for value in values if f"{value:.6g}" not in out] == []


def test_files(command, folder):
    words = ("measure", "planetary.csv", *KIND, "-o", "e.csv")
    assert command(*words, "--plot", "e.png")[0] == 0
    lines = (folder / "e.csv").read_text().splitlines()
    assert lines[0].startswith("# synthetic")
    assert (folder / "e.png").read_bytes().startswith(b"\x89PNG")
    assert command(*words)[0] == 73
    assert command(*words, "--force")[0] == 0


def test_the_help_has_the_usual_names_of_columns(command):
    usual = {name for names in NAMES.values() for name in names}
    assert usual <= set(re.findall(r"\w+", command("measure", "--help")[1]))


WRONG = {
    "no file": ([], 2, "DATA"),
    "missing": (["none.csv"], 66, "none.csv does not exist"),
    "folder": (["folder"], 65, "readable text file"),
    "broken": (["broken.csv"], 65, "broken.csv, line 3 must have 2 fields"),
    "no radii": (["planetary.csv", KIND[0]], 2, "--sun-radius, --planet-radius"),
    "unknown column": (["geneva.csv", "--input-column", "x"], 2, "input column", "deg, ", "'x'"),
    "unknown unit": (["geneva.csv", "--angle-unit", "gon"], 2, "--angle-unit", "deg, rad"),
    "one zero": (["geneva.csv", "--phase", "3"], 2, "--phase must come with --offset"),
    "bins": (["geneva.csv", "--bins", "sturgess"], 2, "did you mean 'sturges'?"),
    "few bins": (["geneva.csv", "--bins", "-3"], 2, "bins must be", "at least 4", "got -3"),
    "sure": (["geneva.csv", "--confidence", "1"], 2, "confidence must be", "between 0 and 1"),
    "resolution": (["geneva.csv", "--resolution", "1"], 2, "--resolution", "at least 2"),
    "linearity alone": (["geneva.csv", "--linearity", ".003"], 2, "--resolution N"),
    "force": (["geneva.csv", "--force"], 2, "--force must come with --output FILE.csv"),
    "there": (["geneva.csv", "-o", "there.csv"], 73, "there.csv", "--force"),
    "over itself": (["geneva.csv", "-o", "geneva.csv", "--force"], 73, "must not be geneva.csv"),
    "nowhere": (["geneva.csv", "-o", "none/e.csv"], 73, "none"),
    "twice the same": (["geneva.csv", "-o", "e.png", "--plot", "./e.png"], 73, "must not be e.png"),
    "no picture": (["geneva.csv", "--plot", "e.txt"], 2, ".png, .pdf, .svg"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("argv", "code", "said"), [(a, c, s) for a, c, *s in WRONG.values()], ids=WRONG
)
def test_wrong(refusal, argv, code, said):
    line = refusal(code, "measure", *argv)
    assert [words for words in said if words not in line] == []
