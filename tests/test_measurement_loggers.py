"""Files as loggers write them: units and forms of time, encodings, and counters of few bits."""

import codecs

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InputFileError, InvalidValue
from escapement.measurement.loggers import spread
from measurement_tools import DEG

ANGLES = np.linspace(0.0, 900.0, 61)
SECONDS = 0.01 * np.arange(61)
HEAD = "input_deg,output_deg"


@pytest.fixture
def file(tmp_path):
    def write(head, stamps, encoding="utf-8", between=","):
        rows = (
            between.join((stamp, f"{a:.4f}", f"{a / 2:.4f}"))
            for stamp, a in zip(stamps, ANGLES, strict=True)
        )
        path = tmp_path / "data.csv"
        path.write_bytes(("\n".join([head, *rows]) + "\n").encode(encoding))
        return path

    return write


UNITS = {
    "time_ms": 1e-3, "millis": 1e-3, "time (milliseconds)": 1e-3, "t [us]": 1e-6, "micros": 1e-6,
    "timestamp_ns": 1e-9, "minutes": 60.0, "time_min": 60.0, "t_h": 3600.0, "time [s]": 1.0,
    "time (\u00b5s)": 1e-6, "time (\u03bcs)": 1e-6, "t_seconds": 1.0,
}  # fmt: skip


@pytest.mark.parametrize(("head", "size"), UNITS.items(), ids=UNITS)
def test_units_of_time(file, head, size):
    stamps = [f"{second / size:.12g}" for second in SECONDS]
    readings = esc.read_readings(file(f"{head},{HEAD}", stamps), time="time")
    np.testing.assert_allclose(readings.time, SECONDS, atol=1e-9)
    assert readings.remark == ""


def test_a_unit_of_time_that_is_not_given_is_said_and_may_be_given(file):
    path = file(f"time,{HEAD}", [f"{1e3 * second:.9g}" for second in SECONDS])
    readings = esc.read_readings(path, time="time")
    assert readings.remark == "the times have no unit and are taken as seconds"
    given = esc.read_readings(path, time="time", time_unit="ms")
    np.testing.assert_allclose(given.time, SECONDS)
    assert given.remark == ""
    with pytest.raises(InvalidValue, match="time_unit must be one of s, ms, us, ns, min, h"):
        esc.read_readings(path, time="time", time_unit="days")
    path = file(f"time_days,{HEAD}", [f"{second:g}" for second in SECONDS])
    with pytest.raises(InputFileError, match=r"line 1 must have times in s, ms.*--time-unit"):
        esc.read_readings(path, time="time")
    assert esc.read_readings(path, time="time_days", time_unit="s").time[-1] == SECONDS[-1]


CLOCKS = {
    "date": lambda s: f"2026-11-25T19:59:{59.5 + s:09.6f}" if s < 0.495 else
    f"2026-11-25T20:00:{s - 0.5 + 1e-9:09.6f}",
    "blank and zone": lambda s: f"2026-11-25 19:59:{s:09.6f}Z",
    "midnight": lambda s: f"23:59:{59.5 + s:06.3f}" if s < 0.495 else
    f"00:00:{s - 0.5 + 1e-9:06.3f}",
    "minutes": lambda s: f"12:{s:06.3f}",
}  # fmt: skip


@pytest.mark.parametrize("written", CLOCKS.values(), ids=CLOCKS)
def test_times_of_day_and_dates(file, written):
    path = file(f"time,{HEAD}", [written(second) for second in SECONDS])
    readings = esc.read_readings(path, time="time")
    np.testing.assert_allclose(readings.time - readings.time[0], SECONDS, atol=1e-6)
    assert readings.remark == ""


DOUBTFUL = {
    "two parts": ([f"12:{i:02d}" for i in range(61)], ",", "19:13:03.25 or 2026-11-25T19:13:03"),
    "other dates": ([f"11/25/2026 1:00:{i % 60}" for i in range(61)], ",", "2026-11-25T19:13:03"),
    "two words": ([f"2026-11-25 1:00:{i % 60}" for i in range(61)], " ", "date and time as one"),
}


