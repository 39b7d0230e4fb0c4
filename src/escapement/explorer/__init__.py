"""The explorer: a page that shows an escapement in motion, and computes it while numbers change.

The page is a single file that makes no requests. Its kernel, `kernel.js` with the modules that it
imports, is the angle-domain method of `engines.energy` for Geneva wheels. The kernel and
`design_of` refuse designs that it cannot compute.

- `fields`: the numbers of a design, their rules, words and units, for Python and the page
- `bodies`, `played`: bodies and motions as the page draws and plays them
- `widget`: the page in a notebook
"""

import html
import json
import re
from collections.abc import Mapping
from contextlib import suppress
from importlib.resources import files
from typing import Any

from escapement.base import validate
from escapement.base.errors import InvalidValue
from escapement.base.spoken import spoken
from escapement.base.status import Status
from escapement.dynamics.motion import Motion
from escapement.explorer.fields import design_of, report_table, table
from escapement.explorer.played import cycle_of, played
from escapement.model.escapement import Escapement

MODULES = (
    *("dom", "polynomial", "law", "bodies", "panels", "march", "figures", "rules", "kernel"),
    *("design", "picture", "plots", "charts", "report", "played", "fields", "page"),
)
"""Files of the page's script, in their order."""
_LEAD = "Drag a number: this page computes the motion again, exactly, and sends nothing."
_TITLES = {"explore": "Geneva escapement explorer", "play": "Motion of an escapement"}
_MOST_STORED = 20  # engagements in a cell: each adds some 13 kB to the notebook
_MODULE = re.compile(r"^import .*?;\n|^export (?=\w)", re.MULTILINE | re.DOTALL)


def page(escapement: Escapement, initial_speed: float = 0.0, engagements: int = 20) -> str:
    """The explorer as the text of an HTML file that needs no other file.

    Parameters
    ----------
    escapement : Escapement
        The design that is shown first, with a Geneva wheel.
    initial_speed : float
        Driver speed at the first pin entry [rad/s].
    engagements : int
        Engagements to show, at most a thousand.

    Raises
    ------
    InvalidValue
        If the page cannot compute the escapement.
    """
    design = design_of(escapement, initial_speed, engagements)
    return _filled("explore", _LEAD, table() | {"stops": stops(), "design": design})


def player(motion: Motion) -> str:
    """A page that plays a motion, as the text of an HTML file that needs no other file.

    Parameters
    ----------
    motion : Motion
        A motion of any engine and mechanism. For a table only plots are shown, because it has no
        bodies.

    Raises
    ------
    InvalidValue
        If the motion has no duration, or is too long to be played.
    """
    if not motion.end_time > 0.0:
        got = f"none ({motion.message})"
        raise validate.fail("motion", "longer than zero to be played", got, "change its inputs")
    record = played(motion, cycle_of(motion))
    return _filled("play", _lead_of(motion), report_table() | {"motion": record})


def _lead_of(motion: Motion) -> str:
    """What a page plays, in a sentence."""
    kind, count = motion.escapement.mechanism.kind, motion.handoff_times.size
    lead = f"{count} engagements, {kind} mechanism, as engine {motion.engine} computed them"
    text = "." if motion.status is Status.OK else f"; {motion.message}."
    return html.escape(lead + text)


def film(motion: Motion) -> str:
    """The page of `player` for a cell of a notebook, which is made at once and stays small.

    Where the page can compute the motion by itself, it does so; of other motions it plays those
    of a few engagements.

    Raises
    ------
    InvalidValue
        If the motion has no duration, or too many engagements to be stored in a cell.
    """
    count = motion.handoff_times.size
    if motion.engine == "energy" and count and motion.handoff_times[-1] == motion.end_time:
        speed = float(motion.at(0.0).theta_dot)
        # other mechanisms and numbers are refused, and stored below
        with suppress(InvalidValue):
            design = design_of(motion.escapement, speed, count)
            return _filled("play", _lead_of(motion), table() | {"stops": [], "design": design})
    if count > _MOST_STORED:
        remedy = "esc.plots.explore plays it"
        raise validate.fail("engagements", f"at most {_MOST_STORED} in a cell", count, remedy)
    return player(motion)


def stops() -> list[dict[str, Any]]:
    """The guided stops of the page; each claim names the test that proves it."""
    found: list[dict[str, Any]] = json.loads(_read("stops.json"))
    return found


def _filled(mode: str, lead: str, data: Mapping[str, Any]) -> str:
    """The page with its data."""
    text = json.dumps({**data, "units": spoken()}, ensure_ascii=False, allow_nan=False)
    parts = {
        "MODE": mode,
        "TITLE": _TITLES[mode],
        "LEAD": lead,
        "STYLE": _read("page.css"),
        # no text in the data may end its script element
        "DATA": text.replace("<", "\\u003c"),
        "SCRIPT": "\n".join(_MODULE.sub("", _read(f"{name}.js")) for name in MODULES),
    }
    return re.sub(rf"/\*({'|'.join(parts)})\*/", lambda mark: parts[mark[1]], _read("page.html"))


def _read(name: str) -> str:
    """A file of the page."""
    return files(__name__).joinpath(name).read_text(encoding="utf-8")
