"""Kinds of two bodies that touch anywhere: their geometry, what they refuse, and drawings."""

import cmath
import math

import ezdxf
import numpy as np
import pytest
from scipy.optimize import brentq

import escapement as esc
from escapement.base.errors import InputFileError, InvalidValue
from escapement.mechanisms.chains import Chain, circle, features_of, from_rows, polygon
from escapement.mechanisms.features import CONVEX, HOLLOW, LINE
from escapement.outlines.gaps import gap, segments_of
from escapement.outlines.touching import edges_of, least_gaps, turn_of, verge_angle

RAD = math.pi / 180.0
PINS = {
    **{"teeth": 12, "wheel_radius": 1.0, "tooth_depth": 0.22, "lead": 45 * RAD, "back": 15 * RAD},
    **{"tip_radius": 0.01, "pallets": "pins", "span": 2.5, "pallet_radius": 1.02},
    "pin_radius": 0.05,
}
FLAT = {
    **{"teeth": 20, "wheel_radius": 1.0, "tooth_depth": 0.2, "lead": -5 * RAD, "back": 30 * RAD},
    **{"tip_radius": 0.01, "pallets": "flat", "span": 3.5, "pallet_radius": 0.95},
    **{"pallet_angle": 45 * RAD, "pallet_length": 0.2, "pallet_thickness": 0.08},
    "corner_radius": 0.01,
}
CLOCK = {
    **{"teeth": 30, "wheel_radius": 1.0, "tooth_depth": 0.2, "lead": -8 * RAD, "back": 35 * RAD},
    **{"tip_radius": 0.0, "span": 7.5, "lift": 2 * RAD, "lock": 0.5 * RAD, "drop": 1 * RAD},
}
VERGES = {
    "pins": esc.Runaway(**PINS), "flat": esc.Runaway(**FLAT), "deadbeat": esc.Deadbeat(**CLOCK),
    "recoil": esc.Recoil(**CLOCK, recoil_angle=10 * RAD),
}  # fmt: skip


def rows_of(features):
    """Features as a set that knows no order, to nine decimals."""
    turn = [np.mod(x + math.pi, 2.0 * math.pi) - math.pi for x in features.direction]
    columns = [features.kind, features.x, features.y, turn, features.extent, features.radius]
    return sorted(map(tuple, np.round(np.array(columns, dtype=float).T, 9) + 0.0))


def test_lines_arcs_and_corners_of_a_chain():
    half = features_of([Chain.of([1.0, -1.0], [1.0, 0.0])])
    assert rows_of(half) == rows_of(half._replace(kind=np.array([CONVEX, LINE, CONVEX, CONVEX])))
    np.testing.assert_allclose(half.direction[:2], [0.5 * math.pi, 0.0], atol=1e-15)
    np.testing.assert_allclose(half.extent, [0.5 * math.pi, 2.0, 0.25 * math.pi, 0.25 * math.pi])
    # a hollow has no corners, and its normal points to its centre
    hollow = features_of([Chain.of([1.0, 1j, -1.0, -1j], [0.0, 0.0, 0.0, -0.2])])
    assert sorted(hollow.kind.tolist()).count(HOLLOW) == 1
    assert features_of([circle(0.3, 0.05)]).extent.tolist() == [math.pi]


@pytest.mark.parametrize("name", VERGES)
def test_a_pallet_touches_where_it_begins_to_be_in_the_way(name):
    verge, rng = VERGES[name], np.random.default_rng(5)
    wheel, axis = edges_of(verge.driver_chains, verge.driver_fold), verge.axes_distance
    ends = verge.alternation
    for phi in rng.uniform(ends.exit_release, ends.entry_release, 5):
        for number, chain in enumerate(verge.follower_chains):
            pallet = [edge.moved(cmath.exp(1j * phi), axis) for edge in edges_of([chain])]
            for end, side in zip(
                verge.blocked(np.array([phi]), 600)[0, number], (-1, 1), strict=True
            ):
                gaps = [
                    gap(
                        segments_of(pallet),
                        segments_of(
                            [edge.moved(cmath.exp(1j * (end + side * more))) for edge in wheel]
                        ),
                    )[0]
                    for more in (0.0, 1e-3, -1e-3)
                ]
                assert abs(gaps[0]) < 2e-5
                assert gaps[1] > 0.0 > gaps[2]


