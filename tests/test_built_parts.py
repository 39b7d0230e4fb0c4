"""Parts that can be put together: dowels, bores, washers, base plate, coupon, sheet and title."""

import json
import math

import ezdxf
import numpy as np
import pytest
from matplotlib.path import Path

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.cli import main
from escapement.outlines.curves import Curve, chain
from escapement.outlines.gaps import outside, segments_of
from escapement.outlines.part import Part
from escapement.outlines.sheet import lay_out

SIZED = {"crank_radius": 0.03, "pin_radius": 2e-3, "clearance": 1.5e-4}
MAKERS = esc.Geneva(5, 1, **SIZED)
OPEN = esc.Geneva(4, **SIZED)
COMMAND = [
    "export", "--units", "mm", "--slots", "5", "--crank-radius", "30", "--pin-diameter", "4",
    "--clearance", ".15", "--kerf", ".2", "--thickness", "3", "--density", "1.19", "--bore", "D",
    "--driver-shaft-diameter", "5", "--follower-shaft-diameter", "5", "--dowel-diameter", "3",
    "--washer-diameter", "9", "--screw-diameter", "3.2", "--coupon-step", ".05", "--no-crosses",
    "--sheet", "300,250", "--title", "A <wheel> & more", "--tolerance", ".1",
]  # fmt: skip


def by_name(mechanism, **fits):
    return {part.name: part for part in esc.parts_of(mechanism, esc.Fits(**fits))}


@pytest.fixture(scope="module")
def makers(tmp_path_factory):
    """What the command prints, and the drawing that it writes."""
    folder = tmp_path_factory.mktemp("wheel")
    with pytest.MonkeyPatch.context() as patch:
        told = []
        patch.setattr("builtins.print", lambda *words, **_: told.append(" ".join(map(str, words))))
        assert main([*COMMAND, "--json", "-o", str(folder / "a.dxf")]) == 0
    return json.loads(told[0]), ezdxf.readfile(folder / "a.dxf")


def polygons(drawing, layer):
    """Closed polygons of a layer [mm], half a kerf beside the edges."""
    found = []
    for entity in drawing.modelspace().query(f'LWPOLYLINE CIRCLE[layer=="{layer}"]'):
        if entity.dxftype() == "CIRCLE":
            centre = complex(entity.dxf.center.x, entity.dxf.center.y)
            found.append(Curve.circle(entity.dxf.radius, centre).drawn(0.01))
            continue
        rows = np.array(entity.get_points("xyb"))
        found.append(Curve(rows[:, 0] + 1j * rows[:, 1], rows[:, 2]).drawn(0.01))
    return found


def test_the_makers_sheet_has_no_findings_and_all_of_its_parts(makers):
    told, drawing = makers
    audit = drawing.audit()
    assert not audit.errors
    assert not audit.fixes
    names = [part["part"] for part in told["parts"]]
    feet = ["foot"] * 4
    assert names[3:] == ["plate", "pin", "washer", "base", *feet, "coupon"]
    edges = polygons(drawing, "CUT_OUTER")
    assert len(edges) == len(names)
    assert len(polygons(drawing, "CUT_INNER")) == sum(part["holes"] for part in told["parts"])
    boxes = [(z.real.min(), z.imag.min(), z.real.max(), z.imag.max()) for z in edges]
    for k, (left, low, right, high) in enumerate(boxes):
        assert 0.0 < left < right < 300.0
        assert 0.0 < low < high < 250.0
        assert all(
            right < other[0] or other[2] < left or high < other[1] or other[3] < low
            for other in boxes[:k]
        )
    texts = drawing.modelspace().query('TEXT[layer=="TITLE"]')
    shown = {text.dxf.text: text.dxf.insert for text in texts}
    assert {"A <wheel> & more", "centre distance", "51.039", "pin diameter", "±0.1"} <= {*shown}
    assert all(at.x > 300.0 for at in shown.values())
    assert not drawing.modelspace().query('LINE[layer=="CENTRE"]')


