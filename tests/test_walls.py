"""Thinnest walls of parts against closed forms and dense samples; a chosen locking radius."""

import json
import math

import numpy as np
import pytest
from matplotlib.path import Path
from scipy.spatial import cKDTree

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


def _lengths(edge):
    half = 0.5 * edge.turns
    return np.abs(edge.ends - edge.corners) / np.sinc(half / np.pi)


def _arc(start, end, middle, share):
    """Points of the circle through start, middle and end, even shares of its angle."""
    if abs(middle.imag) < 1e-9:
        return start + (end - start) * share
    # the angle at the middle tells the turn
    turn = 2.0 * (math.pi - abs(np.angle((0.0 - middle) / (1.0 - middle))))
    turn = math.copysign(turn, -middle.imag)
    centre = 0.5 + 0.5j / math.tan(0.5 * turn)
    return start + (end - start) * (centre - centre * np.exp(1j * turn * share))


def sampled_wall(edges, step):
    """Least distance of two samples of the edges that face each other across the body.

    Knows only points along the edges: normals are differences of neighbours, and whether a point
    lies within the body is told by a polygon. Two ways that meet in a corner count only where
    they are square to each other: the tip of the corner is no wall. For a crescent this is where
    it is widest, which samples do not find.
    """
    places, normals, owners = [], [], []
    for edge in edges:
        first = len(owners)
        for one, length in zip(edge.at([0.0, 0.5, 1.0]), _lengths(edge), strict=True):
            following = first + (len(owners) - first + 1) % edge.corners.size
            count = max(3, math.ceil(length / step))
            middle = (one[1] - one[0]) / (one[2] - one[0])
            z = _arc(one[0], one[2], middle, np.linspace(0.0, 1.0, count))
            along = np.gradient(z)
            along[[0, -1]] += np.array([-0.5, 0.5]) * (np.diff(along[[0, 1, -2, -1]])[[0, 2]])
            places.append(z)
            owners.append((len(owners), following))
            normals.append(1j * along / np.abs(along))
    z, inward = np.concatenate(places), np.concatenate(normals)
    own, after = (np.repeat(ids, [p.size for p in places]) for ids in np.transpose(owners))
    flat = np.column_stack([z.real, z.imag])
    closed = [edge.drawn(2e-3) for edge in edges]
    codes = [[Path.MOVETO, *[Path.LINETO] * (p.size - 2), Path.CLOSEPOLY] for p in closed]
    polygon = Path(
        np.column_stack([np.concatenate(closed).real, np.concatenate(closed).imag]),
        np.concatenate(codes),
    )
    tree, reach = cKDTree(flat), 4.0 * step
    while True:
        pairs = tree.query_pairs(reach, output_type="ndarray")
        first, second = pairs.T
        way = z[second] - z[first]
        width = np.abs(way)
        one, other = inward[first], inward[second]
        meet = (own[first] == after[second]) | (after[first] == own[second])
        least = np.where(meet, 0.9999, 0.5) * width
        facing = ((way * one.conj()).real > least) & ((-way * other.conj()).real > least)
        facing &= (one * other.conj()).real < -0.5
        facing &= width > 1e-9
        order = np.flatnonzero(facing)[np.argsort(width[facing])]
        for k in order:
            middle = 0.5 * (z[pairs[k, 0]] + z[pairs[k, 1]])
            if polygon.contains_point((middle.real, middle.imag)):
                return float(width[k])
        reach *= 2.0


_STEP = 2e-5  # distance of samples [m]


def random_part(random):
    """A part of a random wheel, and its fits."""
    while True:
        size = 10.0 ** random.uniform(-2.3, -1.5)
        given = {"crank_radius": size, "pin_radius": size * random.uniform(0.03, 0.15)}
        given["clearance"] = size * random.uniform(0.0, 0.02)
        given["internal"] = bool(random.random() < 0.25)
        fits = {
            "follower_shaft_radius": size * random.choice([0.0, random.uniform(0.05, 0.25)]),
            "driver_shaft_radius": size * random.uniform(0.05, 0.2),
            "locking_radius": size * random.choice([0.0, random.uniform(0.5, 0.85)]),
        }
        try:
            parts = esc.parts_of(
                esc.Geneva(int(random.integers(3, 13)), 1, **given), esc.Fits(**fits)
            )
        except InvalidValue:
            continue
        part = parts[random.integers(len(parts))]
        if not (given["internal"] and part.name == "locking-disc"):
            return part


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_walls_of_random_wheels_are_those_of_dense_samples(seed):
    part = random_part(np.random.default_rng([40, seed]))
    edges = (part.edge, *part.holes)
    assert abs(sampled_wall(edges, _STEP) - part.wall.width) < 1e-6


@pytest.mark.parametrize("name", ["follower", "pin-disc", "carrier", "planet", "fixed-gear"])
def test_walls_of_a_gear_driven_wheel(name):
    wheel = esc.GearDriven(12, 3, fixed_radius=0.01, pin_radius=2e-4)
    part = {p.name: p for p in esc.parts_of(wheel)}[name]
    assert abs(sampled_wall((part.edge, *part.holes), _STEP) - part.wall.width) < 1e-6
