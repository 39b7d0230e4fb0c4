"""Every number that a command accepts acts on a result or is refused, whatever the mechanism."""

import json
import math
from pathlib import Path

import pytest

from command_scenes import (
    BY_DEFAULT,
    COMMAND_KINDS,
    argv_of,
    changed,
    options_of,
    scenes_of,
    write_inputs,
)
from escapement.base.quantity import declared
from escapement.engines.solver import Solver

pytestmark = pytest.mark.slow

WRITTEN = {"export": "out.svg", "explore": "out.html"}
"""Files that hold the results of commands."""
ECHOES = ("inputs", "message", "bytes")
WARNS = {"least_wall"}
"""Options that decide of a warning alone."""
SOLVER = {*declared(Solver)}


def alike(a, b):
    """Whether two results are equal, except for rounding."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(alike(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(alike, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) or (a != a and b != b)
    return a == b


@pytest.fixture
def outcome(command):
    """Runs a scene: its exit code, its results without what only repeats inputs, and stderr."""

    def run(name, kind, scene):
        argv = argv_of(name, kind, scene)
        if name in WRITTEN:
            argv += ["--output", WRITTEN[name], "--force"]
        try:
            code, out, err = command(*argv, "--json")
        except Exception as error:
            return None, {}, f"{type(error).__name__}: {error}"
        if code not in (0, 3):
            return code, {}, err
        record = json.loads(out)
        assert next(iter(record)) == "inputs"
        for part in (record, record.get("motion") or {}):
            for key in ECHOES:
                part.pop(key, None)
        drawn = [
            path for path in (WRITTEN.get(name), scene.get("plot"), scene.get("output")) if path
        ]
        return code, record | {path: Path(path).read_text() for path in drawn}, err

    return run


def verdict(action, scene, base, found):
    """What a changed option did: "acts", "refused", or what is wrong with it."""
    code, record, err = found
    if code in (0, 3):
        exact = record == base[1] if action.dest in SOLVER else alike(record, base[1])
        same = exact and (action.dest not in WARNS or err == base[2])
        return "silent" if same else "acts"
    # a train is named by its place; or the option does not suit another one that is named
    names = {
        action.dest,
        *action.option_strings,
        action.dest.rpartition("_")[0] or "-",
        *scene,
        "required",
    }
    told = code in (2, 65) and err.count("\n") == 1 and any(name in err for name in names)
    return "refused" if told else f"exit {code}: {err}"


@pytest.mark.parametrize(("name", "kind"), COMMAND_KINDS, ids=map("-".join, COMMAND_KINDS))
def test_every_number_acts_or_is_refused(outcome, request, name, kind):
    """And every one that a scene has acts in some scene."""
    if name == "export":
        request.getfixturevalue("few_angles")
    write_inputs(name, kind)
    options, scenes, wrong = options_of(name), scenes_of(name, kind), []
    acting = set()
    for k, scene in enumerate(scenes):
        base = outcome(name, kind, scene)
        assert base[0] in (0, 3), base[2]
        assert alike(outcome(name, kind, scene)[1], base[1])
        for option in scene.get("tried", options.keys() - {*BY_DEFAULT}):
            if (action := options.get(option)) is None:
                continue
            told = verdict(action, scene, base, outcome(name, kind, changed(action, scene)))
            if told == "acts":
                acting.add(option)
            elif told != "refused":
                wrong.append(f"scene {k}, {option}: {told}")
    given = {x for scene in scenes for x in scene.get("tried", scene) if x in scene}
    wrong += [f"{option} never acts" for option in given & options.keys() - acting]
    assert "\n".join(wrong) == ""
