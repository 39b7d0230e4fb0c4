"""Whether two runs are of the same study, and how they differ where they are not.

They are of the same study when configuration, attributes and the source code that decides
the numbers are equal.
"""

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

from escapement.errors import CannotCreate
from escapement.study.result import Study

_FIXED_AT_START = ("created", "package_version")
"""Attributes that a resumed study takes over, so that its file is that of one run."""
_SOURCES = (
    *("units.py", "quantity.py", "model.py", "scene.py", "dynamics.py", "painleve.py"),
    *("metrics.py", "motion.py", "trajectory.py", "chebyshev.py", "roots.py"),
    *("simulation.py", "solver.py", "status.py", "text.py"),
    *("mechanisms/*.py", "engines/*/*.py"),
    *(f"study/{name}.py" for name in ("sweep", "parse", "plan", "varied", "evaluate", "scenes")),
)
"""Patterns of the files that decide what the results of a case are."""
_ROOT = Path(__file__).parents[1]


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
    result: dict[str, Any] = json.loads(
        json.dumps({"study": study, "fixed": fixed}, allow_nan=False)
    )
    return result


def check_same(path: Any, there: dict[str, Any], here: dict[str, Any]) -> None:
    """Raise CannotCreate, naming the first difference, unless both are one study."""
    if json.dumps(there["study"]) == json.dumps(here["study"]):
        return
    old, new = there["study"], here["study"]
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
        f"{_difference(old, new)}; use that one, name another output, or start over with force=True"
    )


def check_complete(path: Any, there: dict[str, Any], frame: Study) -> None:
    """Raise CannotCreate, naming the first difference, unless a whole file is of this study.

    Parameters
    ----------
    path : path
        As the user named the file.
    there : dict
        Its configuration, and those of its attributes that make the study.
    frame : Study
        Everything but the results.
    """
    attributes = {name: frame.attributes[name] for name in there["attributes"]}
    here = {"configuration": frame.configuration, "attributes": attributes}
    here = json.loads(json.dumps(here, allow_nan=False))
    if json.dumps(there) != json.dumps(here):
        raise CannotCreate(
            f"output {path} must be of this study to be resumed, got the complete file of another: "
            f"{_difference(there, here)}; name another output, or give force=True to replace it"
        )


def _difference(there: dict[str, Any], here: dict[str, Any]) -> str:
    parts = ("configuration", "attributes")
    texts = (first_difference(there[part], here[part]) for part in parts)
    return next(filter(None, texts), "the order of the axes")


def first_difference(there: Any, here: Any, place: str = "") -> str:
    """Where two configurations differ first, with both values; empty where they do not."""
    if isinstance(there, dict) and isinstance(here, dict):
        for key in [*there, *(key for key in here if key not in there)]:
            where = f"{place}.{key}" if place else str(key)
            if key not in here or key not in there:
                values = (_short(side[key]) if key in side else "not set" for side in (there, here))
                return "{} was {} and is {}".format(where, *values)
            if text := first_difference(there[key], here[key], where):
                return text
        if list(there) != list(here):
            return f"{place or 'the keys'} had the order {', '.join(there)}"
        return ""
    return "" if there == here else f"{place} was {_short(there)} and is {_short(here)}"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:40] + " ... " + text[-15:]


def sources() -> list[Path]:
    """The files that results depend on, in order."""
    return sorted(path for pattern in _SOURCES for path in _ROOT.glob(pattern))


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
