"""Sensitivities and budgets: exact derivatives, worst cases, scatter and its intervals."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.cli import main
from escapement.model.numbers import with_number
from escapement.study.parse.sample import unit_cube
from escapement.tolerance.dual import Dual
from escapement.tolerance.figure_duals import figures_of
from escapement.tolerance.indices import sobol_indices
from escapement.tolerance.scatter import equal_factors
from escapement.tolerance.sensitivities import corners_of

WHEEL = esc.Geneva(4, crank_radius=0.01, pin_radius=5e-4)
TIMER = esc.Escapement(WHEEL, esc.Inertia(3e-7, 5e-6), torque=0.0113, friction=0.25)
LOSSES = {
    "load_torque": 5e-4, "driver_bearing_torque": 3e-4, "driver_drag": 1e-8,
    "follower_viscous": 4e-6, "follower_bearing_friction": 0.1, "follower_bearing_radius": 5e-4,
}  # fmt: skip
ERRORS = {
    "centre_distance_error": -2e-6, "pin_angle_errors": (3e-4, -1e-4, 0.0, 2e-4),
    "slot_offsets": (1e-6, -3e-6, 2e-6, 4e-6),
}  # fmt: skip


def by_differences(timer, name, value, step):
    """Derivatives of all figures by Richardson's extrapolation of central differences."""
    one, two = (
        [esc.terminal(with_number(timer, name, value + k * h)).as_dict() for k in (-1, 1)]
        for h in (step, 2.0 * step)
    )
    return lambda figure: (
        (4.0 * (one[1][figure] - one[0][figure]) - 0.5 * (two[1][figure] - two[0][figure]))
        / (6.0 * step)
    )


def test_a_dual_differentiates_what_it_computes():
    x = Dual([0.3, 0.7], np.eye(2))
    y = np.sqrt(np.hypot(x, 2.0)) * np.sin(x) / (1.0 + x**3.0) - abs(-x)
    h = 1e-6

    def value(x):
        return np.sqrt(np.hypot(x, 2.0)) * np.sin(x) / (1.0 + x**3.0) - abs(-x)

    at = np.array([0.3, 0.7])
    slopes = (value(at + h) - value(at - h)) / (2.0 * h)
    assert np.diag(y.slopes) == pytest.approx(slopes, rel=1e-8)
    assert (y.slopes[[0, 1], [1, 0]] == 0.0).all()
    assert (x == 0.3) is False
    with pytest.raises(ValueError, match="both sides"):
        _ = x > 0.5


@pytest.mark.parametrize(("timer", "names"), [
    (TIMER, ("friction", "driver_inertia", "pin_radius", "crank_radius")),
    (replace(TIMER, **LOSSES), tuple(LOSSES)),
    (replace(TIMER, mechanism=replace(WHEEL, **ERRORS)),
     ("friction", "centre_distance_error", "pin_angle_errors_0", "slot_offsets_3")),
    (esc.Escapement(esc.EllipticalPlanetary(2, 1), TIMER.inertia, 0.01, efficiency=0.9),
     ("efficiency", "driver_inertia")),
])  # fmt: skip
def test_derivatives_are_those_of_the_figures(timer, names):
    found = esc.sensitivities(timer)
    figures = found.figures.as_dict()
    for name in names:
        parts = name.rsplit("_", 1)
        owner = timer.mechanism if hasattr(timer.mechanism, name) else timer
        value = (
            timer.inertia.driver if name == "driver_inertia"
            else getattr(timer.mechanism, parts[0])[int(parts[1])] if name[-1].isdigit()
            else getattr(owner, name)
        )  # fmt: skip
        differences = by_differences(timer, name, value, 5e-4 * abs(value))
        for figure, row in found.absolute.items():
            # a fast cycle's deviation has fallen to 1e-9 after a round, which leaves four digits
            share = 1e-5 if figure.startswith("rise") else 1e-7
            error = share * abs(figures[figure] / value)
            assert row[name] == pytest.approx(differences(figure), abs=error), (figure, name)


