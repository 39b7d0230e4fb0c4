"""Figures of a study, from synthetic results: axes, units, holes, legends."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from escapement import plots
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.study.result import Study
from escapement.study.subject import model_numbers
from figure_tools import legend_of

UNITS = {
    **dict.fromkeys(("velocity_max", "velocity_min", "velocity_mean"), "rad s-1"),
    **dict.fromkeys(("period", "rise_time", "settling_time"), "s"),
    "torque": "in lbf",
    "friction": "1",
    "load_torque": "in lbf",
    "status": "1",
}


def synthetic(axes):
    """A made-up study: velocities by the similarity law, an invented rise time."""
    grids = np.meshgrid(*axes.values(), indexing="ij")
    grid, nothing = dict(zip(axes, grids, strict=True)), np.zeros(grids[0].shape)
    torque, friction = grid.get("torque", 0.1), grid.get("friction", 0.3)
    mean = 36.0 * np.sqrt(torque / 0.1 * 0.3 / friction) + nothing
    period = np.pi / 2.0 / mean
    results = {
        "velocity_max": 3.0 * mean,
        "velocity_min": 0.5 * mean,
        "velocity_mean": mean,
        "period": period,
        "rise_time": 2.3 * period / (friction + nothing),
        "settling_time": 3.0 * period,
        "status": nothing.astype("u1"),
    }
    return Study(axes, results, dict(UNITS), {"torque": "driving torque"}, {}, {})


TORQUE = np.array([0.08, 0.10, 0.12, 0.14])
FRICTION = np.array([0.20, 0.25, 0.30])
MEAN = "Mean driver velocity (rad/s)"


def labels(ax):
    return [ax.get_xlabel(), ax.get_ylabel()]


def test_lines_carry_units_and_marked_points():
    study = synthetic({"friction": FRICTION, "torque": TORQUE})
    ax = plots.plot_lines(study, "rise_time")
    assert labels(ax) == ["Driving torque (in-lbf)", "Rise time (ms)"]
    assert legend_of(ax) == ["0.2", "0.25", "0.3"]
    assert ax.get_legend().get_title().get_text() == "Coefficient of friction"
    np.testing.assert_allclose(
        [line.get_ydata() for line in ax.lines], 1e3 * study.results["rise_time"]
    )
    assert {line.get_markevery() for line in ax.lines} == {None}
    assert len({(line.get_linestyle(), line.get_marker()) for line in ax.lines}) == 3
    ax = plots.plot_lines(study, "velocity_mean", x="friction")
    assert labels(ax) == ["Coefficient of friction", MEAN]
    np.testing.assert_allclose(ax.lines[1].get_ydata(), study.results["velocity_mean"][:, 1])


def test_axes_in_any_order_are_drawn_ascending():
    study = synthetic({"torque": TORQUE[::-1], "friction": FRICTION})
    x, y = plots.plot_lines(study, "period").lines[0].get_data()
    np.testing.assert_array_equal([x, y], [TORQUE, 1e3 * study.results["period"][::-1, 0]])


def test_rise_and_terminal_are_stacked():
    figure = plots.plot_rise_and_terminal(synthetic({"friction": FRICTION, "torque": TORQUE}))
    upper, lower = figure.axes
    assert upper.get_position().y0 > lower.get_position().y0
    assert [ax.get_ylabel() for ax in figure.axes] == ["Rise time (ms)", MEAN]
    assert upper.get_xlabel() == ""


def test_map_hatches_holes():
    study = synthetic({"torque": np.linspace(0.1, 0.2, 9), "friction": np.linspace(0.1, 0.4, 7)})
    ax = plots.plot_map(study, "period")
    assert ax.get_legend() is None
    study.results["velocity_mean"][:] = 0.04  # a constant has no contour
    plots.plot_map(study, "velocity_mean").figure.draw_without_rendering()
    study.results["period"][6:, 4:] = np.nan
    study.results["period"][0, 0] = np.inf
    ax = plots.plot_map(study, "period")
    assert legend_of(ax) == ["no result"]
    assert ax.patch.get_hatch()
    assert labels(ax) == ["Driving torque (in-lbf)", "Coefficient of friction"]
    assert ax.figure.axes[1].get_ylabel() == "Period (ms)"
    for point, covered in (((0.19, 0.38), 0), ((0.12, 0.2), 1)):
        assert sum(path.contains_point(point) for path in ax.collections[0].get_paths()) == covered


@pytest.mark.parametrize("result", ["period", "rise_time"])
def test_numbers_of_a_colour_bar_stand_where_colours_change(result):
    study = synthetic({"torque": np.geomspace(0.01, 0.2, 9), "friction": FRICTION})
    bar = plots.plot_map(study, result).collections[0].colorbar
    assert bar.get_ticks().size >= 3
    assert np.isin(bar.get_ticks(), bar._boundaries).all()


@pytest.mark.parametrize("power", [-0.5, 0.5, 2.0])
def test_contours_of_a_power_law_are_evenly_spread(power):
    study = synthetic({"torque": np.geomspace(0.03, 0.9, 40), "friction": FRICTION})
    study.results["velocity_mean"][:] = 40.0 * study.axes["torque"][:, None] ** power
    filled, lines = plots.plot_map(study, "velocity_mean").collections
    speeds, ends = study.results["velocity_mean"], filled.levels[[0, -1]]
    assert ends[0] <= speeds.min() <= 3.4 * ends[0]
    assert speeds.max() <= ends[1] <= 3.4 * speeds.max()
    levels = lines.levels
    assert 4 <= levels.size <= 10
    steps = np.abs(np.diff(np.log(levels)))
    assert steps.max() < 2.0 * steps.min()


def test_times_that_jump_are_mapped_point_by_point():
    study = synthetic({"torque": np.geomspace(0.1, 1.0, 5), "friction": FRICTION})
    study.results["rise_time"][4, 2] = np.nan
    ax = plots.plot_map(study, "rise_time")
    (cells,) = ax.collections
    np.testing.assert_allclose(cells.get_array(), 1e3 * study.results["rise_time"].T)
    assert cells.get_array().mask.sum() == 1
    assert [*ax.get_xlim(), *ax.get_ylim()] == pytest.approx([0.1, 1.0, 0.2, 0.3])
    edges, torque = cells.get_coordinates()[0, :, 0], study.axes["torque"]
    np.testing.assert_allclose(edges[1:-1], np.sqrt(torque[:-1] * torque[1:]))
    assert ax.figure.axes[1].get_ylabel() == "Rise time (ms)"
    assert legend_of(ax) == ["no result"]


def test_whole_numbers_have_ticks_and_nothing_between_them():
    slots = np.arange(3, 10)
    study = synthetic({"slots": slots, "torque": TORQUE})
    ax = plots.plot_lines(study, "period", x="slots")
    ax.figure.draw_without_rendering()
    assert [text.get_text() for text in ax.get_xticklabels()] == [str(n) for n in slots]
    assert {line.get_linestyle() for line in ax.lines} == {"None"}
    assert all(line.get_marker() and line.get_markevery() is None for line in ax.lines)
    assert len(plots.plot_map(study, "period").collections) == 1
    ax = plots.plot_lines(synthetic({"slots": np.arange(3, 60)}), "period")
    assert all(tick == round(tick) for tick in ax.get_xticks())


def test_cases_without_answer_are_counted_in_the_figure():
    study = synthetic({"friction": np.array([0.01, 0.2, 0.5])})
    study.results["status"][:] = (Status.NO_TERMINAL, Status.OK, Status.PAINLEVE)
    for name in study.results.keys() - {"status"}:
        study.results[name][[0, 2]] = np.nan
    note = "2 of 3 cases leave gaps: 1 no terminal velocity,\n1 beyond the Painlevé limit"
    assert plots.plot_study(study).get_suptitle() == note
    assert plots.plot_lines(study, "rise_time").get_title() == note


def test_study_with_one_axis_shows_times_and_velocities():
    study = synthetic({"friction": np.array([0.3]), "torque": np.geomspace(0.05, 1.0, 7)})
    figure = plots.plot_study(study)
    times, velocities = figure.axes
    assert times.get_ylabel() == "Time (ms)"
    assert legend_of(times) == ["period", "rise time", "settling time"]
    assert velocities.get_ylabel() == "Driver velocity (rad/s)"
    assert legend_of(velocities) == ["max", "mean", "min"]
    assert velocities.get_xscale() == "log"
    assert figure.get_suptitle() == "Coefficient of friction = 0.3"


def test_study_with_two_axes_adds_maps_when_fine_enough():
    coarse = plots.plot_study(synthetic({"friction": FRICTION, "torque": TORQUE}))
    assert len(coarse.axes) == 3
    axes = {"friction": np.linspace(0.1, 0.4, 5), "torque": np.linspace(0.1, 0.2, 6)}
    fine = plots.plot_study(synthetic(axes))
    lines, maps, bars = fine.axes[:3], fine.axes[3:6], fine.axes[6:]
    assert [ax.get_ylabel() for ax in lines] == ["Period (ms)", MEAN, "Rise time (ms)"]
    assert all(ax.get_xlabel() == "Driving torque (in-lbf)" for ax in maps)
    assert [ax.get_xlabel() for ax in bars] == ["Period (ms)", MEAN, "Rise time (ms)"]


def test_further_axes_stay_at_their_middle_and_the_title_says_so():
    load = np.array([0.0, 0.01, 0.02])
    study = synthetic({"friction": FRICTION, "torque": TORQUE, "load_torque": load})
    study.results["rise_time"][..., 1] = 0.07
    figure = plots.plot_study(study)
    assert figure.get_suptitle() == "Load torque = 0.01 in-lbf (middle of 3)"
    np.testing.assert_allclose(figure.axes[2].lines[0].get_ydata(), 70.0)
    legend = plots.plot_lines(study, "period").get_legend()
    assert "Load torque = 0.01 in-lbf" in legend.get_title().get_text()


def test_study_without_anything_to_show_is_refused():
    empty = synthetic({"friction": FRICTION, "torque": TORQUE})
    for values in empty.results.values():
        values[:] = np.nan if values.dtype == float else values
    study, single = synthetic({"torque": TORQUE}), synthetic({"torque": np.array([0.1])})
    for said, draw, *given in (
        ("single case", plots.plot_study, single),
        ("got none", plots.plot_study, empty),
        ("got none", plots.plot_map, empty, "period"),
        ("'rise_time'", plots.plot_lines, study, "risetime"),
        ("x must be one of torque", plots.plot_lines, study, "period", "friction"),
        ("use plot_lines", plots.plot_map, study, "period"),
    ):
        with pytest.raises(InvalidValue, match=said):
            draw(*given)


@pytest.mark.parametrize(
    ("name", "last"), [("driver_inertia", 4.5e-7), ("driver_inertia", 0.1), ("load_torque", 0.0073)]
)
def test_labels_and_powers_of_ten_stay_apart(name, last):
    axes = {name: np.linspace(0.0, last, 12), "friction": np.linspace(0.1, 0.4, 12)}
    study = synthetic(axes)
    study.long_names[name] = model_numbers()[name].long_name
    study.units[name] = "kg m2" if name == "driver_inertia" else "N m"
    figure = plots.plot_study(study)
    figure.draw_without_rendering()
    for ax in figure.axes:
        below = [text for text in ax.get_xticklabels() if text.get_text()]
        below = sorted((text.get_window_extent() for text in below), key=lambda box: box.x0)
        assert all(a.x1 < b.x0 for a, b in pairwise(below))
        assert not ax.xaxis.get_offset_text().get_text()
    boxes = [ax.xaxis.label.get_window_extent() for ax in figure.axes if ax.get_xlabel()]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def test_panels_and_texts_stay_apart():
    axes = {"friction": np.linspace(0.1, 0.4, 7), "torque": np.linspace(0.05, 0.2, 7)}
    study = synthetic({**axes, "load_torque": np.linspace(0.0, 0.1, 3)})
    for name in study.results.keys() - {"status"}:
        study.results[name][6, 5:, :] = np.nan
    figure = plots.plot_study(study)
    figure.draw_without_rendering()
    boxes = [ax.get_tightbbox() for ax in figure.axes]
    boxes += [legend.get_window_extent() for part in figure.subfigs for legend in part.legends]
    boxes.append(figure._suptitle.get_window_extent())
    assert min(box.x0 for box in boxes) >= -1.0
    assert max(box.x1 for box in boxes) <= figure.bbox.x1 + 1.0
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
