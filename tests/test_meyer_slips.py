"""What Meyer's thesis says of itself, computed again: his parts, and every slip in words."""

import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.base.units import INCH_POUND
from escapement.sources import meyer
from escapement.sources.report import read_slips

rows_of = cache(meyer.appendix_e)
RUNS = {3: (0.35, 0.09), 4: (0.35, 0.10), 6: (0.35, 0.14)}
"""Friction and torque [in-lbf] of rows 16, 30 and 49 of Appendix E, by slots."""
DISC = 0.5 * math.pi * 0.283 / 386.0 * 0.25**4 * 0.1
"""Moment of inertia of his disc of steel, 0.5 in across and 0.1 in thick [in-lbf-s^2]."""
PAGE = (Path(__file__).resolve().parents[1] / "docs" / "meyer.md").read_text("utf-8")


def timer(slots, *inertias):
    friction, torque = RUNS[slots]
    inertia = esc.Inertia(*(INCH_POUND * value for value in inertias or meyer.INERTIAS[slots]))
    return esc.Escapement(esc.Geneva(slots), inertia, INCH_POUND * torque, friction)


def true_of(place, printed=""):
    """The correction of the one slip at a place that was printed like this."""
    found = [
        it.true
        for it in read_slips("meyer")
        if it.place.startswith(place) and printed in it.printed
    ]
    assert len(found) == 1
    return found[0]


def test_his_disc_has_the_inertia_of_a_disc():
    assert f"{DISC:.2e}" == "4.50e-07"
    times = np.array(list(meyer.INERTIAS.values())) / DISC
    assert f"{times.min():.1f} to {times.max():.0f} times" in true_of("chapter II", "near 0.5e-6")


@pytest.mark.parametrize(
    ("slots", "period_ms", "rise_ms", "limit"),
    [(4, 3.34, 11.3, 1.414), (3, 6.48, 11.9, 0.686), (6, 1.56, 13.2, 3.708)],
)
def test_with_his_disc_the_timers_are_fast(slots, period_ms, rise_ms, limit):
    found = esc.terminal(timer(slots, DISC, DISC))
    assert round(1e3 * found.period, 2) == period_ms
    assert round(1e3 * found.rise_time, 1) == rise_ms
    assert round(found.critical_friction, 3) == limit
    # the limit by its definition, on a fine grid: rho is 1
    wheel = esc.Geneva(slots)
    table = wheel.transmission(np.linspace(wheel.breaks[0], 0.0, 200_001)[1:-1])
    least = np.min((1.0 + table.g**2) / np.abs(table.g * table.u))
    assert found.critical_friction == pytest.approx(least, rel=1e-8)


def test_the_judge_agrees_with_his_disc():
    found = esc.terminal(timer(4, DISC, DISC), solver=esc.Solver(engine="ivp"))
    fast = esc.terminal(timer(4, DISC, DISC))
    assert fast.period == pytest.approx(found.period, rel=1e-8)
    assert fast.rise_time == pytest.approx(found.rise_time, rel=1e-6)


def test_runs_of_the_parts_are_rows_of_appendix_e():
    rows = meyer.printed_rows()
    chosen = [rows[number - 1] for number in (16, 30, 49)]
    assert {row.slots: (row.friction, row.torque_inlbf) for row in chosen} == RUNS


def test_rise_times_longer_than_fifty_milliseconds():
    times = [row.rise_time for row in meyer.printed_rows()]
    told = f"up to {1e3 * max(times):.0f} ms: {sum(time > 0.05 for time in times)} of the 49"
    assert told in true_of("abstract")


def test_the_factor_of_the_acceleration_vanishes_at_the_painleve_limit():
    for slots, inertias in meyer.INERTIAS.items():
        limit = esc.critical_friction(esc.Geneva(slots), esc.Inertia(*inertias))
        assert f"{limit:.3f}" in true_of("after (1-18)")
        wheel = esc.Geneva(slots)
        table = wheel.transmission(np.linspace(wheel.breaks[0], wheel.breaks[-1], 100_001))
        g, u, ratio = table.g, table.u, inertias[0] / inertias[1]
        for friction, positive in ((limit * (1 - 1e-6), True), (limit * (1 + 1e-6), False)):
            assert bool(np.all(ratio + g * g - friction * np.abs(g * u) > 0.0)) is positive


def test_the_sign_of_the_friction_is_explicit():
    one = timer(4)
    motion = esc.simulate(one, engagements=3)
    state = motion.at(np.linspace(0.0, motion.end_time, 3001)[1:-1])
    cell = one.mechanism.cell_angle
    theta = (state.theta + 0.5 * cell) % cell - 0.5 * cell
    table = one.mechanism.transmission(theta)
    torque = one.inertia.driver * table.dg * state.theta_dot**2 + table.g * one.torque
    clear = np.abs(state.contact_moment) > 1e-6 * np.abs(state.contact_moment).max()
    assert clear.sum() > 2900
    np.testing.assert_array_equal(np.sign(torque)[clear], np.sign(state.contact_moment)[clear])


