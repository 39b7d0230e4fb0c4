"""Figures of a motion: curves reach every event, and jumps are gaps."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from escapement.base.errors import InvalidValue
from figure_tools import legend_of

FIGURES = (plots.plot_velocities, plots.plot_phase_portrait, plots.plot_contact_moment)


def timer(pins=None, friction=0.35, driver=3.39e-7) -> esc.Escapement:
    return esc.Escapement(esc.Geneva(4, pins), esc.Inertia(driver, 5.65e-6), 0.0113, friction)


@pytest.fixture(scope="module")
def motion():
    return esc.simulate(timer(), engagements=4, rtol=1e-8)


@pytest.fixture(scope="module")
def dwelling():
    return esc.simulate(timer(pins=1, friction=0.2, driver=3e-6), engagements=3, rtol=1e-8)


def test_many_handoffs_are_marked_where_no_curve_hides_them(dwelling):
    many = esc.simulate(dwelling.escapement, engagements=40, rtol=1e-8)
    ax = plots.plot_velocities(many)
    assert ax.get_xlabel() == "Time (s)"
    (marks,) = (lines for lines in ax.collections if lines.get_label() == "handoff")
    top = ax.lines[0].get_ydata().max() / ax.get_ylim()[1]
    heights = np.array(marks.get_segments())[:, :, 1]
    assert heights.shape == (40, 2)
    assert heights.min() > top
    assert (heights.max(axis=1) == 1.0).all()


def test_velocities_reach_every_extremum(motion):
    ax = plots.plot_velocities(motion)
    driver, follower = ax.lines[:2]
    assert ax.get_xlabel() == "Time (ms)"
    assert ax.get_ylabel() == "Angular velocity (rad/s)"
    assert legend_of(ax) == ["driver", "follower", "pin reversal", "handoff"]
    assert driver.get_ydata().max() == pytest.approx(motion.extrema.theta_dot.max(), rel=1e-12)
    assert driver.get_xdata()[-1] == pytest.approx(1e3 * motion.end_time)
    assert ax.get_xlim()[1] > 1.01 * driver.get_xdata()[-1]  # the last spike is not cut
    assert follower.get_ydata().min() >= -1e-9


def test_phase_portrait_stays_within_the_cell(motion):
    ax = plots.plot_phase_portrait(motion)
    curves = [line.get_xdata() for line in ax.lines if len(line.get_xdata()) > 10]
    assert len(curves) == 4
    for x in curves:
        np.testing.assert_allclose([x.min(), x.max()], [-45.0, 45.0], atol=1e-6)
    assert ax.get_xlabel() == "Driver angle from dead centre (°)"
    assert legend_of(ax) == ["transient", "terminal cycle", "pin reversal"]


def test_phase_portrait_calls_an_engagement_transient_that_others_follow():
    first = esc.simulate(timer(), engagements=1)
    whole = "last whole engagement"
    for length, said in ((0.5, "unfinished"), (1.0, whole), (1.2, whole)):
        motion = esc.simulate(timer(), duration=length * first.end_time)
        labels = plots.plot_phase_portrait(motion).get_legend_handles_labels()[1]
        assert "transient" not in labels
        assert said in labels


def test_phase_portrait_shades_the_dwell(dwelling):
    ax = plots.plot_phase_portrait(dwelling)
    assert legend_of(ax) == ["dwell", "transient", "last whole engagement", "pin reversal"]
    (dwell,) = [patch for patch in ax.patches if patch.get_label() == "dwell"]
    assert [dwell.get_x(), dwell.get_width()] == pytest.approx([45.0, 270.0])


def test_contact_moment_jumps_are_gaps(motion, dwelling):
    for case in (motion, dwelling):
        ax = plots.plot_contact_moment(case)
        assert ax.get_ylabel() == "Moment on the follower (mN m)"
        (line,) = [line for line in ax.lines if line.get_label() == "contact moment"]
        x, y = line.get_xdata() / 1e3, line.get_ydata()
        gaps = np.flatnonzero(np.isnan(y))[1:-1]
        for handoff in case.handoff_times[:-1]:
            (gap,) = [i for i in gaps if abs(x[i + 1] / handoff - 1.0) < 1e-12]
            assert y[gap + 1] > 0.0 > y[gap - 1]
            in_dwell = x[gap + 1] - x[gap - 1]
            assert (in_dwell > 1e-3) if case is dwelling else (in_dwell == 0.0)


def test_figures_of_a_motion_without_length_are_refused():
    halted = esc.simulate(timer(friction=2.0), engagements=2)
    for plot in FIGURES:
        with pytest.raises(InvalidValue, match="motion must be longer than zero"):
            plot(halted)


def test_given_axes_keep_their_style_and_legends_cover_no_data(motion):
    for plot in FIGURES:
        given = Figure(figsize=(7, 4), layout="constrained").add_subplot()
        size = given.xaxis.label.get_fontsize()
        ax = plot(motion, given)
        assert ax is given
        assert ax.xaxis.label.get_fontsize() == size
        ax.figure.draw_without_rendering()
        place = ax.get_legend().get_window_extent()
        assert ax.get_window_extent().y1 - 1.0 <= place.y0 <= place.y1 <= ax.figure.bbox.y1 + 1.0
