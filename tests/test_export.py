"""Files for cutting: they contain the exact geometry, and every curve is closed."""

import json
import math
import re
import sys
from dataclasses import replace

import ezdxf
import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue, MissingPackage
from escapement.cli import main
from escapement.outlines.curves import Curve, chain
from escapement.outlines.gaps import outside, segments_of

WHEEL = esc.Geneva(6, 1, crank_radius=0.02, pin_radius=0.0015, clearance=3e-5)
GEARS = esc.GearDriven(12, 3, fixed_radius=0.03, pin_radius=0.0005)
OVALS = esc.EllipticalPlanetary(0.016, 0.009)
RING = esc.Geneva(5, internal=True, crank_radius=0.02, pin_radius=0.0015, clearance=3e-5)
KINDS = pytest.mark.parametrize("mechanism", [WHEEL, RING, GEARS, OVALS], ids=lambda m: m.kind)
FITS = esc.Fits(
    pin_fit=-1e-5, shaft_fit=2e-5, driver_shaft_radius=1.5e-3, follower_shaft_radius=2e-3
)
PINLESS = replace(FITS, pin_fit=0.0)
LAYERS = {"CUT_OUTER", "CUT_INNER", "ENGRAVE", "CENTRE"}


def read(path, unit=1e-3):
    """The closed curves of a DXF by layer [m], and the sheet, which must have no findings."""
    drawing = ezdxf.readfile(path)
    found = drawing.audit()
    assert not found.errors
    assert not found.fixes
    curves = []
    for entity in drawing.modelspace():
        layer = entity.dxf.layer
        assert layer in LAYERS
        if entity.dxftype() == "CIRCLE":
            centre = complex(entity.dxf.center.x, entity.dxf.center.y)
            curves.append((layer, Curve.circle(unit * entity.dxf.radius, unit * centre)))
        elif "POLYLINE" in entity.dxftype():
            old = entity.dxftype() == "POLYLINE"
            assert entity.is_closed
            rows = np.array(list(entity.points()) if old else entity.get_points("xy"))
            bulges = [v.dxf.bulge for v in entity.vertices] if old else entity.get_points("b")
            z = unit * (rows[:, 0] + 1j * rows[:, 1])
            curves.append((layer, Curve(z, np.array(bulges, dtype=float).ravel())))
        else:
            assert layer == "CENTRE"
    return curves, drawing


