"""Whatever a command prints, draws or reports is in the units that the user chose."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from command_scenes import COMMAND_KINDS, argv_of, scenes_of, write_inputs
from escapement.base.spoken import speak
from escapement.base.units import INCH_POUND, SYSTEMS, printed
from escapement.cli._arguments import parser_of
from escapement.mechanisms import DEFAULT_KIND

UNIT = r"(?:(?<=[(\[])|(?<=\d )|(?<=  ))(?:{})(?=$|[\s)\],;:.])"
"""A unit after a number, in brackets, or in a column of its own."""
FOREIGN = {
    "in-lbf-s": re.compile(
        UNIT.format("[mµn]?N m.*?|[kµm]?g(?: m.*?)?|[mµ]?m|N/m|m/s|[JWN]|rpm|MPa|deg/s")
    ),
    "mm": re.compile(UNIT.format("in|lbf|in-lbf.*?|lbf.*?|m?rad|rad/s|k?Pa|[mµn]?N m|kg m²|m|J")),
}
"""Units of the other systems."""
FILES = {"sweep": {"config": "study.toml", "quiet": True, "force": True}}
SHOWN = {"plot": "shown.svg", "report": "shown.html"}
WRITTEN = {"plot": "drawn.svg", "explore": "page.html"}


def texts_of(path):
    """The lines of words in a picture, a report or a page."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".html":
        # these tables of a report have what went in, in all systems
        inputs = r"<section><h2>(The design|What is asked for)<.*?</section>"
        text = re.sub(inputs, "", text, flags=re.DOTALL)
        text = re.sub(r"<style>.*?</style>|<script.*?</script>", "", text, flags=re.DOTALL)
    text = re.sub(r"<(?:style|defs|metadata)\b.*?</(?:style|defs|metadata)>", "", text, flags=re.S)
    return [line.strip() for line in re.split(r"<[^>]*>", text) if line.strip()]


DRAWN = "mechanism", "export"
"""Commands whose output differs most from kind to kind."""
TRIED = [
    (name, kind, units)
    for units in SYSTEMS[1:]
    for name, kind in COMMAND_KINDS
    if (name in FILES or scenes_of(name, kind))
    if kind == DEFAULT_KIND or (name in DRAWN and units == SYSTEMS[1])
]
"""A unit that is always the same is one of the others in one of these."""


@pytest.mark.parametrize(
    ("name", "kind", "units"),
    [
        pytest.param(*one, id="-".join(one), marks=[pytest.mark.slow] * (one[2] == SYSTEMS[2]))
        for one in TRIED
    ],
)
def test_no_output_has_a_unit_of_the_other_system(command, few_angles, name, kind, units):
    write_inputs(name, kind)
    scene = FILES.get(name) or scenes_of(name, kind)[0]
    scene = {key: x for key, x in scene.items() if key != "tried"} | {"units": units}
    known = {action.dest for action in parser_of(name)[1]._actions}
    scene |= {key: file for key, file in SHOWN.items() if key in known}
    if name in WRITTEN:
        scene |= {"output": WRITTEN[name]}
    code, out, err = command(*argv_of(name, kind, scene))
    assert code in (0, 3), err
    # the first table has the inputs in both systems
    lines = [*out.partition("\n\n")[2].splitlines(), *err.splitlines()]
    for file in {*SHOWN.values(), *WRITTEN.values()}:
        lines += texts_of(Path(file)) if Path(file).exists() else []
    assert len(lines) > 1
    assert [line for line in lines if FOREIGN[units].search(line)] == []


RUN = ["--torque", "0.1", "--driver-inertia", "3e-6", "--follower-inertia", "50e-6"]
RUN += ["--friction", "0.3", "--crank-radius", "0.8", "--engagements", "2"]


