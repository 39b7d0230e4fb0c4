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

pytestmark = pytest.mark.slow


MODEL = ["--torque", "0.0113", "--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6"]
SIZES = ["--slots", "4", "--pins", "1", "--crank-radius", "0.02", "--pin-radius", "1e-3",
         "--clearance", "1e-5"]  # fmt: skip
DATA = "theta,phi\n" + "".join(f"{x},{0.5 * x}\n" for x in range(0, 720, 7))
RIGHT = {
    "run": [*MODEL, "--friction", "0.3", "--engagements", "1", "-o", "out.h5", "--plot", "out.png",
            "--report", "out.html"],
    "mechanism": [*SIZES, "--plot", "out.png"],
    "export": [*SIZES, "-o", "out.svg"],
    "index": ["--speed", "1", "--load-torque", "1", "--follower-inertia", "1", "--plot",
                     "out.png"],
    "measure": ["data.csv", "--slots", "4", "--pins", "1", "-o", "out.csv", "--plot", "out.png"],
}  # fmt: skip
# mistakes that show only when the work is done, or almost
LATE = [
    ("run", ["--engagements", "60", "--plot", "out.gif"], "at most 50 engagements"),
    ("run", ["--slots", "300", "--pins", "1"], "at most 200 in a drawing"),
    ("run", ["--slots", "300", "--pins", "1", "--plot", "out.gif"], "at most 200 in a drawing"),
    ("mechanism", ["--slots", "300"], "at most 200 in a drawing"),
    ("mechanism", ["--driver-inertia", "1"], "must come with --follower-inertia I, got none"),
    ("export", ["--thickness", "1 mm"], "--density"),
    ("export", ["--density", "7850"], "--thickness"),
    ("export", ["--locking-radius", "19.9 mm"], "locking_radius must be between"),
    ("export", ["--kerf", "3 mm"], "narrower kerf"),
    ("index", ["--pin-gap", "1 mm"], "--pin-gap must come with --pin-length"),
    ("measure", ["--phase", "1"], "--phase must come with --offset"),
]


@pytest.mark.parametrize(("name", "words", "said"), LATE)
def test_what_is_refused_late_leaves_nothing(refusal, tmp_path, name, words, said):
    (tmp_path / "data.csv").write_text(DATA)
    assert said in refusal(2, name, *RIGHT[name], *words)


def test_the_corrected_call_is_not_refused(refusal, command, tmp_path):
    words = ["export", *RIGHT["export"], "--thickness", "1 mm"]
    refusal(2, *words)
    assert command(*words, "--density", "7850")[0] == 0
    assert (tmp_path / "out.svg").exists()


OUTPUTS = {"output": "made", "plot": "made.png", "report": "made.html"}


PLAIN = {
    **{"sweep": [{"config": "study.toml"}], "reproduce": [{"source": "filemon"}]},
    **{"bench": [{}], "compile": [{}]},
}


SUFFIXES = {
    **{"run": ".h5", "rundown": ".csv", "sweep": ".h5", "budget": ".h5", "design": ".csv"},
    **{"explore": ".html", "plot": ".png", "export": ".svg", "measure": ".csv"},
}


def wrong_scenes(name, scene):
    """The scene with a number out of its range, with one left out, and with one that is idle.

    And with a word that is no value, for every option that takes one.
    """
    for option, action in options_of(name).items():
        if option in scene.get("tried", options_of(name).keys() - {*BY_DEFAULT}):
            yield {**scene, option: -1}
            if option in scene:
                yield {key: value for key, value in scene.items() if key != option}
            else:
                yield changed(action, scene)
    for action in parser_of(name)[1]._actions:
        takes = action.option_strings and action.nargs != 0
        if takes and action.dest not in ("log", "scheduler", *OUTPUTS):
            yield {**scene, action.option_strings[-1].removeprefix("--"): "no such value"}


@pytest.mark.parametrize(("name", "kind"), COMMAND_KINDS, ids=map("-".join, COMMAND_KINDS))
def test_a_refusal_leaves_nothing_on_disk(command, few_angles, monkeypatch, tmp_path, name, kind):
    # drawing takes long, and where a picture is made matters here, not what it shows
    if name != "plot":
        monkeypatch.setattr(_output, "picture", lambda _: "")
    monkeypatch.setattr(_output, "page_of", lambda *_, **__: "")
    write_inputs(name, kind)
    known = {action.dest for action in parser_of(name)[1]._actions}
    asked = {key: path for key, path in OUTPUTS.items() if key in known}
    if "output" in asked:
        asked["output"] += SUFFIXES.get(name, "")
    before, refused, wrong = {*tmp_path.iterdir()}, 0, []
    scenes = PLAIN.get(name) or scenes_of(name, kind)[:1]
    for scene in scenes:
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
    assert refused or not scenes
