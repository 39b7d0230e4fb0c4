"""The API reference: every public name has an entry with an example; test_docs.py runs them all."""

import importlib.util
import inspect
import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

import escapement as esc
from escapement import plots, synthesis
from escapement.base import errors, units

DOCS = Path(__file__).resolve().parents[1] / "docs"
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("api-*.md")))
ENTRIES = {
    heading: body
    for heading, body in re.findall(r"^### (.+?)\n(.*?)(?=^#|\Z)", TEXT, re.MULTILINE | re.DOTALL)
}
NAMES = [name for heading in ENTRIES for name in re.findall(r"`(.+?)`", heading)]
_IMPORT = re.compile(r"^from escapement\.([\w.]+) import (.+?)(?:  #.*)?$", re.MULTILINE)


def public() -> set[str]:
    """Names that the package offers, by their paths in it."""
    found = {
        name
        for name in esc.__all__
        if name != "__version__" and not inspect.ismodule(getattr(esc, name))
    }
    for module in (plots, synthesis, units, errors):
        home = module.__name__.replace("escapement.base.", "escapement.")
        for name, value in vars(module).items():
            own = getattr(value, "__module__", home).startswith("escapement")
            if name[0] != "_" and own and not inspect.ismodule(value):
                found.add(f"{home.removeprefix('escapement.')}.{name}")
    return found


def imported() -> set[str]:
    """Names that the pages import from modules of the package."""
    pages = [path.read_text(encoding="utf-8") for path in DOCS.glob("*.md")]
    found = _IMPORT.findall("\n".join(pages))
    names = {f"{home}.{name.strip()}" for home, line in found for name in line.split(",")}
    found = {name for name in names if not inspect.ismodule(resolve_name(f"escapement.{name}"))}
    # the page names `units` and `errors`, which the package offers, without their room
    return {re.sub(r"^base\.(units|errors)\.", r"\1.", name) for name in found}


def test_every_public_name_has_one_entry():
    assert public() | imported() <= set(NAMES)
    assert len(NAMES) == len(set(NAMES))
    for name in NAMES:
        assert resolve_name(f"escapement{'.' if '.' in name else ':'}{name}").__doc__


@pytest.mark.parametrize("heading", ENTRIES)
def test_every_entry_has_an_example_that_uses_it(heading):
    code = "".join(re.findall(r"^```\w+\n(.*?)^```", ENTRIES[heading], re.MULTILINE | re.DOTALL))
    for name in re.findall(r"`(.+?)`", heading):
        assert re.search(rf"\b{name.rpartition('.')[2]}\b", code), name


def test_no_module_hides_a_public_name():
    # importing such a module would put it in the place of the function
    for name in esc.__all__:
        hidden = importlib.util.find_spec(f"escapement.{name}") is not None
        assert not hidden or inspect.ismodule(getattr(esc, name)), name
