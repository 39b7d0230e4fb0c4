"""Drawings to scale: pins, slots and discs are where geometry puts them."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.figure import Figure

import escapement as esc
from escapement import plots
from escapement.mechanisms.protocol import Mechanism
from escapement.outlines.bodies import Body
from escapement.outlines.gears import EllipticalOutline, GearDrivenOutline
from escapement.outlines.geneva import GenevaOutline
from figure_tools import by_id
from tabulated_drive import exact

DRIVES = [esc.Geneva(*wheel) for wheel in ((3, None), (4, None), (5, 3), (8, 2))]
DRIVES += [esc.Geneva(slots, internal=True) for slots in (3, 8)]
SIZED = {"crank_radius": 0.02, "pin_radius": 0.002}
ROLLERS = {**SIZED, "roller_radius": 0.004}
DRIVES += [esc.Geneva(3, **SIZED), esc.Geneva(6, 1, **ROLLERS), esc.Geneva(4, 1, True, **ROLLERS)]


@pytest.fixture(params=DRIVES, ids=repr)
def drive(request):
    return request.param


@pytest.mark.parametrize(("engagement", "share"), [(0, 0.0), (5, 0.31), (-2, 0.999)])
def test_engaged_pin_is_on_the_slot_centre_line(drive, engagement, share):
    entry, exit_ = drive.breaks[0], drive.breaks[-1]
    theta = entry + share * (exit_ - entry) + engagement * drive.cell_angle
    if share == 0.0:
        theta += 1e-9  # not left to rounding which engagement a handoff belongs to
    ax = plots.plot_mechanism(drive, theta, Figure().add_subplot())
    pin = complex(*by_id(ax, f"pin-{engagement % drive.pins}").center)
    slot = by_id(ax, f"slot-{engagement % drive.slots}")
    ends = slot.get_xdata() + 1j * slot.get_ydata()
    along = (ends[1] - ends[0]) / abs(ends[1] - ends[0])
    assert abs(((pin - ends[0]) * along.conjugate()).imag) < 1e-12
    assert abs(ends[0].real * ends[1].imag - ends[0].imag * ends[1].real) < 1e-12  # radial
    radius = float(drive.radius(theta - engagement * drive.cell_angle))
    assert abs(pin) == pytest.approx(radius, abs=1e-12)


def test_only_dwells_need_a_locking_disc(drive):
    ids = {artist.get_gid() for artist in plots.plot_mechanism(drive).get_children()}
    assert ("locking-disc" in ids) != drive.continuous
    assert {"follower", "crank-disc", "line-of-centres"} <= ids
    assert {f"pin-{k}" for k in range(drive.pins)} == {name for name in ids if "pin-" in str(name)}


def test_drawing_is_to_scale_and_names_a_known_radius():
    ax = plots.plot_mechanism(esc.Geneva(slots=4, crank_radius=0.0125), 0.2)
    assert ax.get_aspect() == 1.0
    assert "crank radius 12.5 mm" in [text.get_text() for text in ax.texts]


def test_configurations_show_the_three_continuous_drives():
    figure = plots.plot_configurations(0.1)
    titles = [ax.get_title() for ax in figure.axes]
    assert titles == ["3 slots, 6 pins", "4 slots, 4 pins", "6 slots, 3 pins"]
    figure.draw_without_rendering()
    for ax in figure.axes:
        assert ax.get_aspect() == 1.0
        words = {text.get_text(): text.get_window_extent() for text in ax.texts}
        assert words.keys() == {"driver", "follower", "pin", "slot", "crank radius"}
        assert not any(a.overlaps(b) for a, b in combinations(words.values(), 2))
        assert all(figure.bbox.x0 <= a.x0 <= a.x1 <= figure.bbox.x1 for a in words.values())
    axes = np.array([ax.transData.transform((0, 0))[1] for ax in figure.axes])
    assert np.ptp(axes) < 1.0  # lines of centres at one height


def test_two_hundred_slots_are_drawn():
    plots.plot_mechanism(esc.Geneva(slots=200))


def test_a_mechanism_without_bodies_is_drawn_as_its_transmission():
    drive = esc.EllipticalPlanetary(0.016, 0.009)
    names = ("cell_angle", "breaks", "follower_step", "path", "follower_angle")
    own = type("Own", (Mechanism,), {name: getattr(drive, name) for name in names})
    for mechanism in (own(), exact(24)):
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
def test_bodies_have_names_of_their_own_and_lie_to_the_left_of_their_edges(outline):
    bodies = outline.bodies(0.7)
    assert len({body.name for body in bodies}) == len(bodies)
    solid = [body for body in bodies if isinstance(body, Body)]
    assert solid
    for body in solid:
        areas = [edge.moments.area for edge in body.edges]
        assert sum(areas) > 0.0
        assert all(area < 0.0 for area in areas if area != max(areas))


BAD = esc.Geneva(
    5, 3, crank_radius=0.02, centre_distance_error=2e-5, pin_angle_errors=(1e-3, -1e-3, 0.0),
    crank_radius_errors=(0.0, 2e-5, -1e-5), slot_angle_errors=(0.0, 2e-3, -1e-3, 0.0, 1e-3),
    slot_offsets=(0.0, 0.0, 2e-5, -2e-5, 1e-5),
)  # fmt: skip


@pytest.mark.parametrize("factor", [1.0, 20.0])
@pytest.mark.parametrize("k", range(-2, 4))
def test_imperfect_pins_are_on_the_lines_of_their_slots(k, factor):
    theta = k * BAD.cell_angle + 0.2
    ax = plots.plot_mechanism(BAD, theta, Figure().add_subplot(), exaggerate=factor)
    pins = [a for a in ax.get_children() if a.get_gid() == f"pin-{k % 3}"]
    pin = complex(*pins[0].center)
    axis = BAD.centre_distance + factor * 1e-3
    assert abs(pin - axis) == pytest.approx(1.0 + factor * [0.0, 1e-3, -5e-4][k % 3], abs=1e-12)
    ends = by_id(ax, f"slot-{k % 5}").get_xydata() @ [1.0, 1j]
    along = (ends[1] - ends[0]) / abs(ends[1] - ends[0])
    assert abs(((pin - ends[0]) * along.conjugate()).imag) < 1e-12
    assert (ends[0] * along.conjugate()).imag == pytest.approx(
        factor * [0.0, 0.0, 1e-3, -1e-3, 5e-4][k % 5], abs=1e-12
    )


def test_follower_stands_still_in_the_dwell():
    drive = esc.Geneva(slots=4, pins=1)
    shapes = [
        by_id(plots.plot_mechanism(drive, theta), "follower").get_path().vertices
        for theta in (1.0, 3.0, 5.4)
    ]
    assert drive.follower_angle([1.0, 3.0]) == pytest.approx(np.pi / 4, rel=1e-15)
    assert np.ptp(shapes, axis=0).max() < 1e-12


@pytest.mark.parametrize("share", [0.02, 0.999])
@pytest.mark.parametrize(
    "kind", [(esc.Geneva, n, pins, internal) for n in (3, 5, 18)
             for pins, internal in ((None, False), (1, False), (1, True))]
    + [(esc.GearDriven, 12, 3), (esc.GearDriven, 4, 1, "epicycloid")],
)  # fmt: skip
def test_pins_and_rollers_have_the_radii_they_were_given(kind, share):
    make, *given = kind
    length = {"crank_radius" if make is esc.Geneva else "fixed_radius": 0.02}
    widest = make(*given, **length).widest_pin
    radii = {"pin_radius": 0.01 * share * widest, "roller_radius": 0.02 * share * widest}
    ax = plots.plot_mechanism(make(*given, **length, **radii), 0.2, Figure().add_subplot())
    found = [by_id(ax, f"{name}-0").radius for name in ("roller", "pin")]
    assert found == pytest.approx([share * widest, 0.5 * share * widest])
