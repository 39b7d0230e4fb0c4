"""The indexer with a cam: laws of motion, both engines, and the index at constant speed."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.mechanisms.cam_indexer import LAWS

# greatest y' and y'' as handbooks of cam design print them
PRINTED = {
    "cycloidal": (2.0, 6.2832), "modified-sine": (1.7596, 5.5280),
    "modified-trapezoid": (2.0, 4.8881), "polynomial-345": (1.875, 5.7735),
}  # fmt: skip


def indexer(law="modified-sine", stations=8, degrees=120.0):
    return esc.CamIndexer(stations, math.radians(degrees), law)


@pytest.mark.parametrize("law", LAWS)
def test_a_law_has_its_characteristic_values(law):
    drive = esc.index(indexer(law), 1.0, follower_inertia=1.0)
    step, angle = math.pi / 4.0, math.radians(120.0)
    fastest, strongest = PRINTED[law]
    assert drive.mechanism.transmission_max * angle / step == pytest.approx(fastest, abs=5e-5)
    assert drive.contact_moment_max * angle**2 / step == pytest.approx(strongest, abs=5e-5)


@pytest.mark.parametrize("law", LAWS)
def test_the_position_is_the_integral_of_the_slope(law):
    known = LAWS[law]
    for end in (0.1, 0.2, 0.3, 0.4, 0.5):
        inner = [corner for corner in known.corners if corner < end]
        area = quad(lambda s: float(known.slope(np.array(s))), 0.0, end, points=inner or None)[0]
        assert float(known.position(np.array(end))) == pytest.approx(area, abs=1e-13)
    assert float(known.position(np.array(0.5))) == pytest.approx(0.5, abs=1e-15)


def test_the_follower_steps_and_rests():
    cam = indexer()
    ends = cam.follower_angle([-math.pi / 3, math.pi / 3, math.pi, 2 * math.pi - math.pi / 3])
    assert ends == pytest.approx([-math.pi / 8, math.pi / 8, math.pi / 8, math.pi / 8], abs=1e-15)
    assert cam.follower_angle(2 * math.pi) == pytest.approx(math.pi / 4, abs=1e-15)
    assert cam.transmission(math.pi).g == 0.0
    assert cam.motion_ratio == pytest.approx(1.0 / 3.0)


def test_a_law_without_jumps_rings_less_than_a_geneva():
    # the numbers of the page on indexing drives
    wheel, cam = esc.Geneva(6, pins=1), indexer("cycloidal", 6)
    one, two = (
        esc.index(m, 2 * math.pi, follower_inertia=0.4, load_frequency=15.0) for m in (wheel, cam)
    )
    assert one.index_time == pytest.approx(two.index_time)
    assert two.residual_amplitude < one.residual_amplitude / 5.0


def test_an_index_of_a_whole_turn_has_no_dwell():
    cam = indexer(degrees=360.0)
    assert cam.motion_ratio == 1.0
    assert esc.index(cam, 1.0, follower_inertia=1.0).dwell_time == 0.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"stations": 0}, "stations must be"),
        ({"degrees": 361.0}, "index_angle must be at most a turn"),
        ({"degrees": 0.0}, "index_angle must be greater than 0"),
        ({"law": "sine"}, "law must be"),
    ],
)
def test_refusals(given, words):
    with pytest.raises(InvalidValue, match=words):
        indexer(**given)
