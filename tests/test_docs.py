"""Documentation: its code runs, its sessions print what they show, its links lead somewhere."""

import ast
import contextlib
import inspect
import io
import json
import math
import re
import runpy
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from decimal import Decimal, InvalidOperation
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote

import pytest

import escapement as esc
from escapement.base import errors
from escapement.base.units import INCH_POUND
from escapement.cli import COMMANDS, main
from escapement.cli._arguments import parser_of
from escapement.inverse_design.requirement import requirement_of
from escapement.study.parse import parse_plan

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
LANGUAGES = {"python", "toml", "console", "sh", "text"}
LARGEST_IMAGE, LARGEST_FILM = 150_000, 300_000
INERTIAS = "--driver-inertia 1e-6 --follower-inertia 1e-5"
FIGURES = ("period", "velocity_mean", "velocity_max", "velocity_min")

_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"")
_INLINE = re.compile(r"`([^`\n]+)`")


class Block(NamedTuple):
    """A fenced block: its language, its text, and the text right below it."""

    language: str
    text: str
    below: str | None


def blocks(page: Path, *languages: str) -> Iterator[Block]:
    """The fenced blocks of a page, or those in some languages."""
    text = page.read_text(encoding="utf-8")
    fences = list(_FENCE.finditer(text))
    for fence, after in zip_longest(fences, fences[1:]):
        touching = after is not None and not text[fence.end() : after.start()].strip()
        below = after[2] if touching and after is not None and after[1] == "text" else None
        if not languages or fence[1] in languages:
            yield Block(fence[1], fence[2], below)


