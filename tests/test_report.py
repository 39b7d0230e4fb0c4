"""The report of a design: one HTML file."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

import escapement as esc
from escapement.base.errors import CannotCreate, InvalidValue
from escapement.base.units import INCH_POUND
from escapement.cli import main
from escapement.reports.assumptions import left_out
from escapement.sources import meyer

WHEEL = esc.Geneva(4, crank_radius=0.010, pin_radius=0.0005)
TIMER = esc.Escapement(WHEEL, esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.20)
VOID = {"meta", "link", "br", "img", "path", "use", "rect"}


class Page(HTMLParser):
    """Every tag in turn must be closed; headings and texts are kept."""

    def __init__(self, text):
        super().__init__()
        self.open, self.headings, self.texts = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("h1", "h2"):
            self.headings.append(data)
        self.texts.append(data)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "design.html"
    tolerances = {"friction": {"low": 0.15, "high": 0.25}}
    limits = {"period": (0.030, 0.040)}
    wound = esc.Escapement(WHEEL, TIMER.inertia, 0.0113, friction=0.2, spring_rate=5e-4)
    budget = esc.budget(wound, tolerances, limits=limits, size=200)
    esc.report(wound, path, budget=budget, title="A <four-pin> timer & its spring")
    return path.read_text(encoding="utf-8")


def test_a_report_has_every_section_and_is_well_formed(written):
    page = Page(written)
    assert page.open == []
    assert page.headings == [
        "A <four-pin> timer & its spring", "The design", "What it does", "Drawing and velocities",
        "How it runs down", "What the tolerances do", "What is assumed",
    ]  # fmt: skip


def test_a_report_asks_for_nothing_from_elsewhere(written):
    assert not re.search(r"<(script|link|img|iframe|object)", written)
    sources = re.findall(r'(?:src|href)="([^"]*)"', written)
    assert all(source.startswith("#") for source in sources)
    assert not re.search(r"url\((?!#)", written)


def test_the_figures_are_those_of_the_design(written):
    cycle = esc.terminal(TIMER)
    texts = Page(written).texts
    for value in (cycle.period, cycle.velocity_max, cycle.contact_force_max, cycle.jam_margin):
        assert f"{value:.6g}" in texts
    # torque in both systems of units
    assert {"0.0113 N m", "0.100013 in-lbf"} <= {*texts}


def test_what_is_given_is_not_told_to_be_missing():
    told = {name for name, _ in left_out(TIMER)}
    assert "friction of the bearings" in told
    assert "width of the pins" not in told
    more = esc.Escapement(
        WHEEL, TIMER.inertia, 0.0113, driver_bearing_torque=1e-4, driver_drag=1e-9,
        follower_viscous=1e-7, spring_rate=1e-4,
    )  # fmt: skip
    left = {name for name, _ in left_out(more)}
    assert left == {"clearance between pin and slot", "errors of the parts"}


def test_the_effect_of_clearance_is_as_large_as_told():
    told = dict(left_out(TIMER))["clearance between pin and slot"]
    low, high = map(float, re.search(r"([\d.]+) to ([\d.]+) %", told).groups())
    found = []
    for slots, torque in ((3, 0.06), (4, 0.10), (6, 0.10)):
        inertia = esc.Inertia(*(it * INCH_POUND for it in meyer.INERTIAS[slots]))
        for friction in (0.20, 0.35):
            fitting, loose = (
                esc.terminal(esc.Escapement(wheel, inertia, torque * INCH_POUND, friction)).period
                for wheel in (esc.Geneva(slots, crank_radius=1.0, clearance=c) for c in (0.0, 1e-3))
            )
            found.append(100.0 * (loose / fitting - 1.0))
    assert (round(min(found), 1), round(max(found), 1)) == (low, high)
    page = Path(__file__).parents[1].joinpath("docs", "clearance.md").read_text("utf-8")
    assert f"by {low} to {high} % for" in " ".join(page.split())


def test_a_report_that_cannot_be_is_refused(tmp_path):
    with pytest.raises(InvalidValue, match=r"must end in \.html"):
        esc.report(TIMER, tmp_path / "design.pdf")
    path = tmp_path / "design.html"
    path.write_text("mine")
    with pytest.raises(CannotCreate):
        esc.report(TIMER, path)
    assert path.read_text() == "mine"


def test_commands_write_reports(tmp_path, capsys):
    words = "run --slots 4 --torque 0.0113 --driver-inertia 3.39e-7 --follower-inertia 5.65e-6"
    path = tmp_path / "run.html"
    assert main([*words.split(), "--friction", "0.3", "--report", str(path)]) == 0
    assert Page(path.read_text(encoding="utf-8")).open == []
    assert main([*words.split(), "--report", str(tmp_path / "a.pdf")]) == 2
    assert "must end in .html" in capsys.readouterr().err


def test_a_report_gives_lists_in_both_systems(command):
    """Each number of a list, as that of a single number: 1 mm is 0.0393701 in."""
    Path("curve.csv").write_text("0,0.01\n2,0.02\n")
    sizes = ["--slots", "4", "--crank-radius", "0.02", "--slot-offsets", "0,0,0,1e-5"]
    drive = ["--torque", "curve.csv", "--driver-inertia", "3e-7", "--follower-inertia", "5e-6"]
    code, _, err = command("run", *sizes, *drive, "--engagements", "2", "--report", "r.html")
    assert code == 0, err
    text = Path("r.html").read_text(encoding="utf-8")
    for row in (
        "<td>0, 0, 0, 1e-05 m</td><td>0, 0, 0, 0.000393701 in</td>",
        "<td>0.01, 0.02 N m</td><td>0.0885075, 0.177015 in-lbf</td>",
    ):
        assert row in text


def test_a_report_of_designs_has_the_wish_the_front_and_the_run(tmp_path):
    """Run times at both ends of the friction, and the table of what decides, found another way."""
    path, wish = tmp_path / "design.html", tmp_path / "wish.toml"
    task = {"total_time": 2.0, "turns": 10.0, "torque": 0.01, "slots": 6, "internal": False}
    wish.write_text("\n".join(f"{name} = {json.dumps(value)}" for name, value in task.items()))
    assert main(["design", str(wish), "--count", "1", "--report", str(path)]) == 0
    page = Page(path.read_text(encoding="utf-8"))
    assert page.open == []
    assert page.headings == [
        "Timers for a requirement", "What is asked for", "The designs", "The design",
        "What it does", "Over the range of friction", "Drawing and velocities",
        "How it runs down", "What is assumed",
    ]  # fmt: skip
    (one,) = esc.design(esc.Requirement(**task), count=1).designs
    for friction in (0.25, 0.35):
        run = esc.rundown(replace(one.timer, friction=friction), turns=10)
        assert f"{run.end_time:.6g}" in page.texts
    for name in ("scatter", "jam_margin", "driver_thickness", "follower_thickness", "pressure_max"):
        assert f"{one.values[name]:.6g}" in page.texts
    assert f"{esc.parts_of(one.mechanism)[0].wall.width:.6g}" in page.texts
