"""Command line: what `reproduce` prints and writes of each source."""

import contextlib
import csv
import io
import json
from xml.etree import ElementTree

import pytest
from matplotlib.figure import Figure

from escapement.base.errors import StorageError
from escapement.base.units import INCH_POUND
from escapement.cli import main
from escapement.sources.filemon.nomograms import NOMOGRAMS

pytestmark = pytest.mark.slow

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    """Folder and report of `reproduce all`; its pictures are coarse, but all drawn."""
    folder = tmp_path_factory.mktemp("reproduced") / "all"
    whole, report = Figure.savefig, io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(report):
        patch.setattr(Figure, "savefig", lambda *args, **kw: whole(*args, **(kw | {"dpi": 30})))
        assert main(["reproduce", "all", "-o", str(folder), "--json"]) == 0
    return folder, json.loads(report.getvalue())


def test_all_is_each_source_in_a_folder_of_its_own(reproduced):
    folder, record = reproduced
    assert record["inputs"] == {"units": "in-lbf-s", "source": "all"}
    assert list(record) == ["inputs", "meyer", "filemon", "dijksman", "prikhodko"]
    assert {path.name for path in folder.iterdir()} == set(record) - {"inputs"}
    assert (record["dijksman"]["cells"], record["dijksman"]["agreeing"]) == (16, 12)


FIGURES = {
    "meyer": {f"figure{name}" for name in ("_8", "_9", "_10", "_11", "s_12_to_14")},
    "filemon": {f"figure_{name}" for name in (*range(3, 13), 15, *NOMOGRAMS)},
    "dijksman": {"figure_2", "figures_6_to_9", "charts", "motions"},
    "prikhodko": {
        *("figure_2", "figure_3", "figure_6", "equation_9"),
        *(f"figure_{number}_synthetic" for number in (7, 8, 9)),
    },
}


@pytest.mark.parametrize(
    ("source", "name", "wrong", "cells"),
    [
        ("meyer", "meyer_appendix_e", 0, 49),
        ("filemon", "filemon_table_1", 18, 48),
        ("dijksman", "dijksman_figures", 4, 16),
        ("prikhodko", "prikhodko", 3, 17),
    ],
)
def test_tables_and_figures_fill_a_folder(reproduced, source, name, wrong, cells):
    folder = reproduced[0] / source
    written = {path.name for path in folder.iterdir()}
    figures = {f"{source}_{figure}.png" for figure in FIGURES[source]}
    assert written == figures | {f"{name}.json", f"{name}.csv"}
    pictures = [path for path in folder.iterdir() if path.suffix == ".png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in pictures)
    record = json.loads((folder / f"{name}.json").read_text("utf-8"))
    assert next(iter(record.items())) == ("inputs", reproduced[1]["inputs"])
    assert record == {"inputs": record["inputs"]} | reproduced[1][source]
    rows = list(csv.DictReader((folder / f"{name}.csv").read_text("utf-8").splitlines()))
    assert (sum(bool(row.get("reason")) for row in rows), len(rows)) == (wrong, cells)


def test_inputs_of_meyer_are_in_his_units_or_those_asked_for(reproduced, report):
    own, si = reproduced[1]["meyer"], report("reproduce", "meyer", "--units", "SI")
    assert (own["units"], si["units"]) == ("in-lbf-s", "SI")
    for record, factor in ((own, 1.0), (si, INCH_POUND)):
        for row in record["rows"]:
            assert row["torque"] == pytest.approx(row["torque_inlbf"] * factor, rel=1e-15)


@pytest.mark.parametrize("source", ["filemon", "dijksman"])
def test_text_of_an_svg_is_text(command, tmp_path, source):
    """With Greek letters, and numbers in halos on curves; curves of letters would be paths."""
    assert command("reproduce", source, "-o", "drawn", "--format", "svg")[0] == 0
    drawn = {path.stem: path for path in (tmp_path / "drawn").glob("*.svg")}
    assert set(drawn) == {f"{source}_{figure}" for figure in FIGURES[source]}
    for path in drawn.values():
        groups = [
            it for it in ElementTree.parse(path).iter(f"{SVG}g") if "text_" in it.get("id", "")
        ]
        assert len(groups) > 5
        assert all(group.find(f".//{SVG}text") is not None for group in groups)


def test_a_format_without_a_folder_is_refused(refusal):
    assert "--format must come with --output DIR" in refusal(
        2, "reproduce", "meyer", "--format", "pdf"
    )
    assert "--format must be one of png, pdf, svg" in refusal(
        2, "reproduce", "meyer", "--format", "gif"
    )


def test_what_is_null_has_its_reason_in_the_message(reproduced):
    record = reproduced[1]["prikhodko"]
    null = {key for entry in record["rows"] for key, value in entry.items() if value is None}
    assert null == {"true", "value"}
    assert all(key in record["message"] for key in null)


def test_reports_keep_to_100_columns(command):
    assert max(map(len, command("reproduce", "all")[1].splitlines())) <= 100


@pytest.mark.parametrize("source", ["prikhodko", "all"])
def test_a_full_disk_is_code_74_and_leaves_no_new_folder(command, tmp_path, monkeypatch, source):
    def full(path, *_, **__):
        raise StorageError(f"writing {path} failed: the disk is full; nothing was left behind")

    monkeypatch.setattr("escapement.cli.reproduce.replace_file", full)
    monkeypatch.setattr("escapement.cli.reproduce.SOURCES", ("prikhodko",))
    (tmp_path / "mine").mkdir()
    for name in ("new", "mine"):
        assert command("reproduce", source, "-o", name)[0] == 74
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]