def test_the_driver_is_slowest_before_dead_centre():
    told = []
    for slots in (3, 4, 6):
        extrema = esc.simulate(timer(slots), engagements=40).extrema
        last = extrema.engagement == 39
        least = np.argmin(extrema.theta_dot[last])
        angle = extrema.theta[last][least] - 39 * esc.Geneva(slots).cell_angle
        told.append(f"{-math.degrees(angle):.1f}")
    assert "{}, {} and {} degrees".format(*told) in true_of("chapter II", "slowest")


def test_shapes_of_the_true_runs():
    true = [row["true"] for row in rows_of()]
    shapes = [one["velocity_max"] / one["velocity_min"] for one in true]
    assert f"{min(shapes):.1f} to {max(shapes):.1f}" in true_of("chapter II", "shape")
    # the torque changes the scale alone: rows 17 to 20
    np.testing.assert_allclose(shapes[16:20], shapes[16], rtol=1e-9)
    late = f"{true[32]['rise_time']:.3f} s"
    assert true_of("Appendix E, row 33").startswith(late)


def test_numbers_of_appendix_a():
    c, r = 1.0 / math.sin(math.pi / 3), math.sin(math.pi / 6) / math.sin(math.pi / 3)
    assert true_of("Appendix A", "c = ") == f"c = {c:.3f}"
    assert true_of("Appendix A", "R = 0.557") == f"R = {r:.3f}"


# --- docs/meyer.md -----------------------------------------------------------------------


def answer(place):
    """The row of the table of answers for a place of the thesis."""
    (row,) = re.findall(rf"^\| {place} \| .*$", PAGE, re.MULTILINE)
    return row


def test_the_page_has_the_figures_of_his_parts():
    for slots in RUNS:
        for inertias in ((), (DISC, DISC)):
            found = esc.terminal(timer(slots, *inertias))
            times = [f"{1e3 * time:.2f}" for time in (found.period, found.rise_time)]
            assert " | ".join([*times, f"{found.critical_friction:.3f}"]) in PAGE


def test_the_table_has_the_numbers_of_its_rows():
    names = "printed", "as_published", "program_1973", "true"
    rows = re.findall(r"^\| (\d+), (\w+) \| (\w+) \| (.+) \| [^|]+ \|$", PAGE, flags=re.MULTILINE)
    assert len(rows) == 5
    for number, pins, figure, cells in rows:
        row = rows_of()[int(number) - 1]
        assert {"three": 3, "four": 4, "six": 6}[pins] == row["pins"]
        for name, shown in zip(names, cells.split(" | "), strict=True):
            digits = len(shown.partition(".")[2])
            assert f"{row[name][figure]:.{digits}f}" == shown, (number, name)


def test_the_page_tells_how_far_the_rows_agree():
    text, rows = " ".join(PAGE.split()), rows_of()
    published, true = (meyer.agreement(rows, name) for name in ("as_published", "true"))
    told = [f"{one.periods}, {one.minima} and {one.maxima}" for one in (published, true)]
    assert "as published meet {}, the true ones {}.".format(*told) in text
    assert f"maxima are low by up to {100.0 * published.worst_maximum:.1f} %" in text
    assert f"gives {published.rise_times} of the {published.rows} rise times" in text
    fastest = max(row["true"]["velocity_max"] / row["printed"]["velocity_max"]
                  for row in rows if row["pins"] == 3)  # fmt: skip
    assert f"is up to {fastest:.1f} times as fast as printed" in text


def test_every_conclusion_and_recommendation_has_one_answer():
    places = [f"conclusion {k}" for k in (1, 2, 3)] + [f"recommendation {k}" for k in range(1, 8)]
    assert all(answer(place).count(" | ") == 2 for place in places)


def test_the_numbers_of_the_answers():
    one = timer(4)
    relative = esc.sensitivities(one).relative["period"]
    told = [f"{relative[name]:.2f} %" for name in ("friction", "follower_inertia")]
    assert "{} per per cent of friction, by {} per".format(*told) in answer("conclusion 2")
    assert relative["torque"] == pytest.approx(-0.5, rel=1e-12)
    found = esc.terminal(one)
    assert f"{found.velocity_mean:.1f} rad/s" in answer("recommendation 7")
    assert f"{found.velocity_average_published:.1f} rad/s" in answer("recommendation 7")
    peaks = found.acceleration_max, found.follower_acceleration_max
    assert "{:,.0f} rad/s² and the follower {:,.0f}".format(
        *(round(peak, -2) for peak in peaks)
    ) in answer("recommendation 5")
    assert round(found.contact_moment_max / one.torque) == 19


def test_fifty_turns_of_a_spring_are_short():
    assert f"[{esc.rundown(timer(4), turns=50).end_time:.1f} s]" in answer("Appendix C")
    true = rows_of()
    slowest = max(true, key=lambda row: row["pins"] * row["true"]["period"])
    inertia = esc.Inertia(*(INCH_POUND * value for value in meyer.INERTIAS[slowest["slots"]]))
    torque = INCH_POUND * slowest["torque_inlbf"]
    run = esc.rundown(
        esc.Escapement(esc.Geneva(slowest["slots"]), inertia, torque, slowest["friction"]), turns=50
    )
    assert f"at most {run.end_time:.1f} s" in answer("Appendix C")
