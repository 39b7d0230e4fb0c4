"""Sensitivities and budgets: derivatives, worst cases, scatter and its intervals."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

import escapement as esc
from derivative_tools import errors_of_powers, worst_against_34_digits
from escapement.base.errors import InvalidValue
from escapement.cli import main
from escapement.model.numbers import with_number
from escapement.tolerance.differences import slopes_by
from escapement.tolerance.indices import sobol_indices
from escapement.tolerance.scatter import equal_factors

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


def test_derivatives_are_those_of_34_digits():
    worst = worst_against_34_digits()
    assert len(worst) == 6
    assert max(worst.values())[0] <= 1e-8, worst


def slope_of(function, at, **options):
    """The derivative of a function of one number."""
    (slope,) = slopes_by(lambda x: np.array([function(x)]), at, np.array([function(at)]), 1.0,
                         **options)  # fmt: skip
    return slope


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("apart", [0.0, 1e-7, 5e-6, 3e-5, 1e-4, 1e-3, 3e-3, 9e-3, 0.02])
def test_a_kink_or_jump_nearby_spoils_no_derivative(apart, sign):
    """Each is on one side of the number, and the derivative at the number is that of the other.

    It may be missing; a kink that is nearer than the smallest step may count as one at the number.
    """
    place = 1.0 + sign * apart
    found = slope_of(lambda x: abs(x - place) + x**3, 1.0)
    if apart == 0.0:
        assert found[:2] == pytest.approx((2.0, 4.0), abs=1e-9)
    elif not found.missing:
        here, other = (found.below, found.above)[:: int(sign)]
        assert here == pytest.approx(3.0 - sign, abs=1e-9)
        assert other == here or (apart < 1e-5 and abs(other - 3.0 - sign) < 10.0 * found.doubt)
    assert not found.missing or 1e-7 < apart < 1e-4
    for jump in (1.0, 1e-2, 1e-4, 1e-6, 1e-9):
        found = slope_of(lambda x, jump=jump: jump * (x > place) + x**3 + 1.0, 1.0)
        assert found.missing or found[:2] == pytest.approx((3.0, 3.0), abs=1e-9), jump
        assert not found.missing or (apart < 1e-4 and jump > 1e-5)


def test_derivatives_at_the_end_of_a_range_and_of_roots():
    assert slope_of(lambda x: math.exp(x) if x <= 1.0 else math.nan, 1.0)[:2] == pytest.approx(
        (math.e, math.e), rel=1e-9
    )
    assert slope_of(lambda x: math.sqrt(max(x, 0.0)), 0.0, root=True)[:2] == (0.0, math.inf)
    assert slope_of(lambda x: math.sqrt(abs(x)), 0.0, root=True)[:2] == (-math.inf, math.inf)
    # the error of imperfect parts enters as a root, also where the figure has a finite slope
    rooted = slope_of(lambda x: 1.0 + x + 10.0 * abs(x) ** 1.5, 0.0, root=True)
    assert rooted[:2] == pytest.approx((1.0, 1.0), abs=1e-8)
    assert slope_of(lambda x: 0.0, 1.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("timer", [
    replace(TIMER, **LOSSES),
    replace(TIMER, mechanism=replace(WHEEL, **ERRORS)),
    replace(TIMER, mechanism=replace(WHEEL, clearance=2e-5)),
    replace(TIMER, barrel=esc.Train(5.0, 0.8, 1e-6), torque=0.07),
    esc.Escapement(esc.EllipticalPlanetary(2, 1), TIMER.inertia, 0.01, efficiency=0.9),
])  # fmt: skip
def test_another_unit_of_mass_length_or_time_changes_nothing(timer):
    """Euler's relation: the sum of all powers, each times the share of its number, is known."""
    found = esc.sensitivities(timer)
    for figure, missed, powers in errors_of_powers(found):
        # a relative derivative times its relative doubt is the doubt of its share
        doubts = [
            abs(share * found.doubts[figure][name] / (found.absolute[figure][name] or 1.0))
            for name, share in found.relative[figure].items()
        ]
        room = 3.0 * (doubts @ np.abs(powers)) if timer.contact else np.zeros(3)
        assert (missed <= room + 1e-8).all(), (figure, missed)


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
    # with one slot at another angle the beats differ by the root of the error
    assert found.one_sided["beat_error"]["slot_angle_errors_0"] == (-math.inf, math.inf)
    assert found.one_sided["blow_max"]["slot_angle_errors_0"] == (-math.inf, math.inf)


def test_what_has_no_cycle_has_no_derivatives():
    with pytest.raises(InvalidValue, match="terminal cycle"):
        esc.sensitivities(replace(TIMER, friction=0.9))


SIGMA = 0.02


def test_all_estimates_agree_on_a_log_normal_torque():
    tolerances = {"torque": {"log_standard_deviation": SIGMA}}
    period, own = esc.terminal(TIMER).period, 0.5 * SIGMA
    limits = {"period": (period * math.exp(-own), period * math.exp(2.0 * own))}
    found = esc.budget(TIMER, tolerances, limits=limits, size=4000, indices=64)
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

    first, total = sobol_indices(ishigami, 3, 1024, 1)
    # Ishigami and Homma (1990), in closed form
    for told, true in zip([*first, *total], (0.314, 0.442, 0.0, 0.558, 0.442, 0.244), strict=True):
        assert told.value == pytest.approx(true, abs=0.05)
        assert told.low < told.value < told.high


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
    for wrong, told in {
        'period = [0, "36 mm"]': "limits.period must be in s",
        "perid = [0.01, 0.05]": "b.toml: limits must be one of period,",
    }.items():
        config.write_text(CONFIG.replace("period = [0.01, 0.05]", wrong))
        assert main(["budget", str(config)]) == 2
        assert told in capsys.readouterr().err


@pytest.mark.slow
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
    slopes = esc.sensitivities(TIMER, errors=True).one_sided
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
