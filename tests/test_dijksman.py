"""Dijksman (1974): captions of figures 6 to 9, errata, charts and the command line."""

import numpy as np
import pytest

import escapement as esc
from escapement.sources import dijksman
from escapement.sources.dijksman import chart_mechanisms, dijksman_figures
from escapement.synthesis import motion_peaks

# solved by hand with another program from the tangency at entry
RIGHT = {
    6: {"alpha": 21.4707, "V": 0.119282, "MC": 1.271230, "M0C": 0.563016},
    7: {"alpha": 30.0, "V": 1.0 / 6.0, "MC": 0.866025, "M0C": 0.866025},
    8: {"alpha": 90.0, "V": 1.0, "MC": 0.75, "M0C": 0.0},
    9: {"alpha": 88.4041, "V": 0.736700, "MC": 0.597544, "M0C": 0.512012},
}
ERRATA = {
    (6, "alpha"): ("21.5°", "V = 0.12, rounded: 21.6"),
    (6, "MC"): ("1.271", "V = 0.12, rounded: 1.26286"),
    (6, "M0C"): ("0.563", "V = 0.12, rounded: 0.562083"),
    (9, "alpha"): ("88°24'", "V = 0.7368, a unit in the last digit above 0.7367: 88.416"),
}


def test_captions():
    assert [int(caption["figure"]) for caption in dijksman.captions()] == [6, 7, 8, 9]
    for caption in dijksman.captions():
        wheel, right = dijksman.mechanism(caption), RIGHT[int(caption["figure"])]
        assert dijksman.true_values(wheel) == pytest.approx(right, abs=5.1e-5)
        assert wheel.gear_ratio == int(caption["gear_ratio"])
        assert wheel.slots == int(caption["slots"])


def test_every_printed_number_is_right_or_explained():
    cells = dijksman.proportions()
    assert len(cells) == 16
    wrong = {(it.place, it.column): (it.true, it.reason) for it in cells if not it.agrees}
    assert wrong == {key: (text, f"computed from {why}") for key, (text, why) in ERRATA.items()}


def test_wheels_of_the_charts_start_at_once():
    assert len(chart_mechanisms()) > 600
    for wheel in chart_mechanisms()[::7]:
        plain = esc.Geneva(wheel.stations, pins=1, internal=wheel.curve == "hypocycloid")
        peaks, other = motion_peaks(wheel), motion_peaks(plain)
        assert peaks.acceleration_start > other.acceleration_start
        over_cycles = peaks.per_cycle().acceleration_start / other.per_cycle().acceleration_start
        assert over_cycles > 1.15


def test_charts():
    inside, outside = dijksman_figures.plot_design_charts().axes
    assert "n-24" in {line.get_gid() for line in outside.lines}
    lines = {line.get_gid(): line.get_xydata() for line in inside.lines}
    for n, end in [(6, 1.0), (12, 4.0), (24, 10.0)]:
        assert lines[f"n-{n}"][-1] == pytest.approx([end, 1.0])  # the wheel that never rests
    assert "n-3" not in lines


def test_motions_begin_and_end_where_they_should():
    angle, velocity, acceleration, jerk = dijksman_figures.plot_motions().axes
    for line in angle.lines:
        x, y = line.get_data()
        assert (y[0], y[-1]) == pytest.approx((0.0, 1.0), abs=1e-12)
        assert np.all(np.diff(y) > -1e-12)
    for line in velocity.lines:
        x, y = line.get_data()
        assert np.sum(np.diff(x) * (y[1:] + y[:-1]) / 2.0) == pytest.approx(1.0, abs=1e-3)
    assert len(acceleration.lines) == len(jerk.lines) == 4
