"""Records that print themselves: what is declared of a result is there in text, JSON and report."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.base.records import Record
from escapement.base.results import Result
from escapement.base.units import SYSTEMS, printed
from escapement.constant_speed.index_record import INDEX
from escapement.constant_speed.indexing import IndexingDrive
from escapement.dynamics.figure_record import record_of
from escapement.dynamics.figure_table import FIGURES, OF_MOTOR, RUN_TIME
from escapement.dynamics.figures_of_merit import Figures
from escapement.model.materials import NEEDED

MODEL = ["--torque", "0.1", "--driver-inertia", "3e-6", "--follower-inertia", "5e-5"]
RUN = ["run", *MODEL, "--friction", "0.3", "--engagements", "2"]
DRIVEN = ["index", "--speed", "10", "--load-torque", "0.5", "--follower-inertia", "5e-5"]
NEW = Result("torque", "twice the greatest moment", label="double moment", digits=3)


@pytest.mark.parametrize("units", SYSTEMS)
@pytest.mark.parametrize(
    ("words", "owner", "table", "base"),
    [(RUN, Figures, FIGURES, "contact_moment_max"), (DRIVEN, IndexingDrive, INDEX, "torque_max")],
    ids=["run", "index"],
)
def test_a_new_figure_appears_everywhere(command, monkeypatch, units, words, owner, table, base):
    """By its declaration and the attribute of that name; no command knows it."""
    doubled = property(lambda found: 2.0 * getattr(found, base))
    monkeypatch.setattr(owner, "double_moment", doubled, raising=False)
    monkeypatch.setitem(table, "double_moment", NEW)
    reports = ["--report", "r.html"] if words is RUN else []
    code, out, err = command(*words, "--units", units, "--json", *reports)
    assert code == 0, err
    found = json.loads(out)
    assert found["double_moment"] == pytest.approx(2.0 * found[base], rel=1e-12)
    shown, unit = f"{found['double_moment']:.3g}", printed("torque", units)
    lines = command(*words, "--units", units)[1].splitlines()
    (line,) = [line for line in lines if line.startswith("double moment ")]
    assert line.split() == ["double", "moment", shown, *unit.split()]
    if reports:
        cells = f"<td>{shown}</td><td>{unit}</td><td>twice the greatest moment</td>"
        row = f"<tr><th scope=row>double moment</th>{cells}</tr>"
        assert row in Path("r.html").read_text(encoding="utf-8")


RESULTS = {
    "force": Result("force", missing="it has no size"),
    "again": Result("force", unlike="force"),
    "hidden": Result("force", tabled=False),
    "share": Result(digits=2),
}


def test_a_record_follows_its_declarations(capsys):
    values = {"force": 9.0, "again": 9.0, "hidden": [1.0, 2.0], "share": 0.12345, "word": "ok"}
    record = Record(values | {"rows": [{"force": 4.5, "turn_deg": 30.0}]}, RESULTS)
    pound = 4.4482216152605
    inches = record.in_units("in-lbf-s")
    assert inches["hidden"] == pytest.approx([1.0 / pound, 2.0 / pound], rel=1e-15)
    assert inches["rows"] == [{"force": pytest.approx(4.5 / pound), "turn_deg": 30.0}]
    assert record.in_units("SI") == dict(record.values)
    record.show("in-lbf-s")
    assert capsys.readouterr().out.splitlines() == [
        "force  2.02328  lbf",
        "share  0.12",
        "word   ok",
        "",
        "rows",
        "  force  turn",
        "    lbf   deg",
        "1.01164    30",
    ]


@pytest.mark.parametrize("nothing", [None, math.nan, math.inf, [1.0, math.nan], np.array([np.nan])])
def test_a_missing_number_has_its_reason(nothing):
    record = Record({"force": nothing, "again": nothing}, RESULTS)
    assert record.reasons() == ["force is not given: it has no size"]
    assert Record({"force": 1.0}, RESULTS).reasons() == []


INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
WHEEL = esc.Geneva(4, crank_radius=0.02)
UNEVEN = esc.Geneva(4, pins=1, crank_radius=0.02, slot_offsets=(1e-5, 0.0, 0.0, 0.0))


UNASKED = {RUN_TIME, "pin_load_frequency", *NEEDED}
"""Figures that need a number of turns, or the length of the pin."""


@pytest.mark.parametrize(
    ("wheel", "friction", "lacking", "reasons"),
    [
        (
            esc.Geneva(4),
            0.3,
            {"contact_force_max", "rubbing_max", "beat_error", "blow_max", "beats"},
            [],
        ),
        (WHEEL, 0.3, {"beat_error", "blow_max", "beats"}, []),
        (UNEVEN, 0.3, set(), []),
        (WHEEL, 0.9, {"beat_error", "blow_max", "beats"}, []),
    ],
)
def test_a_design_has_the_figures_that_suit_it(wheel, friction, lacking, reasons):
    """Whether it has a terminal cycle or not."""
    timer = esc.Escapement(wheel, INERTIA, 0.0113, friction=friction)
    record = record_of(esc.terminal(timer), timer)
    assert {*FIGURES, "beats"} - record.values.keys() == lacking | {*OF_MOTOR, *UNASKED}
    assert record.reasons() == reasons


def test_a_mechanism_without_slots_says_that_it_cannot_jam():
    planetary = esc.EllipticalPlanetary(0.6, 0.3)
    for efficiency in (0.9, 1.0):  # with a terminal cycle, and without
        timer = esc.Escapement(planetary, INERTIA, 0.0113, efficiency=efficiency)
        record = record_of(esc.terminal(timer), timer)
        assert not math.isfinite(record.values["critical_friction"])
        told = [reason for reason in record.reasons() if reason.startswith("critical_friction")]
        assert told == [
            "critical_friction is not given: it has no slots in which friction can jam pins"
        ]
