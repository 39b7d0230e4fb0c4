"""The rooms of the package: the pages, the contract and the reading guides name what is there."""

import ast
import re
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[1]
PACKAGE = TOP / "src" / "escapement"
ROOMS = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
GUIDED = sorted(
    path.parent for path in PACKAGE.rglob("__init__.py") if len([*path.parent.glob("*.py")]) > 6
)


def layers():
    """The layers of the contract, the highest first."""
    settings = tomllib.loads((TOP / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (contract,) = (it for it in contracts if it.get("containers") == ["escapement"])
    return [set(re.findall(r"\w+", layer)) for layer in contract["layers"]]


def test_nothing_stands_loose_at_the_top():
    files = {path.name for path in PACKAGE.glob("*.py*")}
    assert files == {"__init__.py", "__init__.pyi", "__main__.py"}


def test_every_room_has_its_layer():
    assert set.union(*layers()) == ROOMS


def test_the_table_of_rooms_has_every_room_in_the_order_of_the_layers():
    text = (TOP / "docs" / "design.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) \|", text, re.MULTILINE)
    named = [set(re.findall(r"\w+", row)) for row in rows]
    found = [room for row in named if row <= ROOMS for room in row]
    assert sorted(found) == sorted(ROOMS)
    order = {room: i for i, layer in enumerate(layers()) for room in layer}
    places = [{order[room] for room in row} for row in named if row <= ROOMS]
    assert all(max(above) <= min(below) for above, below in pairwise(places))


@pytest.mark.parametrize("room", GUIDED, ids=lambda room: room.name)
def test_a_large_room_has_a_reading_guide_that_names_its_files(room):
    guide = ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8"))) or ""
    files = {path.stem for path in room.glob("*.py")} - {"__init__"}
    files |= {path.parent.name for path in room.glob("*/__init__.py")}
    missing = sorted(name for name in files if not re.search(rf"\b{name}\b", guide))
    assert not missing
