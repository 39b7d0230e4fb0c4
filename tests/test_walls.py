"""Thinnest walls of parts against closed forms and dense samples; a chosen locking radius."""

import json
import math

import numpy as np
import pytest

import escapement as esc
from command_scenes import TOUCHING, WHEELS, argv_of, write_inputs
from escapement.base.errors import InvalidValue
from escapement.base.quantity import declared
from escapement.cli import main
from escapement.mechanisms import KINDS
from escapement.outlines.curves import Curve, chain, stadium
from escapement.outlines.thin_walls import thinnest_wall


def test_the_wall_of_a_crescent_is_its_width_in_the_middle():
    wheel = esc.Geneva(5, internal=True, crank_radius=0.02, pin_radius=1.5e-3, clearance=2e-4)
    disc = {p.name: p for p in esc.parts_of(wheel)}["locking-disc"]
    z = disc.edge.drawn(1e-5)
    on_axis = z.real[:-1][z.imag[:-1] * z.imag[1:] <= 0.0]
    assert disc.wall.width == pytest.approx(np.ptp(on_axis), abs=1e-8)


def test_walls_in_closed_form():
    square = chain([0.0, 3.0, 3.0 + 2.0j, 2.0j], [0.0] * 4)
    assert thinnest_wall([square]).width == pytest.approx(2.0, rel=1e-15)
    hole = Curve.circle(0.5, 2.2 + 1.1j).reversed()
    assert thinnest_wall([square, hole]) == pytest.approx((0.3, 2.85 + 1.1j), rel=1e-14)
    assert thinnest_wall([stadium(0.25, 2.0)]).width == pytest.approx(0.5, rel=1e-14)
    # the two edges of a wedge meet in a corner, and leave no wall there
    wedge = chain([0.0, 5.0, 5.0 + 1.0j], [0.0] * 3)
    assert thinnest_wall([wedge]).width > 0.9
    # a slit lies between the end of a notch and the edge below
    notched = chain([0, 3, 3 + 2j, 1.51 + 2j, 1.51 + 1j, 1.49 + 1j, 1.49 + 2j, 2j], [0.0] * 8)
    slit = chain([1.5 + 0.05j, 1.45 + 0.5j, 1.5 + 0.95j, 1.55 + 0.5j], [0.0] * 4)
    assert thinnest_wall([notched]).width == pytest.approx(1.0, rel=1e-15)
    assert thinnest_wall([notched, slit]).width == pytest.approx(1.45, rel=1e-15)
    ring = [Curve.circle(2.0), Curve.circle(1.5, 0.1j).reversed()]
    assert thinnest_wall(ring).width == pytest.approx(0.4, rel=1e-13)


def told(capsys, *words):
    code = main(["export", *words, "--json"])
    out, err = capsys.readouterr()
    assert code == 0
    return json.loads(out), err


WHEEL = ["--slots", "4", "--pins", "1", "--crank-radius", "12 mm", "--pin-radius", "1.5 mm",
         "--clearance", "0.2 mm"]  # fmt: skip


def test_thin_walls_are_told_and_warned_of(few_angles, capsys):
    found, err = told(capsys, *WHEEL, "--follower-shaft-radius", "3.3 mm")
    walls = {part["part"]: part["wall"] for part in found["parts"]}
    # a slot ends where the pin is at dead centre
    left = 0.012 * (math.sqrt(2.0) - 1.0) - 1.6e-3 - 3.3e-3
    assert walls["follower"] == pytest.approx(left, rel=1e-9)
    assert walls["driver"] == pytest.approx(0.07 * 0.012, rel=1e-9)
    assert "walls of 0.0003 m or less may not survive the cut: follower 7.06e-05 m;" in err
    _, err = told(capsys, *WHEEL, "--follower-shaft-radius", "3.3 mm", "--least-wall", "0.05 mm")
    assert "warning" not in err
    # between the end of a locking arc and the slot beside it, a tenth of the crank radius
    small = ["--slots", "6", "--pins", "1", "--crank-radius", "2 mm", "--pin-radius", "0.4 mm"]
    found, err = told(capsys, *small, "--clearance", "0.05 mm", "--kerf", "0.2 mm")
    walls = {part["part"]: part["wall"] for part in found["parts"]}
    rim = math.hypot(2.0 * math.cos(math.pi / 6.0), 0.2125)
    horn = math.acos((rim**2 + 4.0 - 0.6875**2) / (4.0 * rim))
    # the slot's wall runs beside the line at 30 degrees from the middle of the arc
    apart = rim * math.sin(math.pi / 6.0 - horn) - 0.2125
    assert walls["follower"] == pytest.approx(0.002 * apart, rel=1e-9)
    assert apart == pytest.approx(0.1, abs=2e-4)
    assert "follower 0.0002 m" in err
    _, err = told(capsys, *small, "--clearance", "0.05 mm", "--units", "in-lbf-s")
    assert "walls of 0.0118 in or less" in err


def test_parts_of_an_unlikely_size_are_warned_of_with_the_unit(few_angles, capsys):
    sizes = ["--slots", "4", "--pins", "1", "--pin-radius", "1.5", "--clearance", "0.2"]
    _, err = told(capsys, *sizes, "--crank-radius", "30")
    assert "driver is 67.2 m across; a length without a unit is in m" in err
    sizes = ["--slots", "4", "--pins", "1", "--pin-radius", "15 um", "--clearance", "1 um"]
    _, err = told(capsys, *sizes, "--crank-radius", "0.2 mm")
    assert "driver is 0.000458 m across" in err
    assert "across" not in told(capsys, *WHEEL)[1]


