"""The explorer: one page that shows an escapement move, and computes its motion while one drags.

The page is a single file without requests. Its kernel, `kernel.js` with the modules that it
imports, is the angle-domain method of `engines.energy` for Geneva wheels. It refuses what it cannot
compute, and so does `design_of`.
"""

import json
import re
from importlib.resources import files
from typing import Any

from escapement import validate
from escapement.mechanisms import Geneva
from escapement.model import Escapement, Inertia, Run
from escapement.quantity import Setting, declared
from escapement.units import SYSTEMS, factor, printed

MODULES = (
    *("polynomial", "law", "panels", "march", "figures", "rules", "kernel"),
    *("dom", "bodies", "design", "picture", "plots", "charts", "report", "page"),
)
"""Files of the page's script, in the order in which they follow each other."""
MOST_SLOTS, MOST_ENGAGEMENTS = 40, 1000
"""What the page computes while one drags."""
COMPUTED = (
    *("slots", "pins", "internal", "crank_radius", "pin_radius", "driver_inertia"),
    *("follower_inertia", "torque", "friction", "load_torque", "driver_bearing_friction"),
    *("driver_bearing_radius", "follower_bearing_friction", "follower_bearing_radius"),
    *("driver_bearing_torque", "driver_drag", "follower_drag", "spring_rate"),
    *("initial_speed", "engagements"),
)
"""Numbers of a design that the page computes with, by the names of studies."""
_KINDS = ("ratio", "time", "speed", "force", "torque")
_MODULE = re.compile(r"^import .*?;\n|^export (?=\w)", re.MULTILINE | re.DOTALL)


def design_of(
    escapement: Escapement, initial_speed: float = 0.0, engagements: int = 20
) -> dict[str, Any]:
    """The design that the page begins with: numbers in SI by the names of `COMPUTED`.

    Raises
    ------
    InvalidValue
        When the escapement has what the page does not compute.
    """
    wheel, remedy = escapement.mechanism, "simulate it with the package"
    if not isinstance(wheel, Geneva):
        kind = getattr(wheel, "kind", type(wheel).__name__)
        raise validate.fail("mechanism", "a Geneva wheel for the explorer", kind, remedy)
    if escapement.without_trains is not escapement:
        raise validate.fail("barrel and load_train", "left out for the explorer", "a train", remedy)
    design: dict[str, Any] = {"initial_speed": initial_speed, "engagements": engagements}
    for owner in (wheel, escapement.inertia, escapement):
        for name, entry in declared(type(owner)).items():
            value = getattr(owner, entry.key)
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
    """The explorer as the text of an HTML file that needs no other.

    Parameters
    ----------
    escapement : Escapement
        The design it begins with, of a Geneva wheel.
    initial_speed : float
        Driver speed at the first pin entry [rad/s].
    engagements : int
        Engagements to show, at most a thousand.

    Raises
    ------
    InvalidValue
        When the escapement has what the page does not compute.
    """
    shown = {name: _told(entry) for name, entry in _settings().items() if name in COMPUTED}
    kinds = {*_KINDS, *(told["unit"] for told in shown.values())}
    data = {
        "design": design_of(escapement, initial_speed, engagements),
        "fields": shown,
        "systems": {
            system: {
                kind: {"name": printed(kind, system), "factor": factor(kind, system)}
                for kind in sorted(kinds)
            }
            for system in SYSTEMS
        },
        "stops": stops(),
    }
    parts = {
        "STYLE": _read("page.css"),
        # nothing in the data may end the element that holds it
        "DATA": json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"),
        "SCRIPT": "\n".join(_MODULE.sub("", _read(f"{name}.js")) for name in MODULES),
    }
    return re.sub(r"/\*(STYLE|DATA|SCRIPT)\*/", lambda mark: parts[mark[1]], _read("page.html"))


def stops() -> list[dict[str, Any]]:
    """The guided stops of the page; each claim names the test that proves it."""
    found: list[dict[str, Any]] = json.loads(_read("stops.json"))
    return found


def _settings() -> dict[str, Setting]:
    return declared(Geneva) | declared(Inertia) | declared(Escapement) | declared(Run)


def _told(entry: Setting) -> dict[str, str]:
    """What the page says of a number: its words, and its kind of unit."""
    return {"label": entry.long_name[0].upper() + entry.long_name[1:], "unit": entry.unit}


def _read(name: str) -> str:
    return files(__name__).joinpath(name).read_text(encoding="utf-8")