@pytest.mark.parametrize("errors", [{}, {"pin_angle_errors": (3e-4, -1e-4, 0.0)}])
def test_with_viscous_drag_the_contraction_is_the_integral_along_the_cycle(errors):
    """The march takes it from a solution by Newton's method, the derivatives from the motion."""
    wheel = esc.Geneva(3, pins=3 if errors else None, crank_radius=0.01, **errors)
    own = esc.Escapement(wheel, esc.Inertia(1e-6, 5e-6), 0.015, 0.3, driver_viscous=1e-4)
    figures = esc.terminal(own)
    again = figures_of(own, figures, ("torque",), wanted=("contraction",))[0]["contraction"]
    assert figures.contraction / float(again) == pytest.approx(1.0, abs=1e-12)


def test_the_period_goes_as_torque_to_minus_one_half():
    found = esc.sensitivities(TIMER).relative
    assert found["period"]["torque"] == pytest.approx(-0.5, abs=1e-14)
    assert found["velocity_max"]["torque"] == pytest.approx(0.5, abs=1e-14)
    assert found["jam_margin"]["torque"] == 0.0
    # with the clock all inertias together are a pure change of time
    both = found["period"]["driver_inertia"] + found["period"]["follower_inertia"]
    assert both == pytest.approx(0.5, abs=1e-13)


def test_meyers_case_has_the_derivative_of_the_source():
    meyer = esc.Escapement(esc.Geneva(4), esc.Inertia(3.0, 50.0), torque=1.0, friction=0.35)
    assert esc.sensitivities(meyer).relative["period"]["friction"] == pytest.approx(0.358, abs=5e-4)


def test_a_limit_that_the_lever_sets_has_the_derivatives_of_its_closed_form():
    """The slot's end at dead centre is R (1/sin(pi/n) - 1) from the follower's axis."""
    wheel = esc.Geneva(8, pins=1, crank_radius=0.01, pin_radius=7.5e-4)
    timer = esc.Escapement(wheel, esc.Inertia(1.2e-5, 5e-6), torque=0.015, friction=1.2)
    found = esc.sensitivities(timer)
    limit = (1.0 / math.sin(math.pi / 8) - 1.0) * 0.01 / 7.5e-4
    assert found.figures.uniqueness_friction == pytest.approx(limit, rel=1e-13)
    slopes = found.relative["uniqueness_friction"]
    assert slopes["pin_radius"] == pytest.approx(-1.0, abs=1e-13)
    assert slopes["crank_radius"] == pytest.approx(1.0, abs=1e-13)
    assert max(map(abs, (slopes["driver_inertia"], slopes["follower_inertia"]))) < 1e-12


def test_corners_are_the_limits_of_small_errors():
    own = replace(TIMER, mechanism=esc.Geneva(4, crank_radius=1.0))
    found = esc.sensitivities(own, errors=True)
    period, sides = found.figures.period, found.one_sided["period"]
    centre = math.sqrt(2.0)  # the nominal distance of the axes in crank radii
    for name, scale, below, above in (
        ("centre_distance_error", centre, -9.190, -3.238),
        ("pin_angle_errors_0", 1.0, 0.1441, -0.1441),
        ("slot_angle_errors_0", 1.0, -0.8872, 0.8872),
    ):  # fmt: skip
        assert sides[name][0] * scale / period == pytest.approx(below, rel=0.05), name
        assert sides[name][1] * scale / period == pytest.approx(above, rel=0.05), name
    assert set(found.jumps).isdisjoint(found.absolute)


def test_what_has_no_cycle_has_no_derivatives():
    with pytest.raises(InvalidValue, match="terminal cycle"):
        esc.sensitivities(replace(TIMER, friction=0.9))


SIGMA = 0.02