def test_walls_and_gap_of_the_makers_wheel_in_millimetres(makers):
    told, _ = makers
    walls = {part["part"]: part["wall"] for part in told["parts"]}
    assert told["thinnest_wall"] == min(walls.values())
    assert told["least_gap"] == pytest.approx(0.075, abs=1e-9)
    assert walls["driver"] == pytest.approx(0.07 * 30.0, abs=1e-9)
    assert walls["plate"] == pytest.approx(2.5, abs=1e-9)
    assert walls["pin"] == pytest.approx(4.0, abs=1e-9)
    assert walls["base"] == pytest.approx(3.2, abs=1e-9)
    # the slot's wall runs beside the line at 36 degrees from the middle of the locking arc
    apart = 30.0 / math.sin(math.pi / 5.0)
    rim = math.hypot(apart * math.cos(math.pi / 5.0), 2.075)
    horn = math.acos((rim**2 + apart**2 - 24.925**2) / (2.0 * rim * apart))
    left = rim * math.sin(math.pi / 5.0 - horn) - 2.075
    assert walls["follower"] == pytest.approx(left, abs=1e-9)
    dowel = by_name(MAKERS, dowel_radius=1.5e-3)["locking-disc"].axes[1]
    assert walls["locking-disc"] == pytest.approx(23.2750 + 1.5 - 1e3 * abs(dowel) - 1.5, abs=1e-6)


def test_what_is_cut_turns_without_touching(tmp_path):
    """Polygons of a file without a kerf are turned by the closed form of the motion."""
    fits = esc.Fits(bore="D", driver_shaft_radius=2.5e-3, follower_shaft_radius=2.5e-3)
    esc.export(MAKERS, tmp_path / "a.dxf", fits, sheet=(0.3, 0.25))
    drawing = ezdxf.readfile(tmp_path / "a.dxf")
    _, lock, wheel, _ = polygons(drawing, "CUT_OUTER")
    bores = [polygons(drawing, "CUT_INNER")[k] for k in (0, 2, 3)]
    # a D bore has its axis a radius beside its left end, which chords miss by up to 31 nm
    axes = [z.real.min() + 2.5 + 0.5j * (z.imag.min() + z.imag.max()) for z in bores]
    crank = polygons(drawing, "CUT_INNER")[1][:-1].mean() - axes[0]
    assert crank == pytest.approx(-30.0, abs=3.2e-5)
    pin, apart = 2.0 * np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 361)), 30.0 / np.sin(0.2 * np.pi)
    wheel, lock = wheel - axes[2], lock - axes[1]
    for theta in np.linspace(-math.pi, math.pi, 91):
        turn = np.exp(-1j * theta)
        phi = np.angle(apart - 30.0 * turn)
        if abs(theta) > 0.3 * math.pi:
            phi = math.copysign(0.2 * math.pi, theta)
        moved = wheel * np.exp(1j * phi)
        for body in (apart - 30.0 * turn + pin, apart + lock * turn):
            for one, other in ((moved, body), (body, moved)):
                polygon = Path(np.column_stack([one.real, one.imag]))
                assert not polygon.contains_points(np.column_stack([other.real, other.imag])).any()


WHEELS = pytest.mark.parametrize(
    "mechanism",
    [MAKERS, esc.Geneva(6, 2, **SIZED), esc.Geneva(5, internal=True, **SIZED)],
    ids=["one pin", "two pins", "internal"],
)


@WHEELS
def test_dowels_stand_in_both_discs_with_walls_of_their_diameter(mechanism):
    radius = 1e-3
    parts = by_name(mechanism, dowel_radius=radius, pin_fit=2e-5)
    both = [
        sorted(
            (round(complex(hole.corners.mean()).real, 12), round(hole.corners.mean().imag, 12))
            for hole in parts[name].holes
            if math.isclose(hole.moments.area, -math.pi * (radius + 1e-5) ** 2)
        )
        for name in ("driver", "locking-disc")
    ]
    assert both[0] == both[1]
    assert len(both[0]) == 2
    (x, low), (_, high) = both[0]
    assert low == -high
    assert parts["locking-disc"].wall.width > 2.0 * radius - 1e-5
    # dowels of one pin's disc do not fit when it is turned by half a turn
    assert int(mechanism.pins) > 1 or abs(x) > 2.0 * radius


