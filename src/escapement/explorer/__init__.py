"""The explorer: a page that shows an escapement in motion, and computes it while numbers change.

The page is a single file that makes no requests. Its kernel, `kernel.js` with the modules that it
imports, is the angle-domain method of `engines.energy` for Geneva wheels. The kernel and
`design_of` refuse designs that it cannot compute.

- `bodies`, `played`: bodies and motions as the page draws and plays them
- `widget`: the page in a notebook
- `serve`, `served_page`, `answers`, `as_text`: the page with a server, which answers its questions
"""

import html
import json
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from itertools import chain
from typing import Any

from escapement.base import validate
from escapement.base.quantity import Choice, Quantity, Setting, Truth, declared
from escapement.base.spoken import spoken
from escapement.base.status import Status
from escapement.base.units import SYSTEMS, factor, printed
from escapement.dynamics.motion import Motion
from escapement.explorer.played import cycle_of, played
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement, Inertia, Run

MODULES = (
    *("polynomial", "law", "bodies", "panels", "march", "figures", "rules", "kernel", "dom"),
    *("design", "picture", "plots", "charts", "report", "played", "fields", "page"),
)
"""Files of the page's script, in their order."""
SERVED = ("served", "cloud", "study")
"""Further files of a served page; they stand before the last one."""
GROUPS = {
    "Mechanism": ("slots", "pins", "internal", "crank_radius", "pin_radius"),
    "Drive, inertia and load": (
        *("torque", "spring_rate", "driver_inertia", "follower_inertia", "load_torque"),
        *("initial_speed", "engagements"),
    ),
    "Friction": (
        *("friction", "driver_bearing_friction", "driver_bearing_radius"),
        *("follower_bearing_friction", "follower_bearing_radius", "driver_bearing_torque"),
    ),
    "Air": ("driver_drag", "follower_drag"),
}
"""Fields of the page, by the titles of their groups."""
MOST_SLOTS, MOST_ENGAGEMENTS = 40, 1000
"""Figures that the page computes while a number is dragged."""
COMPUTED = tuple(chain(*GROUPS.values()))
"""Numbers of a design that the page computes with, by the names of studies."""
_KINDS = ("ratio", "time", "speed", "force", "torque", "length")
_MODULE = re.compile(r"^import .*?;\n|^export (?=\w)", re.MULTILINE | re.DOTALL)


def design_of(
    escapement: Escapement, initial_speed: float = 0.0, engagements: int = 20
) -> dict[str, Any]:
    """The design that the page begins with: numbers in SI by the names of `COMPUTED`.

    Raises
    ------
    InvalidValue
        If the page cannot compute the escapement.
    """
    wheel, remedy = escapement.mechanism, "serve it: escapement explore --serve"
    if not isinstance(wheel, Geneva):
        raise validate.fail("mechanism", "a Geneva wheel for the explorer", wheel.kind, remedy)
    if escapement.without_trains is not escapement:
        raise validate.fail("barrel and load_train", "left out for the explorer", "a train", remedy)
    design: dict[str, Any] = {"initial_speed": initial_speed, "engagements": engagements}
    for owner in (wheel, escapement.inertia, escapement):
        settings = owner.settings
        for name, entry in declared(type(owner)).items():
            value = settings[name]
            if name in COMPUTED:
                if name == "torque":
                    value = validate.number(name, value, "the explorer takes no torque curve")
                design[name] = value
            elif value != entry.default:
                rule = f"{entry.default or 'left out'} for the explorer"
                raise validate.fail(name, rule, value, remedy)
    for name, most in (("slots", MOST_SLOTS), ("engagements", MOST_ENGAGEMENTS)):
        if design[name] > most:
            raise validate.fail(name, f"at most {most} for the explorer", design[name], remedy)
    return design


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
    data = explored(GROUPS, settings())
    design = design_of(escapement, initial_speed, engagements)
    return filled("explore", LEAD, data | {"design": design})


LEAD = (
    "Drag a number: the motion is computed anew, exactly, in this page. Nothing is sent anywhere."
)
_TITLES = {"explore": "Geneva escapement explorer", "play": "Motion of an escapement"}


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
    kind = motion.escapement.mechanism.kind
    count = motion.handoff_times.size
    lead = f"{count} engagements of a {kind} mechanism, as engine {motion.engine} computed them"
    text = "." if motion.status is Status.OK else f"; {motion.message}."
    return filled("play", html.escape(lead + text), {"motion": record, "systems": systems()})


def explored(groups: Mapping[str, Sequence[str]], entries: Mapping[str, Setting]) -> dict[str, Any]:
    """Data of a page whose design can be changed: its fields, their labels and units."""
    names = [name for group in groups.values() for name in group]
    fields = {name: _entry_of(entries[name]) for name in names}
    return {"fields": fields, "groups": groups, "systems": systems(), "stops": stops()}


def systems() -> dict[str, Any]:
    """Name and size of the unit of every kind, by system."""
    kinds = sorted({*_KINDS, *(entry.unit for entry in settings().values())})

    def of_kind(kind: str, system: str) -> dict[str, Any]:
        return {"name": printed(kind, system), "factor": factor(kind, system)}

    return {system: {kind: of_kind(kind, system) for kind in kinds} for system in SYSTEMS}


def filled(mode: str, lead: str, data: Mapping[str, Any], served: str = "") -> str:
    """The page with its data; `served` is HTML that only the page of a server has."""
    text = json.dumps({**data, "units": spoken()}, ensure_ascii=False, allow_nan=False)
    modules = [*MODULES[:-1], *(SERVED if served else ()), MODULES[-1]]
    parts = {
        "MODE": f"{mode} served" if served else mode,
        "TITLE": _TITLES[mode],
        "LEAD": lead,
        "CONNECT": "; connect-src 'self'" if served else "",
        "SERVED": served,
        "STYLE": read("page.css"),
        # no text in the data may end its script element
        "DATA": text.replace("<", "\\u003c"),
        "SCRIPT": "\n".join(_MODULE.sub("", read(f"{name}.js")) for name in modules),
    }
    return re.sub(rf"/\*({'|'.join(parts)})\*/", lambda mark: parts[mark[1]], read("page.html"))


def stops() -> list[dict[str, Any]]:
    """The guided stops of the page; each claim names the test that proves it."""
    found: list[dict[str, Any]] = json.loads(read("stops.json"))
    return found


def settings() -> dict[str, Setting]:
    """Declarations of all numbers of a Geneva wheel and its motion, by name."""
    return declared(Geneva) | declared(Inertia) | declared(Escapement) | declared(Run)


def _entry_of(entry: Setting) -> dict[str, Any]:
    """Properties of a number for its field: label, kind of unit, default and type."""
    length = entry.name in ("crank_radius", "fixed_radius", "sun_radius", "planet_radius")
    entry_shown = {
        "label": entry.long_name[0].upper() + entry.long_name[1:],
        "unit": entry.unit,
        "default": entry.default if isinstance(entry.default, int | float | str) else None,
        "whole": isinstance(entry, Quantity) and entry.whole,
        "optional": entry.default is None and not entry.required,
        "needs": entry.unit == "length" and not length,
        "truth": isinstance(entry, Truth),
        "choices": list(entry.allowed) if isinstance(entry, Choice) else None,
    }
    return {name: value for name, value in entry_shown.items() if value not in (None, False)}


def read(name: str) -> str:
    """A file of the page."""
    return files(__name__).joinpath(name).read_text(encoding="utf-8")
