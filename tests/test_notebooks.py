"""Notebooks: stored with what they show, and executed from top to bottom without a complaint."""

import json
import re
import shutil
from pathlib import Path

import nbformat
import pytest

from notebook_tools import execute

pytestmark = pytest.mark.slow

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))
assert NOTEBOOKS
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]?\d+)?")
PADDED = re.compile(rf"\s*{NUMBER.pattern}")


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """A folder with every notebook as executed, errors included."""
    folder = tmp_path_factory.mktemp("notebooks")
    execute(folder, [shutil.copy(path, folder) for path in NOTEBOOKS])
    return folder


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_stored_in_its_form(path):
    text = path.read_text(encoding="utf-8")
    assert len(text) <= 1_000_000
    notebook = nbformat.reads(text, as_version=4)
    nbformat.validate(notebook)
    assert (notebook.nbformat, notebook.nbformat_minor) == (4, 5)
    assert text == json.dumps(json.loads(text), indent=1, ensure_ascii=False) + "\n"
    assert set(notebook.metadata) == {"kernelspec", "language_info"}
    for cell in notebook.cells:
        assert cell.metadata == {}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_without_a_complaint(path, executed):
    notebook = nbformat.read(executed / path.name, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in cells)
    outputs = [output for cell in cells for output in cell.outputs]
    assert [output for output in outputs if output.output_type == "error"] == []
    assert [output.text for output in outputs if output.get("name") == "stderr"] == []
    shown = [output for output in outputs if "image/png" in output.get("data", {})]
    # one for each exercise, and those of a source
    assert len(shown) >= {"five_exercises": 6, "geneva_or_pallets": 3}.get(path.stem, 10)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_stored_text_and_tables_are_what_the_code_gives(path, executed):
    kept, made = (
        nbformat.read(place, as_version=4).cells for place in (path, executed / path.name)
    )
    for old, new in zip(kept, made, strict=True):
        if old.cell_type == "code":
            assert (old.execution_count, pictures(old)) == (new.execution_count, pictures(new))
            was, now = texts(old), texts(new)
            # arrays are padded for the sign of zero
            assert PADDED.sub("#", was) == PADDED.sub("#", now)
            found = [list(map(float, NUMBER.findall(text))) for text in (was, now)]
            # rounding errors are printed too, and differ from machine to machine
            assert found[1] == pytest.approx(found[0], rel=1e-3, abs=1e-11)


def texts(cell):
    """All that a cell shows but pictures."""
    shown = [output.get("text", "") for output in cell.outputs]
    data = [output.get("data", {}) for output in cell.outputs]
    kinds = "text/plain", "text/markdown", "text/html"
    return "".join(shown) + "\n".join(one[kind] for one in data for kind in kinds if kind in one)


def pictures(cell):
    """How many pictures a cell shows."""
    return sum("image/png" in output.get("data", {}) for output in cell.outputs)
