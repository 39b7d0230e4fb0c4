"""Motions that a page plays: their pieces against the motion, bodies, files and the notebook."""

import base64
import html
import json
import re
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

import escapement as esc
from escapement import explorer
from escapement.base.errors import InvalidValue, MissingPackage
from escapement.explorer import widget
from escapement.explorer.bodies import bodies_of
from escapement.explorer.fields import design_of
from escapement.explorer.played import COLUMNS, DEGREE, played
from escapement.outlines.bodies import Disc
from escapement.outlines.gears import EllipticalOutline, GearDrivenOutline
from escapement.outlines.geneva import GenevaOutline

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
ERRORS = {"pin_angle_errors": (1e-3, 0.0, 0.0, -1e-3), "slot_offsets": (0.0, 1e-5, 0.0, 0.0)}
WHEELS = {
    "plain": esc.Geneva(4, crank_radius=0.02),
    "dwell": esc.Geneva(6, 1),
    "internal": esc.Geneva(5, internal=True),
    "errors": esc.Geneva(4, crank_radius=0.02, pin_radius=1e-3, **ERRORS),
    "gear-driven": esc.GearDriven(4, 1, "epicycloid"),
    "elliptical": esc.EllipticalPlanetary(0.03, 0.02),
}


def motion_of(name, count=6, **numbers):
    wheel = WHEELS[name]
    own = {"efficiency": 0.9} if name == "elliptical" else {"friction": 0.05}
    return esc.simulate(esc.Escapement(wheel, INERTIA, torque=0.0113, **own | numbers), count)


def unpacked(text):
    return np.frombuffer(base64.b64decode(text), "<f8")


def states(told, times):
    """What a page shows at some times, computed anew from what it is told."""
    spans = told["spans"]
    start, stop = unpacked(spans["start"]), unpacked(spans["stop"])
    values = unpacked(spans["values"]).reshape(start.size, len(COLUMNS), DEGREE + 1)
    k = np.searchsorted(start, times, side="right") - 1
    x = 2.0 * (times - start[k]) / (stop - start)[k] - 1.0
    points = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
    rows = np.polynomial.chebyshev.chebvander(points, DEGREE)
    weights = np.polynomial.chebyshev.chebvander(x, DEGREE) @ np.linalg.inv(rows)
    return np.einsum("kcn,kn->ck", values[k], weights)


@pytest.mark.parametrize("name", WHEELS)
def test_what_is_played_is_the_motion(name):
    motion = motion_of(name)
    told = played(motion)
    times = np.sort(np.random.default_rng(3).uniform(0.0, motion.end_time, 500))
    expected = motion.at(times)
    for column, found in zip(COLUMNS, states(told, times), strict=True):
        value = getattr(expected, column)
        np.testing.assert_allclose(found, value, rtol=0.0, atol=1e-9 * np.abs(value).max())
    handoffs = [row["time"] for row in told["events"] if row["kind"] == "handoff"]
    np.testing.assert_array_equal(handoffs, motion.handoff_times)
    json.dumps(told, allow_nan=False)


def placed(body, theta, phi):
    """Where the first point of a body's path stands, and by what it is turned."""
    x, y = map(float, re.match(r"M ?(\S+) ([^\sLAZ]+)", body["path"]).groups())
    at = sum(complex(a, b) * np.exp(1j * rate * theta) for a, b, rate in body["at"])
    a, b = body["turn"]
    return complex(at + complex(x, y) * np.exp(1j * (a * theta + b * phi)))


OUTLINES = {"gear-driven": GearDrivenOutline, "elliptical": EllipticalOutline}
SAME = {"follower": "follower", "driven": "follower", "driving": "driving", "pin-0": "pin-0"}


@pytest.mark.parametrize("name", WHEELS)
def test_bodies_stand_where_the_outlines_have_them(name):
    motion = motion_of(name)
    outline = OUTLINES.get(name, GenevaOutline)(motion.escapement.mechanism)
    drawn = {body["name"]: body for body in bodies_of(motion.escapement.mechanism)["bodies"]}
    for t in np.linspace(0.0, motion.end_time, 23)[1:-1]:
        state = motion.at(t)
        theta, phi = float(state.theta), float(state.phi)
        for body in outline.bodies(theta):
            if body.name not in SAME:
                continue
            shown = drawn[SAME[body.name]]
            disc = isinstance(body, Disc)
            place = body.centre if disc else complex(body.edges[0].corners[0])
            # of a disc the centre is compared: thin pins are drawn larger, so that they are seen
            found = placed(shown | {"path": "M0 0Z"} if disc else shown, theta, phi)
            # the paths have five digits
            assert abs(found - place) < 1e-4 * max(abs(place), 1.0), (body.name, t)


