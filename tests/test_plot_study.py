"""Figures of a study, from synthetic results: axes, units, holes, legends."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.legend import Legend

from escapement import plots
from escapement.errors import InvalidValue
from escapement.plots import style
from escapement.status import Status
from escapement.study.plan import model_numbers
from figure_tools import legend_of

UNITS = {
    **dict.fromkeys(("velocity_max", "velocity_min", "velocity_mean"), "rad s-1"),
    **dict.fromkeys(("period", "rise_time", "settling_time"), "s"),
    "torque": "in lbf",
    "friction": "1",
    "load_torque": "in lbf",
    "status": "1",
}


@dataclass
class Synthetic:
    """A made-up study: velocities by the similarity law, an invented rise time."""

    axes: dict
    results: dict = field(default_factory=dict)
    units: dict = field(default_factory=lambda: dict(UNITS))
    long_names: dict = field(default_factory=lambda: {"torque": "driving torque"})
    sampled: dict = field(default_factory=dict)

    def __post_init__(self):
        grids = np.meshgrid(*self.axes.values(), indexing="ij")
        grid = dict(zip(self.axes, grids, strict=True))
        nothing = np.zeros(grids[0].shape)
        torque, friction = grid.get("torque", 0.1), grid.get("friction", 0.3)
        mean = 36.0 * np.sqrt(torque / 0.1 * 0.3 / friction) + nothing
        period = np.pi / 2.0 / mean
        self.results = {
            "velocity_max": 3.0 * mean,
            "velocity_min": 0.5 * mean,
            "velocity_mean": mean,
            "period": period,
            "rise_time": 2.3 * period / (friction + nothing),
            "settling_time": 3.0 * period,
            "status": nothing.astype("u1"),
        }


TORQUE = np.array([0.08, 0.10, 0.12, 0.14])
FRICTION = np.array([0.20, 0.25, 0.30])


@pytest.mark.parametrize("count", [3, 6])
def test_legend_of_long_numbers_stays_within_the_figure(count):
    friction = np.geomspace(1.001e-6, 1.2345e-5, count)
    study = Synthetic({"torque": np.linspace(0.1, 0.3, 5), "friction": friction})
    figure = plots.plot_study(study)
    figure.draw_without_rendering()
    (legend,) = figure.findobj(Legend)
    place = legend.get_window_extent()
    assert len(legend.get_texts()) == count
    assert figure.bbox.x0 <= place.x0
    assert place.x1 <= figure.bbox.x1


def test_lines_carry_units_and_marked_points():
    study = Synthetic({"friction": FRICTION, "torque": TORQUE})
    ax = plots.plot_lines(study, "rise_time")
    assert ax.get_xlabel() == "Driving torque (in·lbf)"
    assert ax.get_ylabel() == "Rise time (ms)"
    assert legend_of(ax) == ["0.2", "0.25", "0.3"]
    assert ax.get_legend().get_title().get_text() == "Coefficient of friction"
    for line, row in zip(ax.lines, study.results["rise_time"], strict=True):
        np.testing.assert_allclose(line.get_ydata(), 1e3 * row)
        assert line.get_markevery() is None
    assert len({(line.get_linestyle(), line.get_marker()) for line in ax.lines}) == 3
    ax = plots.plot_lines(study, "velocity_mean", x="friction")
    assert ax.get_xlabel() == "Coefficient of friction"
    assert ax.get_ylabel() == "Mean driver velocity (rad/s)"
    np.testing.assert_allclose(ax.lines[1].get_ydata(), study.results["velocity_mean"][:, 1])


def test_axes_in_any_order_are_drawn_ascending():
    study = Synthetic({"torque": TORQUE[::-1], "friction": FRICTION})
    line = plots.plot_lines(study, "period").lines[0]
    np.testing.assert_array_equal(line.get_xdata(), TORQUE)
    np.testing.assert_array_equal(line.get_ydata(), 1e3 * study.results["period"][::-1, 0])


def test_many_lines_are_thinned_evenly_and_points_unmarked():
    study = Synthetic({"friction": np.linspace(0.1, 0.4, 25), "torque": np.linspace(0.1, 0.2, 40)})
    ax = plots.plot_lines(study, "period")
    assert legend_of(ax) == ["0.1", "0.175", "0.25", "0.325", "0.4"]
    assert "5 of 25" in ax.get_legend().get_title().get_text()
    assert ax.lines[0].get_markevery() == []


def test_holes_break_lines_and_lone_points_stay_visible():
    study = Synthetic({"torque": np.linspace(0.1, 0.2, 30)})
    study.results["period"][[3, 5, 20]] = np.nan
    line = plots.plot_lines(study, "period").lines[0]
    assert np.isnan(line.get_ydata()[[3, 5, 20]]).all()
    assert line.get_markevery() == [4]


def test_rise_and_terminal_are_stacked():
    figure = plots.plot_rise_and_terminal(Synthetic({"friction": FRICTION, "torque": TORQUE}))
    upper, lower = figure.axes
    assert upper.get_ylabel() == "Rise time (ms)"
    assert lower.get_ylabel() == "Mean driver velocity (rad/s)"
    assert upper.get_position().y0 > lower.get_position().y0
    assert upper.get_xlabel() == ""


def test_map_hatches_holes():
    study = Synthetic({"torque": np.linspace(0.1, 0.2, 9), "friction": np.linspace(0.1, 0.4, 7)})
    ax = plots.plot_map(study, "period")
    assert ax.get_legend() is None
    study.results["period"][6:, 4:] = np.nan
    study.results["period"][0, 0] = np.inf
    ax = plots.plot_map(study, "period")
    assert legend_of(ax) == ["no result"]
    assert ax.patch.get_hatch()
    assert ax.get_xlabel() == "Driving torque (in·lbf)"
    assert ax.get_ylabel() == "Coefficient of friction"
    assert ax.figure.axes[1].get_ylabel() == "Period (ms)"
    filled = ax.collections[0]
    covered = sum(path.contains_point((0.19, 0.38)) for path in filled.get_paths())
    assert covered == 0
    assert sum(path.contains_point((0.12, 0.2)) for path in filled.get_paths()) == 1


@pytest.mark.parametrize("result", ["period", "rise_time"])
def test_numbers_of_a_colour_bar_stand_where_colours_change(result):
    study = Synthetic({"torque": np.geomspace(0.01, 0.2, 9), "friction": FRICTION})
    bar = plots.plot_map(study, result).collections[0].colorbar
    assert bar.get_ticks().size >= 3
    assert np.isin(bar.get_ticks(), bar._boundaries).all()


def test_times_that_jump_are_drawn_point_by_point():
    study = Synthetic({"torque": np.geomspace(0.1, 1.0, 5), "friction": FRICTION})
    study.results["rise_time"][4, 2] = np.nan
    ax = plots.plot_map(study, "rise_time")
    (cells,) = ax.collections
    assert cells.get_array().shape == (3, 5)
    np.testing.assert_allclose(cells.get_array(), 1e3 * study.results["rise_time"].T)
    assert cells.get_array().mask.sum() == 1
    assert ax.get_xlim() == pytest.approx((0.1, 1.0))
    assert ax.get_ylim() == pytest.approx((0.2, 0.3))
    edges = cells.get_coordinates()[0, :, 0]
    np.testing.assert_allclose(
        edges[1:-1], np.sqrt(study.axes["torque"][:-1] * study.axes["torque"][1:])
    )
    assert ax.figure.axes[1].get_ylabel() == "Rise time (ms)"


def test_whole_numbers_have_ticks_and_nothing_between_them():
    slots = np.arange(3, 10)
    study = Synthetic({"slots": slots, "torque": TORQUE})
    ax = plots.plot_lines(study, "period", x="slots")
    ax.figure.draw_without_rendering()
    assert [text.get_text() for text in ax.get_xticklabels()] == [str(n) for n in slots]
    assert {line.get_linestyle() for line in ax.lines} == {"None"}
    assert all(line.get_marker() and line.get_markevery() is None for line in ax.lines)
    assert len(plots.plot_map(study, "period").collections) == 1
    ax = plots.plot_lines(Synthetic({"slots": np.arange(3, 60)}), "period")
    assert all(tick == round(tick) for tick in ax.get_xticks())


def test_cases_without_answer_are_counted_in_the_figure():
    study = Synthetic({"friction": np.array([0.01, 0.2, 0.5])})
    study.results["status"][:] = (Status.NO_TERMINAL, Status.OK, Status.PAINLEVE)
    for name in ("velocity_max", "velocity_mean", "velocity_min", "rise_time", "settling_time"):
        study.results[name][[0, 2]] = np.nan
    note = "2 of 3 cases leave gaps: 1 no terminal velocity,\n1 beyond the Painlevé limit"
    assert plots.plot_study(study).get_suptitle() == note
    assert plots.plot_lines(study, "rise_time").get_title() == note


def test_legends_show_the_markers_and_dashes_of_the_lines():
    study = Synthetic({"friction": np.linspace(0.1, 0.4, 6), "torque": np.linspace(0.1, 0.2, 40)})
    figure = plots.plot_study(study)
    (legend,) = figure.subfigs[0].legends
    assert {line.get_marker() for line in legend.get_lines()} == {""}
    size = legend.handlelength * legend._fontsize
    for look in style.LOOKS[1:]:
        assert 1.2 * 2 * sum(look.linestyle[1]) <= size + 1.2 * look.linestyle[1][-1]


def test_map_of_a_constant_needs_no_contour():
    study = Synthetic({"torque": TORQUE, "friction": FRICTION})
    study.results["period"][:] = 0.04
    plots.plot_map(study, "period").figure.draw_without_rendering()


def test_study_with_one_axis_shows_times_and_velocities():
    study = Synthetic({"friction": np.array([0.3]), "torque": np.geomspace(0.05, 1.0, 7)})
    figure = plots.plot_study(study)
    assert [ax.get_ylabel() for ax in figure.axes] == ["Time (ms)", "Driver velocity (rad/s)"]
    assert legend_of(figure.axes[0]) == ["rise time", "settling time"]
    assert legend_of(figure.axes[1]) == ["max", "mean", "min"]
    assert figure.axes[1].get_xscale() == "log"
    assert figure.get_suptitle() == "Coefficient of friction = 0.3"


def test_study_with_two_axes_adds_maps_when_fine_enough():
    coarse = plots.plot_study(Synthetic({"friction": FRICTION, "torque": TORQUE}))
    assert len(coarse.axes) == 2
    axes = {"friction": np.linspace(0.1, 0.4, 5), "torque": np.linspace(0.1, 0.2, 6)}
    fine = plots.plot_study(Synthetic(axes))
    maps, bars = fine.axes[2:5], fine.axes[5:]
    assert all(ax.get_xlabel() == "Driving torque (in·lbf)" for ax in maps)
    names = ["Period (ms)", "Mean driver velocity (rad/s)", "Rise time (ms)"]
    assert [ax.get_xlabel() for ax in bars] == names


def test_further_axes_stay_at_their_middle_and_the_title_says_so():
    load = np.array([0.0, 0.01, 0.02])
    study = Synthetic({"friction": FRICTION, "torque": TORQUE, "load_torque": load})
    study.results["rise_time"][..., 1] = 0.07
    figure = plots.plot_study(study)
    assert figure.get_suptitle() == "Load torque = 0.01 in·lbf (middle of 3)"
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), 70.0)
    legend = plots.plot_lines(study, "period").get_legend()
    assert "Load torque = 0.01 in·lbf" in legend.get_title().get_text()


def test_study_leaves_out_a_result_that_nobody_has():
    study = Synthetic({"friction": FRICTION, "torque": TORQUE})
    study.results["rise_time"][:] = np.nan
    figure = plots.plot_study(study)
    assert [ax.get_ylabel() for ax in figure.axes] == ["Mean driver velocity (rad/s)"]


def test_study_without_anything_to_show_is_refused():
    single = Synthetic({"torque": np.array([0.1])})
    with pytest.raises(InvalidValue, match="single case"):
        plots.plot_study(single)
    empty = Synthetic({"friction": FRICTION, "torque": TORQUE})
    for name in empty.results:
        if name != "status":
            empty.results[name][:] = np.nan
    with pytest.raises(InvalidValue, match="got none"):
        plots.plot_study(empty)
    with pytest.raises(InvalidValue, match="got none"):
        plots.plot_map(empty, "period")
    study = Synthetic({"torque": TORQUE})
    with pytest.raises(InvalidValue, match="'rise_time'"):
        plots.plot_lines(study, "risetime")
    with pytest.raises(InvalidValue, match="x must be one of torque"):
        plots.plot_lines(study, "period", x="friction")
    with pytest.raises(InvalidValue, match="use plot_lines"):
        plots.plot_map(study, "period")


@pytest.mark.parametrize("name", ["driver_inertia", "load_torque"])
@pytest.mark.parametrize("last", [4.5e-7, 0.0073, 0.1])
def test_labels_and_powers_of_ten_stay_apart(name, last):
    axes = {name: np.linspace(0.0, last, 12), "friction": np.linspace(0.1, 0.4, 12)}
    study = Synthetic(axes)
    study.long_names[name] = model_numbers()[name].long_name
    study.units[name] = "kg m2" if name == "driver_inertia" else "N m"
    figure = plots.plot_study(study)
    figure.draw_without_rendering()
    for ax in figure.axes:
        below = [text for text in ax.get_xticklabels() if text.get_text()]
        below = sorted((text.get_window_extent() for text in below), key=lambda box: box.x0)
        assert all(a.x1 < b.x0 for a, b in pairwise(below))
        label, power = ax.xaxis.label.get_window_extent(), ax.xaxis.get_offset_text()
        assert not (power.get_text() and label.x1 > power.get_window_extent().x0)
    labels = [ax.xaxis.label.get_window_extent() for ax in figure.axes if ax.get_xlabel()]
    for i, a in enumerate(labels):
        for b in labels[:i]:
            assert not (a.x0 < b.x1 and b.x0 < a.x1 and a.y0 < b.y1 and b.y0 < a.y1)


def test_panels_and_texts_stay_apart():
    axes = {"friction": np.linspace(0.1, 0.4, 7), "torque": np.linspace(0.05, 0.2, 7)}
    study = Synthetic({**axes, "load_torque": np.linspace(0.0, 0.1, 3)})
    for name in study.results:
        if name != "status":
            study.results[name][6, 5:, :] = np.nan
    figure = plots.plot_study(study)
    figure.draw_without_rendering()
    boxes = [ax.get_tightbbox() for ax in figure.axes]
    boxes += [legend.get_window_extent() for part in figure.subfigs for legend in part.legends]
    boxes.append(figure._suptitle.get_window_extent())
    for i, a in enumerate(boxes):
        assert a.x0 >= -1.0
        assert a.x1 <= figure.bbox.x1 + 1.0
        for b in boxes[:i]:
            assert not (a.x0 < b.x1 and b.x0 < a.x1 and a.y0 < b.y1 and b.y0 < a.y1)