def test_a_clock_with_sharp_teeth_has_the_drop_and_the_lift_that_it_was_designed_for():
    drops = VERGES["deadbeat"].alternation
    assert drops.entry_drop == pytest.approx(CLOCK["drop"], abs=2e-6)
    assert drops.exit_drop == pytest.approx(CLOCK["drop"], abs=2e-6)
    for name in ("deadbeat", "recoil"):
        found = VERGES[name].alternation
        half = 0.5 * (CLOCK["lift"] + CLOCK["lock"])
        assert found.entry_release == pytest.approx(half, abs=1e-8)
        assert found.exit_release == pytest.approx(-half, abs=1e-8)


def test_a_pin_releases_a_tooth_where_it_leaves_the_circle_of_the_tips():
    verge = VERGES["pins"]
    arm, axis = complex(verge.follower_chains[0].points.mean()), verge.axes_distance

    def outside(phi):
        return abs(axis + arm * cmath.exp(1j * phi)) - 1.05

    phi = brentq(outside, 0.0, 0.1, xtol=1e-15)
    found = verge.alternation
    assert found.entry_release == pytest.approx(phi, abs=1e-10)
    theta = cmath.phase(axis + arm * cmath.exp(1j * phi))
    before = verge.blocked(np.array([phi]), 3000)[0, 1, 0]
    assert found.entry_drop == pytest.approx((before - theta) % verge.pitch, abs=1e-6)


@pytest.mark.parametrize("name", ["pins", "flat"])
def test_friction_that_wedges_is_that_whose_force_passes_the_axis(name):
    """The normal is found by moving the pallet aside and looking how far it then is away."""
    verge, least = VERGES[name], math.inf
    wheel, axis = edges_of(verge.driver_chains, verge.driver_fold), verge.axes_distance
    turn = turn_of(verge)
    for theta, phi, free in list(zip(*turn, strict=True))[1:-1:4]:
        edges = edges_of(verge.follower_chains[1 - int(free) :][:1])
        teeth = segments_of([edge.moved(cmath.exp(1j * (theta - 1e-4))) for edge in wheel])

        def away(by, edges=edges, phi=phi, teeth=teeth):
            moved = [edge.moved(cmath.exp(1j * phi), axis + by) for edge in edges]
            return gap(segments_of(moved), teeth)

        slopes = [(away(step)[0] - away(-step)[0]) / 2e-6 for step in (1e-6, 1e-6j)]
        normal, point = complex(*slopes), away(0.0)[1]
        assert abs(normal) == pytest.approx(1.0, abs=1e-3)
        arm = (point - axis) * normal.conjugate()
        least = min(least, abs(arm.imag / arm.real))
    assert verge.wedge_friction == pytest.approx(least, rel=0.03)
    inertia = esc.Inertia(1.0, 0.3)
    esc.Escapement(verge, inertia, 1.0, friction=0.99 * verge.wedge_friction)
    with pytest.raises(InvalidValue, match="from which on tooth and pallet wedge each other"):
        esc.Escapement(verge, inertia, 1.0, friction=1.01 * verge.wedge_friction)


@pytest.mark.parametrize("name", VERGES)
def test_the_wheel_can_push_its_way_round_without_a_collision(name):
    verge = VERGES[name]
    assert all(pair.gap > -1e-9 for pair in least_gaps(verge))
    turn = turn_of(verge)
    assert np.diff(turn.theta).min() > -2e-6
    assert turn.theta[-1] - turn.theta[0] < verge.pitch
    middle = float(turn.theta[20])
    assert verge_angle(verge, middle + 3.0 * verge.pitch) == pytest.approx(turn.phi[20])