@pytest.mark.parametrize("shape", ["D", "square"])
@pytest.mark.parametrize("kerf", [0.0, 2e-4])
def test_shafts_pass_their_bores_after_the_cut(shape, kerf):
    fits = {"driver_shaft_radius": 2.5e-3, "bore": shape, "kerf": kerf, "shaft_fit": 2e-5}
    if shape == "D":
        fits["bore_flat"] = 5e-4
    shaft = by_name(MAKERS, **fits)["driver"].holes[0]
    wide = 2.51e-3
    sides = wide * (1.0 + 1.0j) * 1j ** np.arange(4)
    aside = math.acos((wide - 5e-4) / wide)
    ends = wide * np.exp([1j * aside, -1j * aside])
    outlines = {
        "D": chain(ends, [2.0 * (math.pi - aside), 0.0]),
        "square": chain(sides, np.zeros(4)),
    }
    # the same everywhere but at the corners, which have a recess
    if kerf == 0.0:
        assert -shaft.moments.area == pytest.approx(outlines[shape].moments.area, rel=1e-12)
    points = outlines[shape].drawn(0.01) * (1.0 - 1e-9)
    assert outside(segments_of([shaft]), points)[0].min() > 0.0
    # the cutter's path goes into every corner
    assert shaft.grown(0.5 * kerf).moments.area > shaft.moments.area - 1e-15


@pytest.mark.parametrize(
    ("mechanism", "turning"),
    [
        (MAKERS, {"driver", "locking-disc", "follower"}),
        (esc.GearDriven(12, 3, fixed_radius=0.03, pin_radius=5e-4), {"pin-disc", "planet"}),
        (esc.EllipticalPlanetary(0.016, 0.009), {"driven", "driving", "planet"}),
    ],
    ids=lambda x: getattr(x, "kind", None),
)
def test_only_parts_that_turn_with_their_shaft_have_a_flat(mechanism, turning):
    parts = by_name(mechanism, bore="D")
    # a D without recesses is an arc and a line
    shapes = {
        name: [hole.bulges for hole in part.holes if len(hole.corners) == 2]
        for name, part in parts.items()
    }
    assert {name for name, holes in shapes.items() if any(map(np.ptp, holes))} == turning


def test_sizes_on_a_coupon_are_those_of_its_holes_and_slots():
    part = by_name(MAKERS, coupon_step=5e-5, pin_fit=2e-5)["coupon"]
    noted = [size for _, size in part.notes]
    holes = [2.0 * math.sqrt(-hole.moments.area / math.pi) for hole in part.holes]
    np.testing.assert_allclose(holes, noted[:5], rtol=1e-12)
    np.testing.assert_allclose(holes[2], 4.02e-3, rtol=1e-12)
    ends = np.abs(part.edge.ends - part.edge.corners)[part.edge.turns < 0.0]
    np.testing.assert_allclose(sorted(ends), noted[5:], rtol=1e-12)
    np.testing.assert_allclose(noted[7], 4.15e-3, rtol=1e-12)
    for at, _ in part.notes:
        assert outside(segments_of([part.edge, *part.holes]), np.array([at]))[0] < 0.0


def test_dowels_fill_their_holes():
    both = [esc.disc_inertia(MAKERS, 3e-3, 1190.0, esc.Fits(dowel_radius=r)) for r in (0.0, 1e-3)]
    assert both[0] == both[1]


