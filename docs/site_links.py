"""Links of the built site: those to pages that have moved are answered, and all are followed.

conf.py calls both after a build. Addresses of other sites are not tried.
"""

from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_MOVED = """<!DOCTYPE html>
<meta charset="utf-8">
<title>Moved</title>
<meta http-equiv="refresh" content="0; url={0}">
<p>This page has moved to <a href="{0}">{0}</a>.</p>
"""


def answer_moved(site: Path, moved: Mapping[str, str]) -> None:
    """Write a page at each old address that leads to the new one.

    Parameters
    ----------
    site : path
        The folder that Sphinx filled.
    moved : mapping of str
        The new place, "page" or "page#heading", by the old page.
    """
    for old, new in moved.items():
        page, sharp, place = new.partition("#")
        text = _MOVED.format(f"{page}.html{sharp}{place}")
        (site / f"{old}.html").write_text(text, encoding="utf-8")


class _Page(HTMLParser):
    """What a page links to or shows, and the places in it that a link can lead to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.targets: list[str] = []
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src"):
                self.targets.append(value or "")
            elif name == "id" or (tag, name) == ("a", "name"):
                self.places.add(value or "")


def broken(site: Path) -> Iterator[str]:
    """A line for each link or picture of a site's pages that leads to no file, or to no place.

    Parameters
    ----------
    site : path
        The folder that Sphinx filled.
    """
    # a theme may keep templates among its static files
    files = [path for path in sorted(site.resolve().rglob("*.html")) if "_static" not in path.parts]
    pages = {path: _Page(path.read_text("utf-8")) for path in files}
    for path, page in pages.items():
        for target in dict.fromkeys(page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            place = unquote(parts.fragment)
            if not file.is_file():
                yield f"{path.name}: {target} leads to no file"
            elif place and file in pages and place not in pages[file].places:
                yield f"{path.name}: {target} leads to no place on that page"