def test_a_motion_of_a_file_is_played_in_one_page(command, tmp_path):
    given = ("--driver-inertia", 3.39e-7, "--follower-inertia", 5.65e-6, "--torque", 0.0113)
    assert command("run", *given, "--friction", 0.2, "--engagements", 4, "-o", "m.h5")[0] == 0
    assert command("plot", "m.h5", "-o", "m.html")[0] == 0
    text = (tmp_path / "m.html").read_text("utf-8")
    told = json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])["motion"]
    motion = esc.read_motion(tmp_path / "m.h5")
    assert told["handoff_times"] == motion.handoff_times.tolist()
    assert told["figures"]["period"] == pytest.approx(esc.terminal(motion.escapement).period)
    assert not re.findall(r"""(?:src|href)=["'](?!#|data:)|@import|url\(|fetch\(|import\(""", text)
    code, _, err = command("plot", tmp_path / "none.h5", "-o", "m.html")
    assert code == 66
    assert err.count("\n") == 1


def test_what_cannot_be_played_is_refused():
    with pytest.raises(InvalidValue, match="longer than zero to be played"):
        explorer.player(motion_of("plain", friction=0.5))
    with pytest.raises(InvalidValue, match="at most 20000 spans"):
        played(motion_of("plain", 2000))


def data_of_cell(motion):
    page = html.unescape(re.search(r'srcdoc="(.*?)"', motion._repr_html_(), re.DOTALL)[1])
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])


def test_a_cell_plays_a_motion():
    timer = esc.Escapement(WHEELS["dwell"], INERTIA, torque=0.0113, friction=0.05)
    told = data_of_cell(esc.simulate(timer, 7, initial_speed=3.0))
    assert told["design"].pop("initial_speed") == pytest.approx(3.0, rel=1e-14)
    assert told["design"].items() <= design_of(timer, 3.0, 7).items()
    # the page computes no part of an engagement, no gears, and no motion of another engine
    short = esc.simulate(timer, duration=0.05)
    assert data_of_cell(short)["motion"]["end_time"] == 0.05
    for motion in (motion_of("gear-driven", 2), esc.simulate(timer, 2, engine="ivp")):
        assert data_of_cell(motion)["motion"]["handoff_times"] == motion.handoff_times.tolist()


@pytest.mark.parametrize(
    ("motion", "reason"),
    [
        (lambda: motion_of("plain", friction=0.5), "motion must be longer than zero"),
        (lambda: motion_of("gear-driven", 21), "engagements must be at most 20 in a cell, got 21"),
    ],
)
def test_a_cell_without_a_film_says_why(motion, reason):
    text = motion()._repr_html_()
    assert reason in text
    assert "<table>" in text
    assert "<iframe" not in text


@pytest.mark.parametrize("mechanism", [*WHEELS.values()], ids=[*WHEELS])
def test_a_cell_shows_a_mechanism(mechanism):
    text = mechanism._repr_html_()
    drawing, table = text.split("<table>")
    assert ElementTree.fromstring(drawing).tag.endswith("svg")
    assert type(mechanism).__name__ in table
    assert text == mechanism._repr_html_()


def test_a_notebook_shows_the_page_and_its_design(monkeypatch):
    timer = esc.Escapement(WHEELS["plain"], INERTIA, torque=0.0113, friction=0.35)
    shown = esc.plots.explore(timer, engagements=7)
    assert {"page", "design", "height"} <= {*shown.trait_names(sync=True)}
    assert shown.page == explorer.page(timer, 0.0, 7)
    assert "srcdoc" in shown._esm
    assert "played" in esc.plots.explore(motion_of("elliptical")).page
    with pytest.raises(InvalidValue, match="an Escapement or a Motion"):
        esc.plots.explore(3)
    widget._widget.cache_clear()
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(MissingPackage, match=r"anywidget.*'\.\[notebook\]'"):
        esc.plots.explore(timer)
