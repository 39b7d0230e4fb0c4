"""Whatever a command refuses leaves nothing on disk, and no mistake ends in a traceback."""

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
from escapement.cli import _output
from escapement.cli._arguments import parser_of

OUTPUTS = {"output": "made", "plot": "made.png", "report": "made.html"}
SUFFIXES = {
    **{"run": ".h5", "rundown": ".csv", "sweep": ".h5", "budget": ".h5", "design": ".csv"},
    **{"explore": ".html", "plot": ".png", "export": ".svg", "measure": ".csv"},
}


def wrong_scenes(name, scene):
    """The scene with a number out of its range, with one left out, and with one that is idle."""
    for option, action in options_of(name).items():
        if option in scene.get("tried", options_of(name).keys() - {*BY_DEFAULT}):
            yield {**scene, option: -1}
            if option in scene:
                yield {key: value for key, value in scene.items() if key != option}
            else:
                yield changed(action, scene)


@pytest.mark.parametrize(("name", "kind"), COMMAND_KINDS, ids=map("-".join, COMMAND_KINDS))
def test_a_refusal_leaves_nothing_on_disk(command, monkeypatch, tmp_path, name, kind):
    # drawing takes long, and where a picture is made matters here, not what it shows
    for function in ("drawn", "drawn_motion") if name != "plot" else ():
        monkeypatch.setattr(_output, function, lambda path, *_: lambda: path and path.touch())
    monkeypatch.setattr(
        _output, "reported", lambda args, *_, **__: lambda: args.report and args.report.touch()
    )
    write_inputs(name, kind)
    known = {action.dest for action in parser_of(name)[1]._actions}
    asked = {key: path for key, path in OUTPUTS.items() if key in known}
    if "output" in asked:
        asked["output"] += SUFFIXES.get(name, "")
    before, refused, wrong = {*tmp_path.iterdir()}, 0, []
    for scene in scenes_of(name, kind)[:1]:
        for one in wrong_scenes(name, {**scene, **asked}):
            argv = argv_of(name, kind, one)
            try:
                code, out, err = command(*argv)
            except Exception as error:
                code, out, err = None, "", f"{type(error).__name__}: {error}"
            made = {*tmp_path.iterdir()} - before
            refused += code == 2
            if code not in (0, 2, 3, 65, 66) or (
                code == 2 and (made or out or err.count("\n") != 1)
            ):
                wrong.append(f"{argv}: exit {code}, {[*map(str, made)]}, {err}")
            for path in made:
                path.unlink()
    assert "\n".join(wrong) == ""
    assert refused or not scenes_of(name, kind)
