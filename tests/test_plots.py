"""Figures: what is drawn is where theory puts it, and files are written whole or not at all."""

import errno
import os
import subprocess
import sys
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline

import escapement as esc
from escapement import plots
from escapement.errors import CannotCreate, InvalidValue, StorageError
from escapement.plots import _style
from escapement.plots._labels import label, number, print_unit, scaled
from escapement.plots._wheels import Wheels, locking_disc, pose

DRIVES = [
    esc.Geneva(slots=3),
    esc.Geneva(slots=4),
    esc.Geneva(slots=6),
    esc.Geneva(slots=3, pins=1),
    esc.Geneva(slots=4, pins=1),
    esc.Geneva(slots=5, pins=3),
    esc.Geneva(slots=8, pins=2),
    esc.Geneva(slots=18),
    esc.Geneva(slots=3, internal=True),
    esc.Geneva(slots=4, internal=True),
    esc.Geneva(slots=8, internal=True),
]


def by_id(ax: Axes, gid: str):
    (found,) = [artist for artist in ax.get_children() if artist.get_gid() == gid]
    return found


def name_of(drive: esc.Geneva) -> str:
    return f"{drive.slots}-{drive.pins}{'-internal' if drive.internal else ''}"


@pytest.fixture(params=DRIVES, ids=name_of)
def drive(request):
    return request.param


# --- drawings ---------------------------------------------------------------------------


@pytest.mark.parametrize("engagement", [0, 5, -2])
@pytest.mark.parametrize("share", [0.0, 0.31, 0.5, 0.999])
def test_engaged_pin_is_on_the_slot_centre_line(drive, engagement, share):
    entry, exit_ = drive.breaks[0], drive.breaks[-1]
    theta = entry + share * (exit_ - entry) + engagement * drive.cell_angle
    if share == 0.0:
        theta += 1e-9  # not left to rounding which engagement a handoff belongs to
    ax = plots.plot_mechanism(drive, theta, Figure().add_subplot())
    pin = complex(*by_id(ax, f"pin-{engagement % drive.pins}").center)
    slot = by_id(ax, f"slot-{-engagement % drive.slots}")
    ends = slot.get_xdata() + 1j * slot.get_ydata()
    along = (ends[1] - ends[0]) / abs(ends[1] - ends[0])
    assert abs(((pin - ends[0]) * along.conjugate()).imag) < 1e-12
    assert abs(ends[0].real * ends[1].imag - ends[0].imag * ends[1].real) < 1e-12  # radial
    assert abs(pin) == pytest.approx(
        float(drive.radius(theta - engagement * drive.cell_angle)), abs=1e-12
    )


def test_pins_never_touch_the_follower(drive):
    wheels = Wheels(drive)
    for theta in np.linspace(drive.breaks[0], drive.breaks[0] + drive.cell_angle, 23):
        ax = plots.plot_mechanism(drive, theta, Figure().add_subplot())
        edge = by_id(ax, "follower").get_path().vertices[: wheels.outline.size] @ [1, 1j]
        dense = np.concatenate([np.linspace(a, b, 12) for a, b in pairwise(edge)])
        for k in range(drive.pins):
            pin = complex(*by_id(ax, f"pin-{k}").center)
            assert abs(dense - pin).min() > wheels.pin


def test_locking_disc_clears_the_turning_follower(drive):
    wheels = Wheels(drive)
    if not wheels.locks:
        pytest.skip("no dwell")
    disc = locking_disc(wheels)
    body = np.concatenate([disc * s for s in (0.2, 0.6, 1.0)]) if not drive.internal else disc
    for theta in np.linspace(drive.breaks[0], drive.breaks[0] + drive.cell_angle, 301):
        world = drive.centre_distance + body * np.exp(1j * wheels.side * theta)
        assert wheels.clearance(world * np.exp(-1j * pose(drive, theta))).min() > 0.0


