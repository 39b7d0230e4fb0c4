"""How Sphinx makes a site of these pages: `sphinx-build -W docs site`.

The pages are plain Markdown, so that they read as well in the repository. What a site has
beyond that is added here while they are read: its contents from the tables of index.md, the
signature and docstring of each name in the API reference, and links to and from these names.
"""

import html
import inspect
import re
import sys
from pathlib import Path
from pkgutil import resolve_name

import ziamath
from docutils import nodes
from sphinx.util.logging import getLogger
from sphinx.writers.html5 import HTML5Translator

import escapement as esc
from escapement.explorer import page

sys.path.insert(0, str(Path(__file__).parent))
from site_links import answer_moved, broken

project = "escapement"
author = "The escapement developers"
version = release = esc.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc"]
myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 3
numpydoc_show_class_members = False
autodoc_typehints = "none"
default_role = "py:obj"
toc_object_entries = False
exclude_patterns = ["templates", "static"]
templates_path = ["templates"]
html_static_path = ["static"]
html_css_files = ["site.css"]
html_theme = "pydata_sphinx_theme"
html_title = f"escapement {release}"
html_sidebars = {"**": ["all-pages"]}
html_theme_options = {
    "navbar_center": [],
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": {"**": ["page-toc"], "index": []},
}
html_show_sourcelink = False
html_math_renderer = "drawn"

DOCS = Path(__file__).parent
EXPLORER = "explorer-page.html"
# where the content of a page that is no more now stands, so that old links are answered
MOVED: dict[str, str] = {
    "compliant": "clearance#walls-that-yield",
    "configuration": "studies",
    "drive-torque": "indexing-drive#the-equation",
    "explorer": "first-timer#the-explorer",
    "files": "studies#the-file-of-a-study",
    "friction": "effects#which-friction-to-assume",
    "imperfect-parts": "tolerances#errors-of-the-parts",
    "inverse-design": "timer-design",
    "large-studies": "studies#large-studies",
    "measurement": "measuring#what-is-compared",
    "measuring-protocol": "measuring",
    "other-tools": "literature#other-programs",
    "rundown": "timer-design#a-spring-that-runs-down",
}
# what a page links to outside this folder and a site cannot offer as a file
_OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./(?:runs|benchmarks/README\.md)\)")
_FENCED = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
_HEADING = re.compile(r"^### (`.+`)$", re.MULTILINE)
_ENTRY = re.compile(r"^\w+(?:, \w+)* : ")
_CODE = re.compile(r"(?<![\[`])`(?:esc\.|escapement\.)?([\w.]+)(\([^`]*\))?`(?![`\]])")


def contents(text: str) -> str:
    """Hidden tables of contents, one for each section of the index with a table of pages."""
    found = []
    for section in text.split("\n## ")[1:]:
        if pages := re.findall(r"^\| \[.*?\]\((.+?)\.md\)", section, re.MULTILINE):
            caption = section.partition("\n")[0]
            found.append(
                "\n".join(["```{toctree}", ":hidden:", f":caption: {caption}", *pages, "```"])
            )
    return "\n\n".join(found)


def mentions() -> dict[str, list[str]]:
    """Links to the pages that name an object, by the object."""
    found: dict[str, list[str]] = {}
    for path in sorted(DOCS.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if path.stem.startswith("api-"):
            continue
        title = text.partition("\n")[0].removeprefix("# ")
        for name in set(re.findall(r"\b(?:esc\.|plots\.|synthesis\.)?(\w+)(?=\(|`)", text)):
            found.setdefault(name, []).append(f"[{title}]({path.name})")
    return found


PAGES = "".join(path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("*.md")))
MENTIONS = mentions()
API = {
    name
    for path in DOCS.glob("api-*.md")
    for heading in _HEADING.findall(path.read_text(encoding="utf-8"))
    for name in re.findall(r"`(.+?)`", heading)
}


def documented(heading: re.Match[str]) -> str:
    """A heading of the API reference, followed by what the docstrings of its names say."""
    lines, links = [], []
    for name in re.findall(r"`(.+?)`", heading[1]):
        value = resolve_name(f"escapement.{name}")
        kind = "class" if inspect.isclass(value) else "function" if callable(value) else "data"
        lines += [f".. auto{kind}:: escapement.{name}", *["   :members:"] * (kind == "class"), ""]
        links += MENTIONS.get(name.rpartition(".")[2], [])
    told = f"Pages that use it: {', '.join(sorted(set(links)))}.\n\n" if links else ""
    return "\n".join([heading[0], "", "```{eval-rst}", *lines, "```", "", f"{told}Example:"])