def having(language: str) -> list[Path]:
    return [page for page in PAGES if any(blocks(page, language))]


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """An empty folder with the studies of the repository in it."""
    shutil.copytree(ROOT / "runs", tmp_path / "runs", ignore=shutil.ignore_patterns("*.h5"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


# --- code and sessions --------------------------------------------------------------------


def same_token(shown: str, found: str) -> bool:
    """Equal, or numbers of one length that are one apart in their last digit."""
    if shown == found:
        return True
    try:
        a, b = (Decimal(token.strip('",[]')) for token in (shown, found))
    except InvalidOperation:
        return False
    last = Decimal(1).scaleb(int(a.as_tuple().exponent)) if a.is_finite() else Decimal(0)
    in_full = math.isclose(a, b, rel_tol=1e-9)
    return in_full or (len(shown) == len(found) and abs(a - b) <= last)


def same_line(shown: str, found: str) -> bool:
    """Equal, blanks too; dots in a line stand for anything."""
    if "..." in shown:
        pattern = ".*".join(map(re.escape, shown.split("...")))
        return re.fullmatch(pattern, found) is not None
    a, b = (re.split(r"(\s+)", line) for line in (shown, found))
    return len(a) == len(b) and all(map(same_token, a, b))


def matches(shown: list[str], found: list[str]) -> bool:
    """Whether lines are those shown, in which a line of dots stands for any lines."""
    if not shown:
        return not found
    if shown[0].strip() == "...":
        return any(matches(shown[1:], found[i:]) for i in range(len(found) + 1))
    return bool(found) and same_line(shown[0], found[0]) and matches(shown[1:], found[1:])


def compare(shown: str, printed: str) -> None:
    """Fail unless `printed` is `shown`."""
    lines, found = (text.strip("\n").splitlines() for text in (shown, printed))
    assert matches(lines, found), f"shown:\n{shown}\nprinted:\n{printed}"


LONG = ("timer-design.md",)


@pytest.mark.parametrize("page", [
    pytest.param(page, marks=[pytest.mark.slow] * (page.name in LONG)) for page in having("python")
], ids=name_of)  # fmt: skip
def test_python_runs_and_prints_what_is_shown(page, workplace):
    names: dict[str, object] = {}
    for block in blocks(page, "python"):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(block.text, name_of(page), "exec"), names)
        for value in names.values():
            if type(value).__module__.startswith("escapement"):
                assert len(repr(value)) <= 600, type(value)
                assert "\n" not in repr(value), type(value)
        if block.below is None:
            assert printed.getvalue() == ""
        else:
            compare(block.below, printed.getvalue())


@pytest.mark.parametrize("page", having("console"), ids=name_of)
def test_sessions_print_what_is_shown(page, workplace, capsys, monkeypatch):
    # all is compiled before the tests begin
    monkeypatch.setattr("escapement.cli.compile.compile_all", lambda processes: 0)
    for block in blocks(page, "console"):
        assert block.text.startswith("$ ")
        for session in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
            command, _, shown = session.partition("\n")
            name, *arguments = shlex.split(command)
            assert Path(name).name == "escapement"
            main(arguments)
            out, err = capsys.readouterr()
            notes = [line for line in shown.splitlines() if line.startswith("escapement: ")]
            for note in notes:
                assert note in err.splitlines()
            compare("\n".join(line for line in shown.splitlines() if line not in notes), out)


def commands_of(page: Path) -> Iterator[str]:
    """Every whole command line of a page, those in a chain of shell commands included."""
    for block in blocks(page, "sh", "console"):
        prompt = "$ " if block.language == "console" else ""
        for line in block.text.splitlines():
            if line.startswith(prompt):
                yield from line.removeprefix(prompt).split("&&")


@pytest.mark.parametrize("page", having("sh") + having("console"), ids=name_of)
def test_command_lines_are_understood(page):
    for command in commands_of(page):
        words = shlex.split(command)
        if Path(words[0]).name != "escapement" or words[1].startswith("-"):
            continue
        assert parser_of(words[1])[1].understand(words[2:]) is not None
        for word in words:
            assert not word.endswith(".toml") or (ROOT / word).is_file()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_in_running_text_exist(page):
    text = _FENCE.sub("", page.read_text(encoding="utf-8"))
    for span in _INLINE.findall(text):
        words = span.split()
        if words[0] != "escapement" or len(words) == 1 or words[1] == "COMMAND":
            continue
        assert words[1] in COMMANDS, span
        options = parser_of(words[1])[1]._option_string_actions
        assert all(word in options for word in words[2:] if word.startswith("-")), span


@pytest.mark.parametrize("page", having("toml"), ids=name_of)
def test_studies_are_valid(page):
    for block in blocks(page, "toml"):
        content = tomllib.loads(block.text)
        content.pop("limits", None)  # a table of the command budget
        if {"period", "total_time"} & content.keys():
            assert requirement_of(content)[0].objectives  # what the command design reads
            continue
        assert parse_plan(content).cases > 1


def test_the_readme_installs_and_tests_in_one_line_each():
    install, test = [block.text.strip() for block in blocks(PAGES[0], "sh")]
    for line in (install, test):
        assert "\n" not in line
        assert line.startswith("python3.11 -m venv .venv && .venv/bin/pip install ")
    assert test.endswith("&& .venv/bin/pytest")


# --- numbers and signatures in running text -----------------------------------------------


def test_sensitivities_are_those_of_the_model():
    table = re.findall(r"^\| ([a-z ]+) \| ([-+].*) \|$", page_text("accuracy.md"), re.MULTILINE)
    inertia = {"driver": 3e-6 * INCH_POUND, "follower": 50e-6 * INCH_POUND}
    plain = esc.Escapement(esc.Geneva(4), esc.Inertia(**inertia), 0.10 * INCH_POUND, 0.35)
    more = {
        "torque": replace(plain, torque=1.01 * plain.torque),
        "friction": replace(plain, friction=1.01 * plain.friction),
    }
    for name, value in inertia.items():
        changed = esc.Inertia(**inertia | {name: 1.01 * value})
        more[f"{name} inertia"] = replace(plain, inertia=changed)
    assert [name for name, _ in table] == list(more)
    before = esc.terminal(plain)
    for name, shown in table:
        after = esc.terminal(more[name])
        for figure, cell in zip(FIGURES, shown.split(" | "), strict=True):
            change = getattr(after, figure) / getattr(before, figure) - 1.0
            assert f"{100.0 * change:+.2f}" == cell, (name, figure)


@pytest.mark.parametrize(
    ("script", "page"), [("effects", "effects.md"), ("imperfect", "tolerances.md")]
)
def test_a_table_is_what_its_script_prints(script, page, monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    found = import_module(f"pages.{script}").table().splitlines()
    shown = page_text(page).splitlines()
    assert [line for line in found if "---" not in line and line not in shown] == []


def test_how_often_the_published_test_rejects_is_what_its_row_says():
    text = page_text("measuring.md")
    (row,) = re.findall(r"^\| as published \| \$k-3\$ \| (.*) \|$", text, re.MULTILINE)
    rates = [float(cell) / 5.0 for cell in row.split(" | ")]
    assert (
        f"it rejects {min(rates):.1f} to {max(rates):.1f} times as often as it should"
        in " ".join(text.split())
    )


@pytest.mark.parametrize("name", ["Geneva", "GearDriven"])
def test_signatures_are_those_of_the_package(name):
    (shown,) = re.findall(rf"`{name}(\(.*\))`", page_text("mechanisms.md"))
    parameters = inspect.signature(getattr(esc, name)).parameters.values()
    bare = [parameter.replace(annotation=parameter.empty) for parameter in parameters]
    assert shown == str(inspect.Signature(bare)).replace("'", '"')


def test_every_error_is_on_the_page_with_what_it_also_is():
    rows = r"^\| `(\w+)` \|(?: `(\w+)`)? \|"
    table = dict(re.findall(rows, page_text("python.md"), re.MULTILINE))
    for error in (it for it in vars(errors).values() if inspect.isclass(it)):
        if error is errors.EscapementError:
            continue
        also = [base.__name__ for base in error.__bases__ if base is not errors.EscapementError]
        assert table[error.__name__] == "".join(also)


def keys(record: object) -> set[str]:
    """Keys of an object and of those in its lists."""
    if isinstance(record, dict):
        return set(record).union(*map(keys, record.values()))
    return set().union(*map(keys, record)) if isinstance(record, list) else set()


@pytest.mark.parametrize(
    "line",
    [
        f"run {INERTIAS} --torque .1 --crank-radius .01",
        f"mechanism {INERTIAS} --crank-radius .01",
        "mechanism gear-driven --stations 12 --lobes 3 --curve hypocycloid --fixed-radius .01",
        "mechanism elliptical-planetary --sun-radius 1 --planet-radius .5001234",
        "mechanism tabulated --table table.csv",
        "index --speed 1 --load-torque 0 --follower-inertia 1e-5",
        "measure runs/encoder_synthetic.csv elliptical-planetary --sun-radius .016 "
        "--planet-radius .009 --resolution 4096",
    ],
    ids=lambda line: " ".join(line.split()[:2]),
)
def test_every_key_of_json_is_printed_or_explained(line, workplace, capsys):
    rows = "".join(f"{10 * i},{10 * i}\n" for i in range(13))
    (workplace / "table.csv").write_text(rows)
    assert main([*line.split(), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    record["inputs"] = []  # its keys are the names of options
    found = keys(record) - {"inputs"}
    help_ = re.findall(r"^  (\w+) +\w", parser_of(line.split()[0])[1].epilog or "", re.MULTILINE)
    assert main(line.split()) == 0
    names = re.findall(r"^(\w+(?: \w+)*)  ", capsys.readouterr().out, re.MULTILINE)
    printed = {name.replace(" ", "_") for name in names}
    printed |= {f"{name}_deg" for name in printed}
    assert found - printed - {*help_, *_INLINE.findall(page_text("command-line.md"))} == set()


def page_text(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


# --- links and images ---------------------------------------------------------------------


def links(text: str) -> Iterator[str]:
    plain = _INLINE.sub("", _FENCE.sub("", text))
    for match in _LINK.finditer(plain):
        target = match[1] or match[2]
        if not target.startswith(("http://", "https://", "mailto:")):
            yield unquote(target)


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as repository hosts make them."""
    text = _FENCE.sub("", page.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", [*PAGES, *ROOT.glob("notebooks/*.ipynb")], ids=name_of)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        text = "".join(
            x for cell in cells if cell["cell_type"] == "markdown" for x in cell["source"]
        )
    for target in links(text):
        path, _, anchor = target.partition("#")
        linked = page.parent / path if path else page
        assert linked.exists(), target
        assert not anchor or anchor in anchors(linked), target


def moved() -> dict[str, str]:
    """The pages of conf.py that have moved; read without Sphinx."""
    tree = ast.parse((DOCS / "conf.py").read_text("utf-8"))
    (found,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "MOVED"
    )
    return ast.literal_eval(found)


def test_pages_have_moved_to_places_that_are_there():
    for old, new in moved().items():
        name, _, anchor = new.partition("#")
        assert not (DOCS / f"{old}.md").exists()
        place = DOCS / f"{name}.md"
        assert place.exists(), new
        assert not anchor or anchor in anchors(place), new


@pytest.mark.parametrize(
    ("name", "heading", "least"),
    [
        ("meyer.md", "## What the thesis says and asks, and what is true", 16),
        ("indexing-drive.md", "## Filemon's paper", 12),
        ("gear-driven.md", "## What the paper says, and where it is answered", 12),
        ("elliptical-planetary.md", "## What the paper says, and where it is answered", 10),
    ],
)
def test_every_statement_of_a_source_has_an_answer(name, heading, least):
    table = re.split(r"^##+ ", page_text(name).partition(f"{heading}\n")[2], flags=re.MULTILINE)[0]
    rows = [line.strip("|").split(" | ") for line in table.splitlines() if line.startswith("| ")]
    assert len(rows) == least + 1  # a header
    assert all(len(row) == 3 and all(cell.strip() for cell in row) for row in rows)


def test_every_page_is_on_the_map():
    listed = {target.partition("#")[0] for target in links((DOCS / "index.md").read_text("utf-8"))}
    assert {page.name for page in DOCS.glob("*.md")} - {"index.md"} <= listed


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_blocks_have_a_language_and_are_closed(page):
    assert {block.language for block in blocks(page)} <= LANGUAGES
    assert page.read_text(encoding="utf-8").count("```") == 2 * len(list(blocks(page)))


@pytest.mark.slow
def test_figures_can_be_drawn_again_and_are_all_shown(tmp_path, monkeypatch):
    main = runpy.run_path(str(DOCS / "make_figures.py"))["main"]
    monkeypatch.setitem(main.__globals__, "DPI", 40)
    # few pictures, cases and designs are enough to see that every figure is drawn
    for owner, name, few in (
        (esc.plots, "animate", {"frames": 3}),
        (esc, "budget", {"size": 1000}),
        (esc, "design", {"count": 3}),
    ):
        whole = getattr(owner, name)
        monkeypatch.setattr(
            owner, name, lambda *args, _do=whole, _few=few, **kw: _do(*args, **(kw | _few))
        )
    main(tmp_path)
    sizes = {image.name: image.stat().st_size for image in (DOCS / "images").iterdir()}
    shown = {Path(target).name for page in PAGES for target in links(page.read_text("utf-8"))}
    assert sizes.keys() <= shown
    films = {name for name in sizes if name.endswith(".gif")}
    assert max(sizes[name] for name in films) < LARGEST_FILM
    assert {image.name for image in tmp_path.iterdir()} == sizes.keys()
    assert max(size for name, size in sizes.items() if name not in films) < LARGEST_IMAGE