@pytest.mark.parametrize("seed", range(3))
def test_rows_on_a_sheet_never_overlap(seed):
    random = np.random.default_rng([452, seed])
    radii = 10.0 ** random.uniform(-3.0, -1.5, 15)
    parts = [Part("disc", Curve.circle(radius)) for radius in radii]
    # the least height for which there is room
    wide = random.uniform(0.08, 0.4)
    with pytest.raises(InvalidValue, match=r"rows of all parts, .* mm by ([.\d]*) mm, got") as no:
        lay_out(parts, 0.0, 1.0, stock=complex(wide, 0.02))
    high = 1e-3 * float(str(no.value).partition(", got")[0].split()[-2])
    stock = complex(wide, high + 1e-6)
    sheet = lay_out(parts, 0.0, 1.0, stock=stock)
    assert sheet.size == stock
    centres = np.array([curve.corners.mean() for _, curve in sheet.curves])
    apart = np.abs(centres[:, None] - centres) - radii - radii[:, None]
    assert np.all(apart[~np.eye(radii.size, dtype=bool)] > 4.9e-3)
    sides = centres.real, centres.imag, wide - centres.real, high - centres.imag
    assert np.all(np.array(sides) - radii > 4.9e-3)


def test_a_title_block_stands_beside_the_parts_in_any_unit(tmp_path):
    esc.export(MAKERS, tmp_path / "a.svg", title="A <wheel>\n& more", tolerance=1e-4, inches=True)
    text = (tmp_path / "a.svg").read_text()
    title = text[text.index('<g id="TITLE"') :]
    assert "A &lt;wheel&gt; &amp; more<" in title
    assert ">2.0094<" in title  # the distance of the axes in inches
    assert ">±0.00393701<" in title
    esc.export(MAKERS, tmp_path / "b.svg")
    assert "<text" not in (tmp_path / "b.svg").read_text().partition('<g id="TITLE"')[2]


@pytest.mark.parametrize(
    ("said", "mechanism", "fits"),
    [
        ("dowel_radius must be at most 0.00.* m, so that walls", MAKERS, {"dowel_radius": 6e-3}),
        ("dowel_radius must be 0 for a wheel without", OPEN, {"dowel_radius": 1e-3}),
        ("washer_radius must be between 0.002 m and .* m here", MAKERS, {"washer_radius": 2e-3}),
        ("washer_radius must be between", MAKERS, {"washer_radius": 0.02}),
        ("coupon_step must be less than 0.002 m, half", MAKERS, {"coupon_step": 2e-3}),
        ("bore_flat must be 0 for a round bore, got 0.001 m", MAKERS, {"bore_flat": 1e-3}),
        ("bore_flat must be less than", MAKERS, {"bore_flat": 0.02, "bore": "D"}),
        ("bore must be one of round, D, square, got 'd'", MAKERS, {"bore": "d"}),
        (
            "kerf must be less than half a side of the D bore",
            MAKERS, {"bore": "D", "kerf": 2e-3, "driver_shaft_radius": 2e-3},
        ),
        (
            "a hole of the follower must leave a wall: it reaches what is cut",
            MAKERS, {"bore": "square", "follower_shaft_radius": 0.0188},
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_made_is_refused(said, mechanism, fits):
    with pytest.raises(InvalidValue, match=said):
        esc.parts_of(mechanism, esc.Fits(**fits))


@pytest.mark.parametrize(
    ("said", "how"),
    [
        ("sheet must be a width and a height", {"sheet": (0.3,)}),
        ("sheet must be a width and a height", {"sheet": (0.3, -0.2)}),
        ("sheet must be large enough for rows of all parts, .* got 50 mm by", {"sheet": (0.05, 1)}),
        ("tolerance must be at least 0", {"tolerance": -1e-4}),
    ],
)
def test_what_cannot_be_laid_out_is_refused(said, how, tmp_path):
    with pytest.raises(InvalidValue, match=said):
        esc.export(MAKERS, tmp_path / "a.svg", **how)
    assert not any(tmp_path.iterdir())