@pytest.mark.parametrize(("stamps", "between", "said"), DOUBTFUL.values(), ids=DOUBTFUL)
def test_times_that_are_not_read_have_a_remedy(file, stamps, between, said):
    head = f"time,{HEAD}".replace(",", between)
    with pytest.raises(InputFileError, match=f"line 2 must .*{said}"):
        esc.read_readings(file(head, stamps, between=between), time="time")


ROWS_OF_UNITS = {
    "plain": ("time,input,output", "ms,deg,deg"),
    "brackets": ("time,input,output", "[ms],(deg),[\u00b0]"),
}


@pytest.mark.parametrize(("head", "units"), ROWS_OF_UNITS.values(), ids=ROWS_OF_UNITS)
def test_a_row_of_units_below_the_names(file, head, units):
    stamps = [f"{1e3 * second:.9g}" for second in SECONDS]
    readings = esc.read_readings(file(f"{head}\n{units}", stamps), time="time")
    np.testing.assert_allclose(readings.time, SECONDS)
    np.testing.assert_allclose(np.degrees(readings.input), ANGLES, atol=1e-4)
    assert readings.remark == ""
    assert readings.line[0] == 3
    with pytest.raises(InputFileError, match="line 1 must have angles in turns, degrees or rad"):
        esc.read_readings(file(f"{head}\ns,gon,gon", stamps), time="time")


@pytest.mark.parametrize("nothing", ["-", "--", "#N/A", "#VALUE!", "n/a", "?"])
def test_what_stands_for_a_missing_reading(file, nothing):
    path = file(f"time_s,{HEAD}", [f"{second:g}" for second in SECONDS])
    path.write_text(path.read_text().replace("45.0000", nothing, 1))
    assert esc.read_readings(path, time="time").missing == 1
    path = file(f"time_s,{HEAD}", [nothing if i == 7 else str(i) for i in range(61)])
    with pytest.raises(InputFileError, match=r"time must be known for every sample.* line 9"):
        esc.read_readings(path, time="time")