def test_clearance_agrees_with_the_outline(drive):
    wheels = Wheels(drive)
    size = wheels.body
    grid = np.linspace(-size, size, 60) * 0.98
    points = (grid[:, None] + 1j * grid[None, :]).ravel()
    clear = wheels.clearance(points)
    inside = Outline(np.column_stack([wheels.outline.real, wheels.outline.imag])).contains_points(
        np.column_stack([points.real, points.imag])
    )
    solid = ~inside if drive.internal else inside
    sure = abs(clear) > 0.01  # arcs are drawn as chords
    np.testing.assert_array_equal(solid[sure], clear[sure] < 0.0)


def test_follower_stands_still_in_the_dwell():
    drive = esc.Geneva(slots=4, pins=1)
    shapes = [
        by_id(plots.plot_mechanism(drive, theta), "follower").get_path().vertices
        for theta in (1.0, 3.0, 5.4)
    ]
    assert pose(drive, 1.0) == pose(drive, 3.0) == pytest.approx(np.pi / 4)
    np.testing.assert_allclose(shapes[1], shapes[0], atol=1e-12)
    np.testing.assert_allclose(shapes[2], shapes[0], atol=1e-12)


def test_pose_is_continuous_and_counts_on(drive):
    theta = np.linspace(-3.0, 3.0, 4001) * drive.cell_angle
    phi = np.array([pose(drive, t) for t in theta])
    assert (np.diff(phi) >= -1e-12).all()
    assert np.diff(phi).max() < 3.0 * abs(drive.transmission(0.0).g) * np.diff(theta)[0]
    assert phi[-1] - phi[0] == pytest.approx(6.0 * drive.follower_step, abs=1e-9)


def test_only_dwells_need_a_locking_disc(drive):
    ids = {artist.get_gid() for artist in plots.plot_mechanism(drive).get_children()}
    assert ("locking-disc" in ids) != drive.continuous
    assert {"follower", "crank-disc", "line-of-centres"} <= ids
    assert f"pin-{drive.pins - 1}" in ids
    assert f"pin-{drive.pins}" not in ids


def test_drawing_is_to_scale_and_names_a_known_radius():
    ax = plots.plot_mechanism(esc.Geneva(slots=4, crank_radius=0.0125), 0.2)
    assert ax.get_aspect() == 1.0
    assert "crank radius 12.5 mm" in [text.get_text() for text in ax.texts]


def test_configurations_show_the_three_continuous_drives():
    figure = plots.plot_configurations(0.1)
    titles = [ax.get_title() for ax in figure.axes]
    assert titles == ["3 slots, 6 pins", "4 slots, 4 pins", "6 slots, 3 pins"]
    figure.draw_without_rendering()
    scales = [np.diff(ax.transData.transform([(0, 0), (1, 0)]), axis=0)[0, 0] for ax in figure.axes]
    np.testing.assert_allclose(scales, scales[0], rtol=0.02)


@pytest.mark.parametrize(
    ("mechanism", "theta"), [("geneva", 0.0), (esc.Geneva(4), np.nan), (esc.Geneva(4), "x")]
)
def test_drawing_refuses_what_it_cannot_draw(mechanism, theta):
    with pytest.raises(InvalidValue, match="got"):
        plots.plot_mechanism(mechanism, theta)


# --- motions ----------------------------------------------------------------------------


def timer(pins=None, friction=0.35, driver=3.39e-7) -> esc.Escapement:
    return esc.Escapement(
        mechanism=esc.Geneva(slots=4, pins=pins),
        inertia=esc.Inertia(driver=driver, follower=5.65e-6),
        friction=friction,
        torque=0.0113,
    )


@pytest.fixture(scope="module")
def motion():
    return esc.simulate(timer(), engagements=4, rtol=1e-8)


@pytest.fixture(scope="module")
def dwelling():
    return esc.simulate(timer(pins=1, friction=0.2, driver=3e-6), engagements=3, rtol=1e-8)