def linked(text: str) -> str:
    """Text whose code spans that name an object of the API reference lead there."""

    def link(span: re.Match[str]) -> str:
        name = f"plots.{span[1]}" if span[1].startswith("plot_") else span[1]
        sure = span[1] != name or "esc." in span[0] or span[2] or "." in name
        shown = span[0].strip("`")
        return f"{{py:obj}}`{shown} <escapement.{name}>`" if sure and name in API else span[0]

    parts = _FENCED.split(text)
    return "".join(
        part
        if part.startswith("```")
        else "\n".join(
            line if line.startswith("#") else _CODE.sub(link, line) for line in part.split("\n")
        )
        for part in parts
    )


def read(app, name: str, source: list[str]) -> None:
    """Change a page's text before it is parsed."""
    text = _OUTSIDE.sub(r"\1", linked(source[0]))
    if name == "index":
        frame = f'<iframe class="explorer" src="{EXPLORER}" title="The explorer"></iframe>'
        text = re.sub(r"^!\[.*$", frame, text, count=1, flags=re.MULTILINE)
        text = f"{text}\n{contents(text)}\n"
    if name.startswith("api-"):
        text = _HEADING.sub(documented, text)
    source[0] = text


def docstring(app, what, name: str, value, options, lines: list[str]) -> None:
    """Make numpydoc sections of what docstrings tell without a heading; bars are no markup."""
    entries = [i for i, line in enumerate(lines) if _ENTRY.match(line)]
    if what == "class" and entries and not any(set(line) == {"-"} for line in lines):
        for i in reversed(entries):
            lines[i : i + 1] = lines[i].split(" : ", 1)[0], f"    {lines[i].split(' : ', 1)[1]}"
        lines[entries[0] : entries[0]] = ["Attributes", "----------"]
    ruled = [i for i, line in enumerate(lines) if line and set(line) == {"-"}]
    if ruled and "Notes" not in lines:
        for i in range(ruled[0] + 1, len(lines) - 1):
            before, line, after = lines[i - 1 : i + 2]
            # what follows a section and is no entry of it
            if not before and line[:1].strip() and not after.startswith((" ", "--")):
                lines[i:i] = ["Notes", "-----"]
                break
    lines[:] = [line.replace("|", r"\|") for line in lines]


def signature(app, what, name: str, value, options, given, returned):
    """That of a class as its constructor checks it, not that of the call which checks it."""
    if what != "class" or issubclass(value, Exception):
        return None
    shown = inspect.signature(value)
    bare = [it.replace(annotation=it.empty) for it in shown.parameters.values()]
    return str(inspect.Signature(bare)), None


def skipped(app, what, name: str, value, skip: bool, options) -> bool | None:
    """Of the members of a class those are shown that a page names; engines use the others."""
    return True if not re.search(rf"[.`]{name}\b", PAGES) else None


def finish(app, error: Exception | None) -> None:
    """Write the explorer, which the first page shows, and old addresses; follow all links."""
    if error is None and app.builder.format == "html":
        timer = esc.Escapement(
            esc.Geneva(4, crank_radius=0.02),
            esc.Inertia(driver=3.39e-7, follower=5.65e-6),
            torque=0.0113,
            friction=0.35,
        )
        (Path(app.outdir) / EXPLORER).write_text(page(timer), encoding="utf-8")
        answer_moved(Path(app.outdir), MOVED)
        for line in broken(Path(app.outdir)):
            getLogger(__name__).warning(line)  # which fails a build with --fail-on-warning


def formula(writer: HTML5Translator, node: nodes.Element) -> None:
    """A formula as a drawing, which needs no script from elsewhere and no font of the reader."""
    text = node.astext()
    block = isinstance(node, nodes.math_block)
    known = re.sub(r"\\arg ", r"\\operatorname{arg} ", text)
    known = re.sub(r"(\\operatorname\{\w+\}) ", r"\1\\,", known)
    drawn = ziamath.Latex(known, size=19 if block else 17, inline=not block, color="currentColor")
    words = f'role="img" aria-label="{html.escape(text)}"'
    place = f'style="vertical-align: {drawn.getyofst():.1f}px"'
    picture = drawn.svg().replace("<svg ", f"<svg {words} {place} ", 1)
    writer.body.append(f'<div class="formula">{picture}</div>' if block else picture)
    raise nodes.SkipNode


def setup(app) -> None:
    """Called by Sphinx."""
    app.add_html_math_renderer("drawn", (formula, None), (formula, None))
    app.connect("source-read", read)
    app.connect("autodoc-process-docstring", docstring, priority=100)  # before numpydoc
    app.connect("autodoc-process-signature", signature)
    app.connect("autodoc-skip-member", skipped)
    app.connect("build-finished", finish)