def test_equal_stamps_of_a_coarse_clock_are_spread(file):
    true = np.arange(0.0, 60.05, 0.3)
    start = 17.4
    found = spread(np.floor(true + start), 1.0)
    assert (np.diff(found) > 0.0).all()
    apart = found - (true + start)
    assert np.ptp(apart) < 0.35
    path = file(f"t_ms,{HEAD}", [str(i // 3) for i in range(61)])
    readings = esc.read_readings(path, time="time")
    assert np.diff(readings.time) == pytest.approx(1e-3 / 3.0, rel=0.01)
    assert "40 times equal the one before, as those of a clock with steps of 0.001 s" in (
        readings.remark
    )
    with pytest.raises(InputFileError, match="time must increase, got 7 s after 7 s"):
        esc.read_readings(file(f"t_s,{HEAD}", ["7"] * 61), time="time")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings_of_windows_programs(file, encoding):
    stamps = [f"{second:g}" for second in SECONDS]
    path = file("note \u00fc \u00b5m,Input (\u00b0),Output (\u00b0)", stamps, encoding)
    readings = esc.read_readings(path)
    np.testing.assert_allclose(np.degrees(readings.input), ANGLES, atol=1e-4)
    assert readings.remark == ""
    with pytest.raises(LookupError):  # a common name would be taken from other packages
        codecs.lookup_error("windows")


def counted(turns, resolution, seed=3):
    """Counts of a good drive with one pin, and its wheel."""
    wheel, random = esc.Geneva(4, pins=1), np.random.default_rng(seed)
    theta = 2.0 * np.pi * turns * np.arange(1500) / 1500
    output = esc.measurement.position(wheel, theta + 0.3) + 0.05 * DEG * random.standard_normal(
        1500
    )
    angles = np.array([theta, output])
    return wheel, np.round(angles / (2.0 * np.pi) * np.array(resolution)[:, None]).astype(int)


@pytest.mark.parametrize("signed", [True, False])
@pytest.mark.parametrize(("bits", "turns"), [(16, 60.0), (8, 12.0), (16, -60.0)])
def test_a_counter_that_rolls_over_is_undone(tmp_path, bits, turns, signed):
    wheel, counts = counted(turns, (2400, 2400))
    low = -(2 ** (bits - 1)) if signed else 0
    rolled = np.mod(counts - low, 2**bits) + low
    assert np.abs(np.diff(rolled[0])).max() > 200
    path = tmp_path / "data.csv"
    np.savetxt(path, rolled.T, "%d", ",", header="input_counts,output_counts", comments="")
    readings = esc.read_readings(path, resolution=2400)
    whole = 2.0 * np.pi / 2400 * counts
    np.testing.assert_allclose(np.diff(readings.input), np.diff(whole[0]), atol=1e-9)
    assert f"the counter of the input has {bits} bits and starts again" in readings.remark
    assert esc.measure(readings, wheel).standard_deviation < 0.09 * DEG


def test_an_absolute_encoder_does_not_roll_over(tmp_path):
    wheel, counts = counted(7.0, (65536, 4096))
    once = np.mod(counts, [[65536], [4096]])
    path = tmp_path / "data.csv"
    np.savetxt(path, once.T, "%d", ",", header="input_counts,output_counts", comments="")
    readings = esc.read_readings(path, resolution=(65536, 4096))
    assert readings.remark == ""
    assert esc.measure(readings, wheel).verdict.good


def test_a_jump_of_another_counter_is_named():
    wheel, counts = counted(20.0, (2400, 2400))
    angles = 2.0 * np.pi / 2400 * counts
    angles[0, 700:] -= 10_000 * 2.0 * np.pi / 2400
    result = esc.measure(esc.Readings(*angles), wheel)
    assert result.verdict.good is not True
    assert "the input jumps by 4.15 turns up to line 701" in result.message


def test_a_resolution_for_each_shaft(command, tmp_path):
    wheel, counts = counted(6.0, (6400, 4096))
    path = tmp_path / "data.csv"
    np.savetxt(path, counts.T, "%d", ",", header="input_counts,output_counts", comments="")
    pair = esc.Encoder(6400), esc.Encoder(4096)
    result = esc.measure(esc.read_readings(path, resolution=(6400, 4096)), wheel, encoder=pair)
    assert result.verdict.good
    assert result.sensor_share.input_resolution < result.sensor_share.output_resolution * 1.2
    words = ("measure", str(path), "--slots", "4", "--pins", "1", "--resolution")
    code, out, _ = command(*words, "6400,4096")
    assert code == 0
    assert out.partition("\n\n")[2].startswith("Good: ")
    for one in ("6400", "4096"):
        assert "\n\nNot this mechanism" in command(*words, one)[1]
    for wrong in ("6400,1", "1,2,3", "x"):
        code, _, err = command(*words, wrong)
        assert code == 2
        assert "resolution" in err
    with pytest.raises(InvalidValue, match="resolution must be"):
        esc.read_readings(path, resolution=(1, 2, 3))
    with pytest.raises(InvalidValue, match="a pair of them"):
        esc.measure(path, wheel, encoder=(pair[0], 4096))


def test_options_of_time_on_the_command_line(command, file):
    path = file(f"Zeit,{HEAD}", [f"{second:g}" for second in SECONDS])
    words = ("measure", str(path), "--slots", "4")
    code, _, err = command(*words, "--time-unit", "ms")
    assert code == 2
    assert "--time-unit must come with --fit" in err
    code, _, err = command(*words, "--time-unit", "days")
    assert code == 2
    assert "--time-unit must be one of s, ms, us, ns, min, h" in err