def test_a_figure_has_the_numbers_of_its_unit():
    """Those of the same motion, times the size of the unit."""
    wheel = esc.Geneva(4, crank_radius=0.02)
    timer = esc.Escapement(wheel, esc.Inertia(3.39e-7, 5.65e-6), 0.0113, friction=0.3)
    motion, greatest = esc.simulate(timer, 2), {}
    for system, unit in zip(SYSTEMS, ("(mN m)", "(in-lbf)", "(N mm)"), strict=True):
        speak(system)
        try:
            ax = esc.plots.plot_contact_moment(motion)
        finally:
            speak(SYSTEMS[0])
        assert unit in ax.get_ylabel()
        curve = next(line for line in ax.lines if line.get_label() == "contact moment")
        greatest[system] = np.nanmax(curve.get_ydata())
    assert greatest["mm"] == pytest.approx(greatest["SI"], rel=1e-12)  # mN m is N mm
    inches = 1e-3 * greatest["SI"] / INCH_POUND
    assert greatest["in-lbf-s"] == pytest.approx(inches, rel=1e-12)


def test_a_report_has_the_numbers_of_the_command(command):
    for units in SYSTEMS:
        argv = ["run", *RUN, "--units", units, "--report", "r.html", "--json"]
        code, out, err = command(*argv)
        assert code == 0, err
        found, lines = json.loads(out), texts_of(Path("r.html"))
        for name, unit in (("contact moment max", "torque"), ("contact force max", "force")):
            row = lines.index(name)
            value = found[name.replace(" ", "_")]
            assert lines[row + 1 : row + 3] == [f"{value:.6g}", printed(unit, units)]


def test_the_page_begins_in_the_units_of_the_command(command):
    for units in SYSTEMS:
        assert command("explore", *RUN, "--units", units, "-o", "p.html", "--force")[0] == 0
        text = Path("p.html").read_text()
        data = json.loads(re.search(r'id="?data"?[^>]*>(.*?)</script>', text, re.S)[1])
        assert data["units"] == units


def test_a_motion_is_read_back_from_any_units(tmp_path):
    timer = esc.Escapement(
        esc.Geneva(4, crank_radius=0.02), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, friction=0.3
    )
    motion = esc.simulate(timer, 2)
    read = []
    for units in SYSTEMS:
        esc.write_motion(motion, tmp_path / f"{units}.h5", units=units)
        read.append(esc.read_motion(tmp_path / f"{units}.h5"))
        assert abs(read[-1].ledger.residual) < 1e-10
    for other in read[1:]:
        assert other.trajectory.losses == pytest.approx(read[0].trajectory.losses, rel=1e-14)
        assert other.handoff_velocities == pytest.approx(motion.handoff_velocities, rel=1e-14)


def test_a_motion_is_drawn_in_the_users_units(command):
    assert command("run", *RUN, "--units", "in-lbf-s", "-o", "m.h5")[0] == 0
    for units, name in zip(SYSTEMS, ("N m", "in-lbf", "N mm"), strict=True):
        assert command("plot", "m.h5", "--units", units, "-o", "m.svg")[0] == 0
        (label,) = [line for line in texts_of(Path("m.svg")) if "Moment on the follower" in line]
        assert name in label


WISH = (
    'units = "in-lbf-s"\nperiod = 0.05\ntorque = {torque}\nslots = 4\n'
    "bounds = {{ size = {size} }}\n"
)
STUDY = (
    'units = "in-lbf-s"\ntorque = 0.1\nmechanism = {{ slots = 4, crank_radius = 1, {} }}\n'
    "inertia = {{ driver = 3e-6, follower = 5e-6 }}\nsweep = {{ friction = [0.1, 0.2] }}\n"
)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("design", WISH.format(torque=-2, size=4), "got -2; give a number in this range in in-l"),
        ("design", WISH.format(torque="[3, 2]", size=4), "got [3, 2]; swap them"),
        ("design", WISH.format(torque=0.1, size=-4), "got -4; give a number in this range in inch"),
        ("design", WISH.format(torque=0.1, size=1e-3), "size must be at most 0.001 in"),
        ("sweep", STUDY.format("pin_radius = 0.9"), "got 0.9 in;"),
        ("sweep", STUDY.format("pin_radius = -0.9"), "give the radius in inches, 0 for"),
    ],
)
def test_a_file_is_answered_in_its_own_units(command, name, text, said):
    Path("file.toml").write_text(text)
    code, _, err = command(name, "file.toml")
    assert code in (2, 3, 65)
    assert said in err