def test_all_methods_agree_on_a_log_normal_torque():
    tolerances = {"torque": {"log_standard_deviation": SIGMA}}
    period, own = esc.terminal(TIMER).period, 0.5 * SIGMA
    limits = {"period": (period * math.exp(-own), period * math.exp(2.0 * own))}
    for method in ("random", "latin-hypercube"):
        found = esc.budget(TIMER, tolerances, limits=limits, method=method, size=4000, indices=64)
        scatter = found.figures["period"]
        assert scatter.nominal == pytest.approx(period, rel=1e-13)
        assert scatter.worst[:2] == pytest.approx(
            [period * math.exp(k * own) for k in (-3.0, 3.0)], rel=1e-6
        )
        assert not scatter.worst.searched
        # to first order in the standard deviation
        assert scatter.sigma == pytest.approx(period * own, rel=3.0 * SIGMA**2)
        exact = period * math.exp(0.5 * own**2) * math.sqrt(math.expm1(own**2))
        assert scatter.deviation.low < exact < scatter.deviation.high
        inside = norm.cdf(2.0) - norm.cdf(-1.0)
        assert scatter.inside.low < inside < scatter.inside.high
        assert scatter.contributions == {"torque": pytest.approx(1.0)}
        assert scatter.first["torque"].value == scatter.total["torque"].value == 1.0


def test_contributors_add_up_and_correlations_count():
    tolerances = {
        "friction": {"standard_deviation": 0.01}, "torque": {"relative_standard_deviation": 0.02}
    }  # fmt: skip
    slopes = esc.sensitivities(TIMER).absolute["period"]
    parts = slopes["friction"] * 0.01, slopes["torque"] * 0.02 * TIMER.torque
    for r in (0.0, 0.6):
        pairs = [("friction", "torque", r)] if r else []
        found = esc.budget(TIMER, tolerances, size=4000, correlations=pairs).figures["period"]
        variance = parts[0] ** 2 + parts[1] ** 2 + 2.0 * r * parts[0] * parts[1]
        assert found.sigma == pytest.approx(math.sqrt(variance), rel=1e-6)
        assert sum(found.contributions.values()) == pytest.approx(1.0)
        assert found.deviation.value == pytest.approx(found.sigma, rel=0.05)
    balanced = {
        name: {key: factor * value for key, value in tolerances[name].items()}
        for name, factor in esc.budget(TIMER, tolerances, size=64)
        .figures["period"]
        .balanced.items()
    }
    again = esc.budget(TIMER, balanced, size=64).figures["period"]
    assert [*again.contributions.values()] == pytest.approx([0.5, 0.5], rel=1e-6)


def test_a_worst_case_inside_is_searched_for():
    # an error of perfect parts has a corner: the period falls on both sides of it, while the angle
    # of the last reversal is least there
    own, name = replace(TIMER, mechanism=esc.Geneva(4, crank_radius=0.01)), "centre_distance_error"
    figures = ["period", "last_reversal_angle"]
    found = esc.budget(own, {name: {"tolerance": 2e-6}}, figures=figures, size=64).figures
    ends = [esc.terminal(with_number(own, name, x)) for x in (-2e-6, 2e-6)]
    low, high, searched = found["period"].worst
    assert [low, high] == pytest.approx([ends[1].period, ends[0].period], rel=1e-12)
    assert not searched
    low, high, searched = found["last_reversal_angle"].worst
    assert low == pytest.approx(esc.terminal(own).last_reversal_angle, rel=1e-6)
    assert high == pytest.approx(max(end.last_reversal_angle for end in ends), rel=1e-9)
    assert searched


def test_indices_of_a_known_function():
    def ishigami(shares):
        x = math.pi * (2.0 * shares - 1.0)
        return np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])

    first, total = sobol_indices(ishigami, 3, 4096, 1)
    # Ishigami and Homma (1990), in closed form
    for told, true in zip([*first, *total], (0.314, 0.442, 0.0, 0.558, 0.442, 0.244), strict=True):
        assert told.value == pytest.approx(true, abs=0.05)
        assert told.low < told.value < told.high


def test_hypercubes_each_fill_every_stratum():
    shares = unit_cube("latin-hypercube", 60, 2, 1, 3)
    for part in np.split(shares, 3, axis=1):
        for row in part:
            assert sorted((row * 20).astype(int)) == [*range(20)]


CONFIG = """
torque = 0.0113
friction = 0.25
results = ["period"]
[mechanism]
slots = 4
[inertia]
driver = 3e-7
follower = 5e-6
[sample]
method = "random"
size = 200
friction = { tolerance = 0.02 }
torque = { relative_tolerance = 0.05 }
[limits]
period = [0.01, 0.05]
"""