@pytest.mark.parametrize(
    ("base", "changes", "told"),
    [
        (PINS, {"tooth_depth": 0.5}, "teeth must be narrower at their roots than the pitch, 30"),
        (PINS, {"lead": -20 * RAD}, "back must be greater than minus that of the leading face"),
        (PINS, {"lead": 85 * RAD}, "lead must be between -80 and 80 deg"),
        (PINS, {"tip_radius": 0.2}, "tip_radius must be less than half of tooth_depth"),
        (PINS, {"span": 2.0}, "span must be a whole number and a half"),
        (PINS, {"pin_radius": 0.0}, "pin_radius must be given with pins pallets"),
        (PINS, {"pallet_angle": 0.1}, "pallet_angle must be 0 with pins pallets"),
        (FLAT, {"corner_radius": 0.05}, "corner_radius must be less than half"),
        (FLAT, {"pin_radius": 0.05}, "pin_radius must be 0 with flat pallets"),
        (PINS, {"pallet_radius": 1.06}, "both are clear of them at"),
        (PINS, {"pallet_radius": 0.85, "pin_radius": 0.13}, "must not reach the roots of"),
        (PINS, {"pin_radius": 0.1}, "a tooth must be able to go by both"),
        (CLOCK, {"drop": 6 * RAD}, "drop must be less than half a pitch, 6 deg"),
        (CLOCK, {"drop": 0.05 * RAD, "tip_radius": 0.002}, "drop from the .* pallet must be"),
    ],
)  # fmt: skip
def test_what_cannot_work_is_told_before_anything_is_computed(base, changes, told):
    kind = esc.Deadbeat if "lift" in base else esc.Runaway
    with pytest.raises(InvalidValue, match=told) as refused:
        kind(**{**base, **changes})
    assert "\n" not in str(refused.value)


def drawing_of(verge, turn, shift, units=4, loose=False):
    """A drawing of a verge, turned and shifted, in tenths of its wheel's radius."""
    drawing = ezdxf.new(units=units)
    space, layers = drawing.modelspace(), ({"layer": "driver"}, {"layer": "FOLLOWER"})
    axis = verge.axes_distance

    def placed(z):
        z = 10.0 * cmath.exp(1j * turn) * z + shift
        return z.real, z.imag

    for layer, chains, fold, at in (
        (layers[0], verge.driver_chains, verge.driver_fold, 0.0),
        (layers[1], verge.follower_chains, 1, axis),
    ):
        space.add_point(placed(at), dxfattribs=layer)
        for edge in edges_of(chains, fold):
            corners = [(*placed(z + at), b) for z, b in zip(edge.corners, edge.bulges, strict=True)]
            if not loose:
                space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs=layer)
                continue
            pairs = [*zip(corners, corners[1:] + corners[:1], strict=True)]
            for k in np.random.default_rng(1).permutation(len(pairs)):
                (x, y, bulge), (x2, y2, _) = pairs[k]
                ends = [(x, y, bulge), (x2, y2)] if k % 2 else [(x2, y2, -bulge), (x, y)]
                space.add_lwpolyline(ends, format="xyb", dxfattribs=layer)
    return drawing


@pytest.mark.parametrize("name", VERGES)
@pytest.mark.parametrize("loose", [False, True])
def test_a_drawing_gives_the_same_features(name, loose, tmp_path):
    verge, path = VERGES[name], tmp_path / "verge.dxf"
    drawing_of(verge, 0.7, 5 - 3j, loose=loose).saveas(path)
    found = esc.Outlines(*esc.read_outlines(path))
    assert found.driver_fold == verge.teeth
    assert found.centre_distance == pytest.approx(0.01 * verge.axes_distance, rel=1e-12)
    scale = np.array([1.0, *[verge.axes_distance] * 2, 1.0, 1.0, verge.axes_distance])
    for one, other in (
        (found.follower_features, verge.follower_features),
        (found.driver_features, verge.driver_features),
    ):
        extents = np.where(one.kind == LINE, verge.axes_distance, 1.0) * one.extent
        np.testing.assert_allclose(sorted(extents), sorted(other.extent), atol=1e-9)
        rows = np.sort(np.array(one[:6], dtype=float).T[:, 5] * scale[5])
        np.testing.assert_allclose(rows, np.sort(other.radius), atol=1e-9)


def test_wrong_drawings_are_told_in_one_line(tmp_path):
    path = tmp_path / "wrong.dxf"

    def told(change, rule, **how):
        drawing = drawing_of(VERGES["pins"], 0.0, 0.0, **how)
        change(drawing.modelspace())
        drawing.saveas(path)
        with pytest.raises(InputFileError, match=rule) as refused:
            esc.read_outlines(path)
        assert "\n" not in str(refused.value)

    layer = {"layer": "DRIVER"}
    told(lambda _: None, "must name its unit, mm, cm, m, inches or feet", units=0)
    told(lambda space: space.add_point((1, 1), dxfattribs=layer), "must have one point.* got 2")
    told(lambda space: space.add_text("hello", dxfattribs=layer), "got a TEXT; explode it")
    told(
        lambda space: space.add_line((20, 0), (21, 0), dxfattribs=layer),
        r"must have closed chains, got an end at \(21, 0\)",
    )
    told(
        lambda space: [space.delete_entity(e) for e in space.query("CIRCLE LWPOLYLINE")],
        "must have a closed chain, got none",
    )
    path.write_text("no drawing")
    with pytest.raises(InputFileError, match="must be a DXF file"):
        esc.read_outlines(path)