def legend_of(ax: Axes) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_velocities_reach_every_extremum(motion):
    ax = plots.plot_velocities(motion)
    driver, follower = ax.lines[:2]
    assert ax.get_xlabel() == "Time (ms)"
    assert ax.get_ylabel() == "Angular velocity (rad/s)"
    assert legend_of(ax) == ["driver", "follower", "pin reversal", "handoff"]
    assert driver.get_ydata().max() == pytest.approx(motion.extrema.theta_dot.max(), rel=1e-12)
    assert driver.get_xdata()[-1] == pytest.approx(1e3 * motion.end_time)
    assert follower.get_ydata().min() >= -1e-9


def test_time_axis_changes_to_seconds():
    motion = esc.simulate(timer(), engagements=30, rtol=1e-6)
    assert plots.plot_velocities(motion).get_xlabel() == "Time (s)"


def test_phase_portrait_stays_within_the_cell(motion):
    ax = plots.plot_phase_portrait(motion)
    curves = [line for line in ax.lines if line.get_xdata().__len__() > 10]
    assert len(curves) == 4
    for line in curves:
        assert line.get_xdata().min() == pytest.approx(-45.0, abs=1e-6)
        assert line.get_xdata().max() == pytest.approx(45.0, abs=1e-6)
    assert ax.get_xlabel() == "Driver angle from dead centre (°)"
    assert legend_of(ax) == ["transient", "terminal cycle", "pin reversal"]


def test_phase_portrait_shades_the_dwell(dwelling):
    ax = plots.plot_phase_portrait(dwelling)
    assert legend_of(ax) == ["dwell", "transient", "last engagement", "pin reversal"]
    (dwell,) = [patch for patch in ax.patches if patch.get_label() == "dwell"]
    assert dwell.get_x() == pytest.approx(45.0)
    assert dwell.get_width() == pytest.approx(270.0)


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
    for plot in (plots.plot_velocities, plots.plot_phase_portrait, plots.plot_contact_moment):
        with pytest.raises(InvalidValue, match="motion must have a length"):
            plot(halted)


def test_given_axes_are_used_and_left_in_their_style(motion):
    ax = Figure().add_subplot()
    size = ax.xaxis.label.get_fontsize()
    assert plots.plot_velocities(motion, ax) is ax
    assert ax.xaxis.label.get_fontsize() == size


def test_legends_cover_no_data(motion):
    for plot in (plots.plot_velocities, plots.plot_phase_portrait, plots.plot_contact_moment):
        ax = plot(motion)
        ax.figure.draw_without_rendering()
        assert ax.get_legend().get_window_extent().y0 >= ax.get_window_extent().y1 - 1.0
        assert ax.get_legend().get_window_extent().y1 <= ax.figure.bbox.y1 + 1.0


# --- studies, with synthetic data -------------------------------------------------------

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


def test_lines_carry_units_and_marked_points():
    study = Synthetic({"friction": FRICTION, "torque": TORQUE})
    ax = plots.plot_lines(study, "rise_time")
    assert ax.get_xlabel() == "Driving torque (in lbf)"
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
    assert ax.get_xlabel() == "Driving torque (in lbf)"
    assert ax.get_ylabel() == "Coefficient of friction"
    assert ax.figure.axes[1].get_ylabel() == "Period (ms)"
    filled = ax.collections[0]
    covered = sum(path.contains_point((0.19, 0.38)) for path in filled.get_paths())
    assert covered == 0
    assert sum(path.contains_point((0.12, 0.2)) for path in filled.get_paths()) == 1


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
    assert len(fine.axes) == 5
    assert [ax.get_title() for ax in fine.axes[2:]] == [
        "Period (ms)",
        "Mean driver velocity (rad/s)",
        "Rise time (ms)",
    ]