def test_the_command_prints_a_budget(tmp_path, capsys):
    config = tmp_path / "b.toml"
    config.write_text(CONFIG)
    out = tmp_path / "out.h5"
    picture = tmp_path / "b.png"
    assert main(["budget", str(config), "--json", "-o", str(out), "--plot", str(picture)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["period"]["yield"][0] == 1.0
    assert found["period"]["yield"][1] < 1.0
    assert esc.read_study(out).cases == 200
    assert picture.stat().st_size > 0
    assert main(["budget", str(config), "--indices", "64"]) == 0
    printed = capsys.readouterr().out
    assert "share within limits" in printed
    table = printed[printed.index("Sobol' index") :].splitlines()[1:3]
    for _name, *numbers in map(str.split, table):
        first, low, high, total, least, most = map(float, numbers)
        assert low < first < high
        assert least < total < most


@pytest.mark.parametrize(("old", "new", "told"), [
    ("period = [0.01, 0.05]", "period = [0.05, 0.01]", "low below high"),
    ("period = [0.01, 0.05]", "period = 3", "two numbers, (low, high)"),
    ("period = [0.01, 0.05]", 'period = [0, "36 mm"]', "limits.period must be in s"),
    ("period = [0.01, 0.05]", "perid = [0.01, 0.05]", "b.toml: limits must be one of period,"),
    ('method = "random"', 'method = "sobol"', "random"),
    ("friction = 0.25", "friction = 0.9", "terminal cycle"),
    ("size = 200", 'size = 200\ncorrelations = [["friction", "slots", 0.5]]', "two parameters"),
])  # fmt: skip
def test_mistakes_are_told_in_a_line(tmp_path, capsys, old, new, told):
    config = tmp_path / "b.toml"
    config.write_text(CONFIG.replace(old, new, 1).replace("size = 200\n", "size = 256\n"))
    assert main(["budget", str(config)]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1


def test_with_clearance_derivatives_are_differences_with_their_doubts():
    """Under impact the cycle still goes as one over the root of the torque."""
    loose = replace(TIMER, mechanism=replace(WHEEL, clearance=2e-5))
    found = esc.sensitivities(loose)
    slope, doubt = (x["period"]["torque"] for x in (found.absolute, found.doubts))
    exact = -0.5 * found.figures.period / loose.torque
    assert abs(slope - exact) <= 3.0 * doubt + 1e-9 * abs(exact)
    assert doubt < 1e-3 * abs(exact)
    # docs/theory.md: the period grows by about 8 c/r, c being half the clearance
    grown = found.absolute["period"]["clearance"] * WHEEL.crank_radius / found.figures.period
    assert 2.0 < grown < 6.0
    assert "clearance" not in esc.sensitivities(TIMER).absolute["period"]


def test_trains_that_lose_power_have_derivatives_by_differences():
    geared = replace(TIMER, barrel=esc.Train(5.0, 0.8, 1e-6), torque=0.07)
    found = esc.sensitivities(geared)
    assert found.relative["period"]["torque"] == pytest.approx(-0.5, abs=1e-8)
    # while the barrel drives, its efficiency is a factor on the torque and on its inertia
    assert -0.6 < found.relative["period"]["barrel_efficiency"] < -0.4


def test_every_figure_of_a_budget_has_its_scatter_to_first_order():
    """The limits of friction, forces and one-sided numbers among them."""
    figures = ["period", "jam_margin", "contact_force_max", "velocity_max", "beat_error"]
    tolerances = {
        "friction": {"tolerance": 0.002}, "spring_rate": {"low": 0.0, "high": 1e-5},
        "initial_speed": {"low": 0.0, "high": 1.0}, "barrel_efficiency": {"low": 0.99, "high": 1.0},
    }  # fmt: skip
    geared = replace(TIMER, barrel=esc.Train(5.0), torque=0.0565)
    found = esc.budget(geared, tolerances, figures=figures, size=2000)
    for name, scatter in found.figures.items():
        assert scatter.sigma == pytest.approx(scatter.deviation.value, rel=0.05, abs=1e-15), name
    assert "beat_error sigma" not in repr(found)  # it is 0 of 0
    shares = found.figures["period"].contributions
    assert shares["spring_rate"] == shares["initial_speed"] == 0.0
    own = {"friction": {"tolerance": 0.002}}
    late = esc.budget(TIMER, own, figures=["rise_time"], size=64)
    assert math.isnan(late.figures["rise_time"].sigma)
    assert late.figures["rise_time"].contributions == {}
    assert "rise_time has no derivative by friction" in late.message


def test_a_kink_counts_on_the_sides_where_the_number_lies():
    name, width = "centre_distance_error", 2e-6
    slopes = corners_of(TIMER, [name], ("period",))
    below, above = slopes["period"][name]
    sides = ({"low": 0.0, "high": width}, above), ({"low": -width, "high": 0.0}, below)
    for form, slope in sides:
        found = esc.budget(TIMER, {name: form}, size=64).figures["period"]
        assert found.sigma == pytest.approx(abs(slope) * width / math.sqrt(12.0), rel=1e-3)
    # an impact costs energy as the root of the error, so that its derivative has no limit
    assert slopes["blow_max"][name] == (-math.inf, 0.0)
    assert slopes["beat_error"][name] == (0.0, 0.0)


def test_correlated_effects_are_made_equal():
    covariance = np.array([[4.0, 1.5, -0.6], [1.5, 1.0, 0.1], [-0.6, 0.1, 0.5]])
    factors = equal_factors(covariance)
    scaled = covariance * np.outer(factors, factors)
    assert scaled.sum(axis=1) == pytest.approx(np.full(3, covariance.sum() / 3.0), rel=1e-9)


def test_an_end_at_which_the_mechanism_stops_has_no_value():
    found = esc.budget(TIMER, {"load_torque": {"low": 0.0, "high": 0.02}}, size=256)
    worst = found.figures["period"].worst
    assert math.isnan(worst.high)
    assert worst.low == pytest.approx(esc.terminal(TIMER).period, rel=1e-6)
    assert "no value at one of its worst cases" in found.message
    # a normal distribution whose far tail is impossible is computed from the cases drawn
    wide = {"friction": {"standard_deviation": 0.04}}
    assert esc.budget(TIMER, wide, size=64).figures["period"].sigma > 0.0


ONE = {"friction": {"tolerance": 0.02}}


@pytest.mark.parametrize(("tolerances", "options", "told"), [
    (ONE, {"limits": {"period": 0.03}}, "limits.period must be two numbers"),
    (ONE, {"limits": {"period": (None, 0.03)}}, "write -inf or inf for none"),
    (ONE, {"limits": {"period": (0.0, math.nan)}}, "two numbers"),
    (ONE, {"limits": {"perid": (0.0, 1.0)}}, "limits must be one of"),
    (ONE, {"limits": {"status": (0.0, 1.0)}}, "limits must be one of"),
    (ONE, {"figures": ["perid"]}, "did you mean 'period'"),
    (ONE, {"correlations": ("friction", "torque", 0.5)}, "a list of pairs"),
    (ONE, {"indices": 1}, "indices must be a whole number of at least 2"),
    (ONE, {"indices": 2.5}, "indices must be a whole number"),
    (ONE, {"method": "latin-hypercube", "size": 30}, "size must be a multiple of 20"),
    (ONE, {"size": 5}, "in at least 20 of 5 cases"),
    ({"clearance": {"low": 1e-6, "high": 2e-6}, "centre_distance_error": {"tolerance": 1e-6}}, {},
     "clearance must be 0 with errors of the parts"),
])  # fmt: skip
def test_mistakes_in_python_are_told_before_anything_is_solved(
    tolerances, options, told, monkeypatch
):
    if "size" not in options:
        monkeypatch.setattr("escapement.engines.simulate.terminal", None)
    with pytest.raises(InvalidValue, match=re.escape(told)):
        esc.budget(TIMER, tolerances, **options)