@KINDS
@pytest.mark.parametrize("how", [{}, {"r12": True, "inches": True}], ids=str)
def test_a_dxf_holds_the_parts_to_a_nanometre(few_angles, mechanism, how, tmp_path):
    fits = PINLESS if mechanism is OVALS else FITS
    gaps = esc.export(mechanism, tmp_path / "a.dxf", fits, **how)
    assert gaps[0].gap > -1e-6
    curves, drawing = read(tmp_path / "a.dxf", 0.0254 if how else 1e-3)
    if how:
        assert drawing.dxfversion == "AC1009"
    else:
        assert drawing.header["$INSUNITS"] == 4
    expected = [
        c for part in esc.parts_of(mechanism, fits) for c in (part.edge, *part.holes, *part.marks)
    ]
    assert len(curves) == len(expected)
    for (_, found), curve in zip(curves, expected, strict=True):
        # a circle has no corners: only its middle and its size count
        own = curve if curve.bulges[0] == found.bulges[0] else curve.reversed()
        shift = found.corners.mean() - own.corners.mean()
        np.testing.assert_allclose(found.corners, own.corners + shift, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(found.bulges, own.bulges, rtol=0.0, atol=1e-12)


def test_arcs_that_another_reader_finds_are_slots_pins_and_axes(tmp_path):
    esc.export(WHEEL, tmp_path / "a.dxf", FITS)
    space = ezdxf.readfile(tmp_path / "a.dxf").modelspace()
    circles = [e for e in space if e.dxftype() == "CIRCLE"]
    radii = sorted({round(e.dxf.radius, 7) for e in circles if e.dxf.layer == "CUT_INNER"})
    # half the fit is in each radius: 1.5 mm - 5 um of pins, 1.5 mm and 2 mm + 10 um of shafts
    assert radii == [1.495, 1.51, 2.01]
    wheel = next(e for e in space.query("LWPOLYLINE") if len(e) == 36)
    arcs = [e for e in wheel.virtual_entities() if e.dxftype() == "ARC"]
    ends = [e for e in arcs if e.dxf.radius < 2.0]
    assert len(ends) == 6
    apart = 20.0 / math.sin(math.pi / 6)
    holes = [complex(e.dxf.center.x, e.dxf.center.y) for e in circles]
    for arc in ends:
        assert arc.dxf.radius == pytest.approx(1.515, abs=1e-6)
        centre = complex(arc.dxf.center.x, arc.dxf.center.y)
        # the round end is where the pin is at dead centre
        assert min(abs(abs(centre - hole) - (apart - 20.0)) for hole in holes) < 1e-6
    assert any(abs(abs(a - b) - apart) < 1e-6 for a in holes for b in holes)


@KINDS
def test_an_svg_encloses_the_areas_of_the_parts(few_angles, mechanism, tmp_path):
    fits = PINLESS if mechanism is OVALS else FITS
    esc.export(mechanism, tmp_path / "a.svg", fits)
    text = (tmp_path / "a.svg").read_text()
    wide, view = (re.search(f'{name}="([^"]*)"', text)[1] for name in ("width", "viewBox"))
    assert float(wide.removesuffix("mm")) == float(view.split()[2])  # 1:1
    areas = []
    for path in re.findall(r'<path d="(M [^"]* Z)"', text):
        words = re.findall(r"([MLA]) ([-\d. ]+)", path)
        at = [1e-3 * complex(*map(float, numbers.split()[-2:])) for _, numbers in words]
        assert at[0] == at[-1]
        turns = []
        for (name, numbers), a, b in zip(words[1:], at, at[1:], strict=False):
            radius, *_, large, sweep = (
                map(float, numbers.split()[:-2]) if name == "A" else (1, 0, 0)
            )
            turn = 2.0 * math.asin(min(1.0, abs(b - a) / (2e-3 * radius))) if name == "A" else 0.0
            turns.append((2.0 * math.pi - turn if large else turn) * (1.0 if sweep else -1.0))
        areas.append(abs(chain(at[:-1], turns).moments.area))
    parts = esc.parts_of(mechanism, fits)
    expected = [c.moments.area for p in parts for c in (p.edge, *p.holes, *p.marks)]
    np.testing.assert_allclose(np.sort(areas), np.sort(np.abs(expected)), rtol=1e-6)


def test_segments_stay_within_five_micrometres(tmp_path):
    esc.export(WHEEL, tmp_path / "a.dxf", segments=True)
    curves, _ = read(tmp_path / "a.dxf")
    expected = [c for p in esc.parts_of(WHEEL) for c in (p.edge, *p.holes, *p.marks)]
    for (_, found), curve in zip(curves, expected, strict=True):
        assert not found.bulges.any()
        # its corners lie on the curve, and its middles near it
        shift = complex(sum(found.box) - sum(curve.box)) / 2.0
        points = found.at([0.0, 0.5]) - shift
        distance, _ = outside(segments_of([curve]), points.ravel())
        assert np.abs(distance).max() < 1.1e-5  # the box of chords is off by 5 um as well


def test_kerf_widens_edges_and_narrows_holes(tmp_path):
    kerf = 2e-4
    esc.export(WHEEL, tmp_path / "a.dxf", esc.Fits(kerf=kerf))
    curves, _ = read(tmp_path / "a.dxf")
    parts = esc.parts_of(WHEEL)
    drawn = iter(curves)
    for part in parts:
        for layer, curve in (
            ("CUT_OUTER", part.edge),
            *(("CUT_INNER", hole) for hole in part.holes),
        ):
            named, found = next(drawn)
            assert named == layer
            whole = math.copysign(1.0, curve.moments.area)
            grown = curve.moments.area + 0.5 * kerf * curve.length + whole * math.pi * kerf**2 / 4
            assert abs(found.moments.area) == pytest.approx(abs(grown), rel=1e-9)
        for mark in part.marks:
            named, found = next(drawn)
            assert (named, len(found.corners)) == ("ENGRAVE", len(mark.corners))


def test_inertia_of_discs_is_that_of_discs_less_holes():
    drive = esc.Geneva(6, crank_radius=0.02, pin_radius=0.0015)  # three pins, no locking disc
    shafts = esc.Fits(driver_shaft_radius=2e-3, follower_shaft_radius=1e-3)
    thick, dense = 0.002, 7850.0
    found = esc.disc_inertia(drive, thick, dense, shafts)
    part = {p.name: p for p in esc.parts_of(drive, shafts)}
    rim = 1.07 * 0.02 + 0.0015
    holes = 3.0 * math.pi * 0.0015**2 * (0.02**2 + 0.5 * 0.0015**2)
    disc = 0.5 * math.pi * (rim**4 - 0.002**4) - holes
    assert part["driver"].inertia(thick, dense) == pytest.approx(dense * thick * disc, rel=1e-12)
    # pins fill their holes, and stand out by as much again
    assert found.driver == pytest.approx(dense * thick * (disc + 2.0 * holes), rel=1e-12)
    assert found.follower == part["follower"].inertia(thick, dense)
    area = math.pi * (rim**2 - 0.002**2 - 3.0 * 0.0015**2)
    assert part["driver"].mass(thick, dense) == pytest.approx(dense * thick * area, rel=1e-12)
    assert esc.Escapement(drive, found, torque=0.01).inertia == found


def test_what_cannot_be_cut_is_refused_and_not_written(tmp_path):
    with pytest.raises(InvalidValue, match="must fit into every arc"):
        esc.export(WHEEL, tmp_path / "a.svg", esc.Fits(kerf=0.0031))
    assert not any(tmp_path.iterdir())


def test_what_collides_is_refused_with_the_place(monkeypatch, tmp_path):
    from escapement.outlines import geneva

    disc = geneva.locking_disc(WHEEL).grown(4.5e-5 / 0.02)
    monkeypatch.setattr(geneva, "locking_disc", lambda *_: disc)
    said = r"locking-disc and follower must not overlap, got 0\.0\d* mm at a .* mm\) from"
    with pytest.raises(InvalidValue, match=said):
        esc.export(WHEEL, tmp_path / "a.svg")
    assert not any(tmp_path.iterdir())


def test_a_dxf_without_ezdxf_is_refused_in_one_line(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(MissingPackage, match=r"needs ezdxf.*'\.\[cad\]'"):
        esc.export(WHEEL, tmp_path / "a.dxf")


def test_the_command_writes_and_tells_in_the_users_units(tmp_path, capsys):
    given = ["gear-driven", "--stations", "12", "--lobes", "3", "--curve", "hypocycloid"]
    given += ["--fixed-radius", "30 mm", "--pin-radius", "0.5 mm", "--clearance", "0.02 mm"]
    assert (
        main(["export", *given, "--json", "--units", "in-lbf-s", "-o", str(tmp_path / "a.dxf")])
        == 0
    )
    told = json.loads(capsys.readouterr().out)
    assert told["least_gap"] == pytest.approx(1e-5 / 0.0254)
    assert [part["part"] for part in told["parts"]][:2] == ["follower", "pin-disc"]
    assert told["parts"][4]["width"] == pytest.approx(0.06 / 0.0254)
    assert read(tmp_path / "a.dxf", 0.0254)[1].header["$INSUNITS"] == 1
    wheel = ["--slots", "4", "--pins", "1", "--crank-radius", "0.02", "--pin-radius", "0.001"]
    assert main(["export", *wheel, "--thickness", "2 mm", "--density", "7850"]) == 0
    out, err = capsys.readouterr()
    assert "driver inertia" in out
    # slots as wide as the pins leave no gap, and no rounding error is told for one
    assert out.partition("\n\n")[2].splitlines()[2].split()[:3] == ["least", "gap", "0"]
    assert told["thinnest_wall"] == min(part["wall"] for part in told["parts"])
    assert "give a --clearance" in err
    for words, said in (
        (["--r12"], "must come with --output"),
        (["--thickness", "1"], "--density"),
    ):
        assert main(["export", *wheel, *words]) == 2
        assert said in capsys.readouterr().err


def test_sizes_of_the_wheel_are_told_and_a_slot_at_the_shaft_warned_of(capsys):
    wheel = ["mechanism", "--slots", "6", "--pins", "1", "--json"]
    main(wheel)
    told = json.loads(capsys.readouterr().out)
    assert told["wheel_radius_over_crank_radius"] == pytest.approx(math.sqrt(3.0))
    assert told["closest_radius_over_crank_radius"] == pytest.approx(1.0)
    assert told["slot_depth_over_crank_radius"] == pytest.approx(math.sqrt(3.0) - 1.0)
    sized = ["--crank-radius", "0.02", "--pin-radius", "0.0015", "--clearance", "3e-5"]
    main([*wheel, *sized, "--follower-shaft-radius", "0.0184"])
    out, err = capsys.readouterr()
    assert json.loads(out)["closest_radius"] == pytest.approx(0.02 - 0.001515)
    assert err == ""
    main([*wheel, *sized, "--follower-shaft-radius", "0.0186"])
    assert "a slot reaches the shaft" in capsys.readouterr().err


@pytest.mark.parametrize("inches", [False, True])
def test_solids_are_closed_and_as_large_as_their_parts(tmp_path, inches):
    trimesh, path, unit = pytest.importorskip("trimesh"), tmp_path / "a.stl", 1e-3
    pytest.importorskip("shapely")
    pytest.importorskip("mapbox_earcut")
    unit = 0.0254 if inches else 1e-3
    esc.export(WHEEL, path, FITS, thickness=0.003, inches=inches)
    solid = trimesh.load(path)
    assert solid.is_watertight
    parts = esc.parts_of(WHEEL, FITS)
    assert solid.body_count == len(parts)
    volume = sum(part.moments.area for part in parts) * 0.003
    # chords lie at most 5 um beside the arcs
    length = sum(abs(c.ends - c.corners).sum() for part in parts for c in (part.edge, *part.holes))
    assert abs(solid.volume * unit**3 - volume) < 5e-6 * 1.6 * length * 0.003
    assert solid.extents[2] * unit == pytest.approx(0.003, rel=1e-6)


def test_solids_that_cannot_be_are_refused(tmp_path):
    with pytest.raises(InvalidValue, match="thickness must be"):
        esc.export(WHEEL, tmp_path / "a.stl")
    with pytest.raises(InvalidValue, match="got planet, fixed-gear without teeth; write a draw"):
        esc.export(GEARS, tmp_path / "a.stl", thickness=0.003)
    assert not [*tmp_path.iterdir()]
