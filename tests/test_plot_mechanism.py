"""Drawings to scale: pins, slots and discs are where geometry puts them."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline

import escapement as esc
from escapement import plots
from escapement.errors import InvalidValue
from escapement.outlines import Body, locked_angle
from escapement.outlines.elliptical import EllipticalOutline
from escapement.outlines.gear_driven import GearDrivenOutline
from escapement.outlines.geneva import GenevaOutline, locking_disc
from figure_tools import by_id
from tabulated_drive import exact

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


def name_of(drive: esc.Geneva) -> str:
    return f"{drive.slots}-{drive.pins}{'-internal' if drive.internal else ''}"


@pytest.fixture(params=DRIVES, ids=name_of)
def drive(request):
    return request.param


@pytest.mark.parametrize(
    ("engagement", "share"), [(0, 0.0), (5, 0.31), (-2, 0.5), (0, 0.999), (5, 0.0), (-2, 0.999)]
)
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


@pytest.mark.parametrize("slots", [3, 4, 8])
def test_crescent_of_an_internal_wheel_has_a_smooth_edge(slots):
    disc = locking_disc(GenevaOutline(esc.Geneva(slots=slots, internal=True)))
    hollow = np.abs(disc[disc.size // 2 :])  # from the driver's axis, edge after edge
    waves = np.abs(np.diff(hollow, 2))[1:-1]
    assert np.quantile(waves, 0.95) < 3e-3  # crank radii


def test_pins_never_touch_the_follower(drive):
    outline = GenevaOutline(drive)
    for theta in np.linspace(drive.breaks[0], drive.breaks[0] + drive.cell_angle, 4):
        ax = plots.plot_mechanism(drive, theta, Figure().add_subplot())
        edge = by_id(ax, "follower").get_path().vertices[: outline.follower_edge.size] @ [1, 1j]
        dense = np.concatenate([np.linspace(a, b, 12) for a, b in pairwise(edge)])
        for k in range(drive.pins):
            pin = complex(*by_id(ax, f"pin-{k}").center)
            assert abs(dense - pin).min() > outline.pin_radius


def test_locking_disc_clears_the_turning_follower(drive):
    outline = GenevaOutline(drive)
    if not outline.locks:
        pytest.skip("no dwell")
    disc = locking_disc(outline)
    body = np.concatenate([disc * s for s in (0.2, 0.6, 1.0)]) if not drive.internal else disc
    for theta in np.linspace(drive.breaks[0], drive.breaks[0] + drive.cell_angle, 301):
        world = drive.centre_distance + body * np.exp(1j * outline.side * theta)
        assert outline.clearance(world * np.exp(-1j * locked_angle(drive, theta))).min() > 0.0


def test_clearance_agrees_with_the_outline(drive):
    outline = GenevaOutline(drive)
    size = outline.follower_radius
    grid = np.linspace(-size, size, 60) * 0.98
    points = (grid[:, None] + 1j * grid[None, :]).ravel()
    clear = outline.clearance(points)
    inside = Outline(
        np.column_stack([outline.follower_edge.real, outline.follower_edge.imag])
    ).contains_points(np.column_stack([points.real, points.imag]))
    solid = ~inside if drive.internal else inside
    sure = abs(clear) > 0.01  # arcs are drawn as chords
    np.testing.assert_array_equal(solid[sure], clear[sure] < 0.0)


def test_follower_stands_still_in_the_dwell():
    drive = esc.Geneva(slots=4, pins=1)
    shapes = [
        by_id(plots.plot_mechanism(drive, theta), "follower").get_path().vertices
        for theta in (1.0, 3.0, 5.4)
    ]
    assert locked_angle(drive, 1.0) == locked_angle(drive, 3.0) == pytest.approx(np.pi / 4)
    np.testing.assert_allclose(shapes[1], shapes[0], atol=1e-12)
    np.testing.assert_allclose(shapes[2], shapes[0], atol=1e-12)


def test_follower_angle_is_continuous_and_counts_on(drive):
    theta = np.linspace(-3.0, 3.0, 4001) * drive.cell_angle
    phi = np.array([locked_angle(drive, t) for t in theta])
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


def test_slots_nobody_could_tell_apart_are_not_drawn():
    plots.plot_mechanism(esc.Geneva(slots=200))
    with pytest.raises(InvalidValue, match="slots must be at most 200 in a drawing, got 201"):
        plots.plot_mechanism(esc.Geneva(slots=201))


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


@pytest.mark.parametrize(
    ("mechanism", "drawn"),
    [
        (esc.EllipticalPlanetary(0.016, 0.009), "driving"),
        (esc.GearDriven(12, 3), "fixed-gear"),
        (esc.Geneva(4), "crank-disc"),
    ],
)
def test_every_kind_is_drawn_by_one_function(mechanism, drawn):
    assert by_id(plots.plot_mechanism(mechanism, 0.2, Figure().add_subplot()), drawn)


def test_a_mechanism_without_bodies_is_drawn_as_its_transmission():
    drive = esc.EllipticalPlanetary(0.016, 0.009)
    names = ("cell_angle", "breaks", "follower_step", "path", "follower_angle")
    own = SimpleNamespace(**{name: getattr(drive, name) for name in names})
    for mechanism in (own, exact(24)):
        heights = plots.plot_mechanism(mechanism).lines[1].get_ydata()
        assert np.max(heights) == pytest.approx(drive.ratio_max, rel=1e-3)


@pytest.mark.parametrize(
    "outline",
    [
        *map(GenevaOutline, DRIVES),
        GearDrivenOutline(esc.GearDriven(12, 3, "hypocycloid")),
        GearDrivenOutline(esc.GearDriven(4, 1, "epicycloid")),
        GearDrivenOutline(esc.GearDriven(4, 0, "hypocycloid")),
        EllipticalOutline(esc.EllipticalPlanetary(0.016, 0.009)),
    ],
    ids=lambda outline: repr(outline.mechanism),
)
def test_bodies_have_names_of_their_own_and_closed_edges(outline):
    bodies = outline.bodies(0.7)
    assert len({body.name for body in bodies}) == len(bodies)
    edges = [edge for body in bodies if isinstance(body, Body) for edge in body.edges]
    assert edges
    for edge in edges:
        assert abs(edge[0] - edge[-1]) < 1e-12