def test_further_axes_stay_at_their_middle_and_the_title_says_so():
    load = np.array([0.0, 0.01, 0.02])
    study = Synthetic({"friction": FRICTION, "torque": TORQUE, "load_torque": load})
    study.results["rise_time"][..., 1] = 0.07
    figure = plots.plot_study(study)
    assert figure.get_suptitle() == "Load torque = 0.01 in lbf (middle of 3)"
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), 70.0)
    legend = plots.plot_lines(study, "period").get_legend()
    assert "Load torque = 0.01 in lbf" in legend.get_title().get_text()


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


# --- labels and style -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("udunits", "printed"),
    [
        ("rad s-1", "rad/s"),
        ("rad s-2", "rad/s²"),
        ("in lbf", "in lbf"),
        ("in lbf s2", "in lbf s²"),
        ("kg m2", "kg m²"),
        ("N m", "N m"),
        ("s-1", "1/s"),
        ("1", ""),
        ("", ""),
    ],
)
def test_units_are_printed_as_is_customary(udunits, printed):
    assert print_unit(udunits) == printed


def test_prefixes_keep_numbers_readable():
    assert scaled("s", [0.04, np.nan]) == (1e3, "ms")
    assert scaled("s", [1.0]) == (1.0, "s")
    assert scaled("s", [3e-5]) == (1e6, "µs")
    assert scaled("N m", [-0.2]) == (1e3, "mN m")
    assert scaled("s", [np.nan]) == (1.0, "s")
    assert scaled("rad s-1", [1e-4]) == (1.0, "rad/s")
    assert number(5.65e-6) == "5.65×10⁻⁶"
    assert label("moment of inertia of the driving wheel", "in lbf s²").count("\n") == 1


def test_palette_is_distinct_in_grey_print():
    assert len({look.marker for look in _style.LOOKS}) == len(_style.LOOKS)
    assert len({str(look.linestyle) for look in _style.LOOKS}) == len(_style.LOOKS)


def test_nothing_imports_pyplot():
    code = (
        "import sys, escapement as esc\n"
        "assert 'matplotlib' not in sys.modules\n"
        "esc.plots.plot_mechanism(esc.Geneva(4)).figure.draw_without_rendering()\n"
        "esc.plots.plot_configurations()\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


# --- files ------------------------------------------------------------------------------


@pytest.fixture
def figure():
    ax = plots.new_axes()
    ax.plot([0, 1], [0, 1])
    return ax.figure


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("SVG", b"<?xml")]
)
def test_files_are_complete_and_reproducible(figure, tmp_path, suffix, magic):
    first, second = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
    plots.save(figure, first)
    plots.save(figure, str(second))
    plots.save(figure, second)
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(magic)
    assert sorted(os.listdir(tmp_path)) == sorted([first.name, second.name])


def test_impossible_outputs_are_refused_in_one_line(figure, tmp_path):
    file = tmp_path / "file"
    file.write_text("kept")
    (tmp_path / "dir.png").mkdir()
    cases = {
        tmp_path / "x.bmp": "change the suffix",
        tmp_path / "x": "change the suffix",
        tmp_path / "none" / "x.png": "create",
        tmp_path / "dir.png": "directory",
        file / "x.png": "another folder",
        tmp_path / ("x" * 300 + ".png"): "another folder or name",
    }
    for path, remedy in cases.items():
        with pytest.raises(CannotCreate) as error:
            plots.save(figure, path)
        text = str(error.value)
        assert text.startswith("output ")
        assert remedy in text
        assert str(path) in text
        assert "\n" not in text
    assert sorted(os.listdir(tmp_path)) == ["dir.png", "file"]
    assert file.read_text() == "kept"


def test_unwritable_place_is_refused(figure, tmp_path, monkeypatch):
    def denied(*_args, **_options):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("builtins.open", denied)
    with pytest.raises(CannotCreate, match="Permission denied"):
        plots.save(figure, tmp_path / "x.png")


def test_full_disk_keeps_the_old_file(figure, tmp_path, monkeypatch):
    def full(_descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    target = tmp_path / "x.png"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StorageError, match="No space left"):
        plots.save(figure, target)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["x.png"]
