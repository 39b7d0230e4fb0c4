"""Which study partial results are of: what is compared, and how a difference is told."""

import hashlib
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from escapement.errors import CannotCreate
from escapement.study.result import Study

_FIXED_AT_START = ("created", "package_version")
"""Attributes that a resumed study takes over, so that its file is that of one run."""
_ROOT = Path(__file__).parents[1]
_ROOMS = ("mechanisms", "engines", "study")


def journal_head(frame: Study, numerics: str) -> dict[str, Any]:
    """What the partial results of a study say of themselves.

    Parameters
    ----------
    frame : Study
        Everything but the results.
    numerics : str
        Differs whenever a version of this package may compute other results.
    """
    attributes = dict(frame.attributes)
    fixed = {name: attributes.pop(name) for name in _FIXED_AT_START if name in attributes}
    study = {"attributes": attributes, "configuration": frame.configuration, "numerics": numerics}
    head: dict[str, Any] = json.loads(json.dumps({"study": study, "fixed": fixed}))
    return head


def check_same(path: Any, there: Mapping[str, Any], here: Mapping[str, Any]) -> None:
    """Raise CannotCreate, naming the first difference, unless both heads are of one study."""
    old, new = there["study"], here["study"]
    if json.dumps(old) == json.dumps(new):
        return
    if old["numerics"] != new["numerics"] and old | {"numerics": new["numerics"]} == new:
        versions = [f"{head['fixed'].get('package_version')} ({head['study']['numerics']})"
                    for head in (there, here)]  # fmt: skip
        raise CannotCreate(
            f"output {path} must be resumed by the version that began it, {versions[0]}, got "
            f"{versions[1]}, whose results may differ; install that one, or start over with "
            "force=True"
        )
    raise CannotCreate(
        f"output {path} must be resumed with the configuration it was begun with, got another: "
        f"{difference(old, new)}; use that one, name another output, or start over with "
        "force=True (--force)"
    )


def difference(there: Mapping[str, Any], here: Mapping[str, Any]) -> str:
    """Where configuration or attributes of two studies differ first, with both values."""
    parts = ("configuration", "attributes")
    texts = (_first_difference(there[part], here[part], "") for part in parts)
    return next(filter(None, texts), "the order of the axes")


def _first_difference(there: Any, here: Any, place: str) -> str:
    if not (isinstance(there, dict) and isinstance(here, dict)):
        return "" if there == here else f"{place} was {_short(there)} and is {_short(here)}"
    for key in [*there, *(key for key in here if key not in there)]:
        where = f"{place}.{key}" if place else str(key)
        if key not in here or key not in there:
            was, now = (_short(side[key]) if key in side else "not set" for side in (there, here))
            return f"{where} was {was} and is {now}"
        if text := _first_difference(there[key], here[key], where):
            return text
    if list(there) != list(here):
        return f"{place or 'the keys'} had the order {', '.join(there)}"
    return ""


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:40] + " ... " + text[-15:]


def sources() -> list[Path]:
    """The files that results may depend on, in order."""
    rooms = (_ROOT.glob("*.py"), *((_ROOT / room).rglob("*.py") for room in _ROOMS))
    return sorted(path for room in rooms for path in room)


@cache
def numerics() -> str:
    """Digest of these sources; equal digests, equal results.

    A change of a comment changes the digest too: it is better to begin a study again than
    to mix two kinds of numbers in it.
    """
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
