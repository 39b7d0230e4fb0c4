"""Encoders, readings made up with them, and readings that are refused."""

import math

import numpy as np
import pytest

import escapement as esc
from escapement import measurement
from escapement.base.errors import InvalidValue
from escapement.measurement.encoder import sensor_share, sensor_uncertainty
from measurement_tools import DEG, PRIKHODKO, read


def test_resolution_gives_the_spread_of_rounding():
    encoder = esc.Encoder(251)  # prime: the stops do not fall on whole counts
    result = esc.measure(read(samples=5000, turns=50.123, encoder=encoder), PRIKHODKO)
    share = sensor_share(encoder, result.fit.slope)
    assert result.standard_deviation == pytest.approx(share.standard, rel=0.03)
    assert np.abs(result.errors).max() < 1.02 * share.bound


def test_linearity_stays_within_its_bound():
    encoder = esc.Encoder(1 << 20, 0.003)
    readings = read(samples=2000, turns=9.0, encoder=encoder)
    result = esc.measure(readings, PRIKHODKO, encoder=encoder, zeros=(0.0, 0.0))
    share = result.sensor_share
    assert np.abs(result.errors).max() < 1.01 * share.bound
    assert 0.3 * share.standard < result.standard_deviation < 2.0 * share.standard


def test_shares_of_the_paper_s_encoders():
    theta = np.linspace(0.0, PRIKHODKO.cell_angle, 10_000, endpoint=False)
    g = measurement.slope(PRIKHODKO, theta)
    encoder = esc.Encoder(4096, 0.003)
    share = sensor_share(encoder, g)
    assert math.degrees(encoder.quantum) == pytest.approx(0.088, abs=5e-4)
    assert math.degrees(share.output_resolution) == pytest.approx(360 / 4096 / math.sqrt(12))
    assert math.degrees(share.output_linearity) == pytest.approx(1.08 / math.sqrt(3))
    # greatest transmission 256/81 - 1 of the paper's eq. 9 at p = 0
    assert np.abs(g).max() == pytest.approx(256 / 81 - 1, rel=1e-6)
    limit = 1.08 + 180 / 4096
    assert math.degrees(share.bound) == pytest.approx(limit * 256 / 81, rel=1e-6)
    assert share.standard == pytest.approx(math.hypot(*share[:4]))
    local = sensor_uncertainty(encoder, g)
    assert math.sqrt(np.mean(local**2)) == pytest.approx(share.standard)


def test_the_same_seed_gives_the_same_readings():
    planted = {"noise": 0.01, "encoder": esc.Encoder(4096, 0.003), "missing": 0.1}
    a, b, c = (read(seed=seed, **planted) for seed in (5, 5, 6))
    assert a.synthetic
    np.testing.assert_array_equal(a.output, b.output)
    assert not np.array_equal(a.output, c.output)
    assert 20 < a.missing < 110


@pytest.mark.parametrize("turns", [2.0, -2.0])
def test_backlash_shows_where_the_input_turns_back(turns):
    drive = esc.Geneva(3)
    readings = read(drive, turns=turns, backlash=2 * DEG)
    lag = measurement.position(drive, readings.input) - readings.output
    assert lag[0] == 0.0
    assert lag[50:] == pytest.approx(math.copysign(DEG, turns))


def test_encoders_give_whole_counts_within_a_turn():
    readings = read(encoder=esc.Encoder(100), noise=0.1)
    for angle in (readings.input, readings.output):
        counts = angle / (2 * np.pi) * 100
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-10)
        assert angle.min() >= 0.0
        assert angle.max() < 2 * np.pi


ROW = np.linspace(0.0, 9.0, 60)


WRONG = {
    "few samples": (lambda: esc.Readings(ROW[:19], ROW[:19]), "at least 20", "got 19 of 19"),
    "lengths": (lambda: esc.Readings(ROW, ROW[1:]), "one length", "60, 59"),
    "lines": (lambda: esc.Readings(ROW, ROW, line=[1]), "one length", "60, 60 and 1"),
    "words": (lambda: esc.Readings(["a"] * 60, ROW), "input must be a row of real numbers"),
    "standstill": (lambda: esc.Readings(ROW * 0.0, ROW), "input must turn"),
    "no mechanism": (lambda: esc.measure(read(), "geneva"), "mechanism", "'geneva'"),
    "no readings": (lambda: esc.measure([1.0, 2.0], PRIKHODKO), "Readings or a path", "[1.0, 2.0]"),
    "no encoder": (lambda: esc.measure(read(), PRIKHODKO, encoder=4096), "encoder", "4096"),
    "zeros": (lambda: esc.measure(read(), PRIKHODKO, zeros=1.0), "phase and an offset"),
    "a zero": (lambda: esc.measure(read(), PRIKHODKO, zeros=(0.0, "x")), "offset", "'x'"),
    "many bins": (lambda: esc.measure(read(noise=0.1), PRIKHODKO, bins=1001), "at most 1000"),
    "per cent": (lambda: esc.Encoder(4096, 0.5), "linearity", "below 0.5", "0.003"),
    "seed": (lambda: read(seed=-1), "seed", "at least 0"),
    "sense": (lambda: read(sense=0), "sense", "1 or -1"),
    "missing": (lambda: read(missing=1.0), "missing", "below 1"),
    "phase": (lambda: read(phase="1"), "phase must be a finite number", "'1'"),
}


@pytest.mark.parametrize(("call", "said"), [(c, s) for c, *s in WRONG.values()], ids=WRONG)
def test_what_is_refused(call, said):
    with pytest.raises(InvalidValue) as caught:
        call()
    assert [text for text in said if text not in str(caught.value)] == []
    assert "\n" not in str(caught.value)