@pytest.mark.parametrize(
    ("given", "radius"),
    [
        ({"slots": 4, "pins": 1, "crank_radius": 0.012, "pin_radius": 1.5e-3}, 7.5e-3),
        ({"slots": 6, "pins": 2, "crank_radius": 0.02, "pin_radius": 1.5e-3}, 7e-3),
        ({"slots": 8, "pins": 1, "crank_radius": 0.02, "pin_radius": 1.5e-3}, 17.5e-3),
        ({"slots": 5, "internal": True, "crank_radius": 0.02, "pin_radius": 1.5e-3}, 12e-3),
    ],
    ids=str,
)
def test_bodies_with_a_chosen_locking_radius_clear_each_other(given, radius):
    wheel, fits = esc.Geneva(**given, clearance=2e-4), esc.Fits(locking_radius=radius)
    assert esc.motion_check(wheel, fits)[0].gap > 0.98e-4
    parts = {part.name: part for part in esc.parts_of(wheel, fits)}
    corners = parts["follower"].edge if not wheel.internal else parts["follower"].holes[0]
    radii = np.abs(corners.ends - corners.corners) / (
        2.0 * np.sin(0.5 * np.abs(corners.turns) + 1e-300)
    )
    arcs = radii[(np.abs(radii - radius) < 1e-12) & (corners.turns < 0.0)]
    assert arcs.size == wheel.slots
    disc = parts["locking-disc"].edge.corners
    assert np.abs(disc) == pytest.approx(radius - 2e-4, rel=1e-9)


@pytest.mark.parametrize(
    ("said", "given", "radius"),
    [
        ("between 0.00486437 m and 0.0104 m here, got 0.0105 m", {}, 0.0105),
        ("between 0.00486437 m and 0.0104 m here, got 0.004 m", {}, 0.004),
        ("0 for a wheel without a dwell, got 0.0075 m", {"pins": 4}, 0.0075),
    ],
)
def test_locking_radii_that_do_not_lock_are_refused(said, given, radius):
    wheel = esc.Geneva(
        **{"slots": 4, "pins": 1, "crank_radius": 0.012, "pin_radius": 1.5e-3} | given,
        clearance=2e-4,
    )
    # the rim and the wall of a slot, seen from the driver's axis
    assert 12.0 * (math.sqrt(2.0) - math.hypot(1.0, 1.6 / 12.0)) == pytest.approx(4.86437, abs=1e-5)
    with pytest.raises(InvalidValue, match=f"locking_radius must be {said}"):
        esc.parts_of(wheel, esc.Fits(locking_radius=radius))


SIZED = {
    "geneva": [*WHEEL],
    "gear-driven": ["--stations", "12", "--lobes", "3", "--curve", "hypocycloid",
                    "--fixed-radius", "30 mm", "--pin-radius", "0.5 mm", "--clearance", "20 um"],
    "elliptical-planetary": ["--sun-radius", "16 mm", "--planet-radius", "9 mm"],
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_exported_or_refused_in_one_line(
    few_angles, kind, tmp_path, capsys, monkeypatch
):
    path = tmp_path / "a.svg"
    if kind in TOUCHING:
        monkeypatch.chdir(tmp_path)
        write_inputs("export", kind)
        found, _ = told(capsys, *argv_of("export", kind, WHEELS[kind])[1:], "-o", str(path))
        assert found["least_gap"] > 0.0
        assert path.exists()
        return
    if kind in SIZED:
        found, err = told(capsys, kind, *SIZED[kind], "-o", str(path))
        assert found["kind"] == kind
        assert all(part["wall"] > 3e-4 for part in found["parts"])
        assert path.exists()
        assert "warning" not in err
        return
    (tmp_path / "a.csv").write_text("".join(f"{x},{0.7 * x}\n" for x in range(0, 91, 3)))
    given = {
        "tabulated": ["--table", str(tmp_path / "a.csv")],
        "cam-indexer": ["--stations", "8", "--index-angle", "120"],
    }
    assert main(["export", kind, *given[kind], "-o", str(path)]) == 2
    assert "has no parts that could be drawn" in capsys.readouterr().err
    assert not path.exists()


@pytest.mark.parametrize(
    ("mechanism", "refused"),
    [
        (esc.Geneva(4, 1, crank_radius=0.012, pin_radius=1.5e-3), ("clearance", "teeth")),
        (esc.GearDriven(12, 3, fixed_radius=0.03, pin_radius=5e-4), ("locking_radius", "teeth")),
        (esc.EllipticalPlanetary(0.016, 0.009), ("pin_fit", "locking_radius")),
    ],
    ids=repr,
)
def test_a_fit_acts_or_is_refused(mechanism, refused):
    def shown(**fits):
        parts = esc.parts_of(mechanism, esc.Fits(**fits))
        return [c.corners.tolist() for p in parts for c in (p.edge, *p.holes, *p.marks)]

    chosen = {
        "locking_radius": 7.5e-3, "clearance": 1e-4, "teeth": 31, "bore": "square",
        "washer_radius": 3e-3, "coupon_step": 1e-4,
    }  # fmt: skip
    geneva = {"dowel_radius", "washer_radius", "screw_radius", "coupon_step"}
    refused = {*refused} | (set() if mechanism.kind == "geneva" else geneva)
    for name in declared(esc.Fits).keys() - {"kerf"}:  # the kerf acts on the cutter's path
        given = {name: chosen.get(name, 8e-4)}
        plain = {"bore": "D"} if name == "bore_flat" else {}
        if name in refused:
            with pytest.raises(
                InvalidValue,
                match=f"{name} must be 0 for .*; (leave it out|give that of the wheel)",
            ):
                shown(**given)
        else:
            assert shown(**plain, **given) != shown(**plain)
