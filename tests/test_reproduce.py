"""Command line: what `reproduce` prints and writes of each source."""

import contextlib
import csv
import io
import json

import pytest
from matplotlib.figure import Figure

from escapement.cli import main
from escapement.errors import StorageError
from escapement.sources.filemon.nomograms import NOMOGRAMS
from escapement.units import INCH_POUND


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
    assert list(record) == ["meyer", "filemon", "dijksman", "prikhodko"]
    assert {path.name for path in folder.iterdir()} == set(record)
    assert (record["dijksman"]["cells"], record["dijksman"]["agreeing"]) == (16, 12)


FIGURES = {
    "filemon": {
        *(f"filemon_figure_{name}.pdf" for name in NOMOGRAMS),
        *(f"filemon_figure_{number}.png" for number in (*range(3, 13), 15)),
    },
    "dijksman": {
        f"dijksman_{name}.png" for name in ("figure_2", "figures_6_to_9", "charts", "motions")
    },
}


@pytest.mark.parametrize(
    ("source", "name", "wrong", "cells"),
    [("filemon", "filemon_table_1", 18, 48), ("dijksman", "dijksman_figures", 4, 16)],
)
def test_tables_and_figures_fill_a_folder(reproduced, source, name, wrong, cells):
    folder = reproduced[0] / source
    written = {path.name for path in folder.iterdir()}
    assert written == FIGURES[source] | {f"{name}.json", f"{name}.csv"}
    pictures = [path for path in folder.iterdir() if path.suffix == ".png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in pictures)
    assert json.loads((folder / f"{name}.json").read_text()) == reproduced[1][source]
    rows = list(csv.DictReader((folder / f"{name}.csv").read_text("utf-8").splitlines()))
    assert (sum(row["agrees"] == "no" for row in rows), len(rows)) == (wrong, cells)


def test_meyer(reproduced):
    folder, record = reproduced[0] / "meyer", reproduced[1]["meyer"]
    written = {path.name for path in folder.iterdir()}
    assert {"meyer_appendix_e.csv", "meyer_appendix_e.json", "meyer_figure_8.png"} <= written
    assert json.loads((folder / "meyer_appendix_e.json").read_text()) == record
    assert (record["units"], len(record["rows"])) == ("SI", 49)
    with (folder / "meyer_appendix_e.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == 49
    assert all(line["units"] == "SI" for line in table)
    torques = [(float(line["torque"]), float(line["torque_inlbf"])) for line in table]
    assert all(si == pytest.approx(inches * INCH_POUND) for si, inches in torques)


@pytest.mark.parametrize(
    ("source", "list_key", "keys"),
    [
        ("filemon", "equations", {"printed_error", "right_error"}),
        ("dijksman", "equations", {"printed_error", "right_error"}),
        ("prikhodko", "rows", {"right", "value"}),
    ],
)
def test_what_is_null_has_its_reason_in_the_message(reproduced, source, list_key, keys):
    record = reproduced[1][source]
    null = {key for entry in record[list_key] for key, value in entry.items() if value is None}
    assert null == keys
    assert all(key in record["message"] for key in keys)


def test_meyer_prints_rows_reasons_and_counts(command):
    code, out, err = command("reproduce", "meyer", "--units", "in-lbf-s")
    lines = out.splitlines()
    assert (code, err) == (0, "")
    assert sum(line.count("|") == 4 for line in lines) == 2 + 49
    assert "  1     3 0.20      0.03 |" in out
    assert "the heading swaps the inertias" in out
    assert "the program hard-codes a 90-degree cell" in out
    assert lines[-3].split() == ["as", "published", "49", "49", "44", "2.7", "%", "47"]


def test_prikhodko(command, reproduced, tmp_path, monkeypatch):
    # what the pictures show is drawn with those of all sources
    monkeypatch.setattr(Figure, "savefig", lambda _, stream, **_options: stream.write(b"drawn"))
    code, out, err = command("reproduce", "prikhodko", "-o", "there")
    assert code == 0
    assert "26.9301" in out
    assert "202.5" in out
    assert "-157.5" in out
    assert err == "escapement: tables and figures in there\n"
    made = {path.name for path in (tmp_path / "there").iterdir()}
    assert made == {path.name for path in (reproduced[0] / "prikhodko").iterdir()}
    assert made >= {
        *("prikhodko.csv", "prikhodko.json", "prikhodko_figure_2.png"),
        *("prikhodko_figure_3.png", "prikhodko_figure_6.png"),
        *(f"prikhodko_figure_{number}_synthetic.png" for number in (7, 8, 9)),
    }
    text = (tmp_path / "there" / "prikhodko.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    assert [row["right"] for row in rows if row["quantity"] == "half_width"] == ["3.34"]
    record = reproduced[1]["prikhodko"]
    assert record == json.loads((tmp_path / "there" / "prikhodko.json").read_text("utf-8"))
    assert (record["agreeing"], record["judged"]) == (8, 11)


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