def test_holes_run_the_other_way_round(tmp_path):
    drawing = ezdxf.new(units=6)
    space = drawing.modelspace()
    for layer, x in (("DRIVER", 0.0), ("FOLLOWER", 1.5)):
        space.add_point((x, 0.0), dxfattribs={"layer": layer})
        for radius in (1.0, 0.4):
            space.add_circle((x, 0.2), radius, dxfattribs={"layer": layer})
    drawing.saveas(tmp_path / "rings.dxf")
    found = esc.Outlines(*esc.read_outlines(tmp_path / "rings.dxf"))
    assert sorted(found.driver_features.kind.tolist()) == [HOLLOW, CONVEX]
    parts = esc.parts_of(found)
    assert [(part.name, len(part.holes)) for part in parts] == [("driver", 1), ("follower", 1)]


def test_outlines_of_ones_own_are_checked():
    square = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 0)]
    esc.Outlines([square], [square], 1.8)
    for driver, apart, told in (
        ([square], 2.0, "centre_distance must be less than 2 m, where the bodies meet"),
        ([[(1, 0)]], 1.0, "driver must be a list of chains"),
        ([[(1, 0), (math.nan, 0)]], 1.0, "of finite numbers"),
        ("star", 1.0, "driver must be a list of chains"),
    ):
        with pytest.raises(InvalidValue, match=told):
            esc.Outlines(driver, [square], apart)
    assert repr(esc.Outlines([square], [square], 1.8)) != repr(
        esc.Outlines([square[::-1]], [square], 1.8)
    )
    assert polygon([0, 1, 1j], 0.1).closed
    assert not from_rows([(0, 0, 0), (1, 0, 0)], 1.0).closed


@pytest.mark.parametrize("name", VERGES)
def test_where_a_chain_begins_and_how_it_is_divided_changes_nothing(name):
    verge = VERGES[name]
    for chain in verge.follower_chains:
        once = rows_of(features_of([chain]))
        moved = Chain(np.roll(chain.points, 1), np.roll(chain.bulges, 1))
        assert rows_of(features_of([moved])) == once
        # every line and arc in two
        middle = edges_of([chain])[0].at([0.0, 0.5])
        bulges = np.repeat(np.tan(0.5 * np.arctan(chain.bulges)), 2)
        assert rows_of(features_of([Chain(middle.ravel(), bulges)])) == once
    (tooth,) = verge.driver_chains
    whole = edges_of([tooth], verge.teeth)[0]
    several = features_of([Chain(whole.corners, whole.bulges)])
    turned = np.exp(2j * np.pi / verge.teeth)
    shifted = Chain(
        np.append(tooth.points[1:-1], tooth.points[:2] * turned), np.roll(tooth.bulges, -1)
    )
    assert len(several.kind) == verge.teeth * len(verge.driver_features.kind)
    ahead = features_of([shifted], verge.teeth)
    assert len(ahead.kind) == len(verge.driver_features.kind)
    np.testing.assert_allclose(sorted(ahead.extent), sorted(verge.driver_features.extent))


def test_both_faces_of_a_tooth_touch_its_tip_circle():
    tip = 0.99
    for verge, leading, trailing in ((VERGES["pins"], 45, 15), (VERGES["flat"], -5, 30)):
        lines = verge.driver_features
        for row, normal in (
            (0, cmath.rect(1.0, (trailing - 90) * RAD)),
            (2, cmath.rect(1.0, (90 - leading) * RAD)),
        ):
            start = complex(lines.x[row], lines.y[row])
            assert -1j * cmath.exp(1j * lines.direction[row]) == pytest.approx(normal)
            away = ((start - tip) * normal.conjugate()).real
            assert away == pytest.approx(0.01)
