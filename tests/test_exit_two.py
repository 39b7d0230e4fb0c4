"""Wrong usage leaves nothing on disk, whichever command, and however late it is found."""

import pytest

from escapement.cli import COMMANDS, main
from escapement.cli._arguments import parser_of

MODEL = ["--torque", "0.0113", "--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6"]
SIZES = ["--slots", "4", "--pins", "1", "--crank-radius", "0.02", "--pin-radius", "1e-3",
         "--clearance", "1e-5"]  # fmt: skip
WISH = 'period = "40 ms"\ntorque = "10 mN m"\nslots = 4\ninternal = false\n'
STUDY = (
    "torque = 0.01\n[mechanism]\nslots = 4\n[inertia]\ndriver = 1e-6\nfollower = 1e-6\n"
    "[sweep]\nfriction = [0.2, 0.3]\n"
)
SAMPLE = STUDY[: STUDY.index("[sweep]")] + (
    "[sample]\nmethod = 'random'\nsize = 64\nfriction = { low = 0.2, high = 0.3 }\n"
    "[limits]\nperiod = [0.001, 1.0]\n"
)
DATA = "theta,phi\n" + "".join(f"{x},{0.5 * x}\n" for x in range(0, 720, 7))
# each command with all files that it can write
RIGHT = {
    "run": [*MODEL, "--friction", "0.3", "--engagements", "1", "-o", "out.h5", "--plot", "out.png",
            "--report", "out.html"],
    "rundown": [*MODEL, "--spring-rate", "1e-5", "--turns", "1", "-o", "out.csv", "--plot",
                "out.png"],
    "sweep": ["study.toml", "-o", "out.h5"],
    "budget": ["sample.toml", "-o", "out.h5", "--plot", "out.png", "--report", "out.html"],
    "design": ["wish.toml", "--count", "2", "-o", "out.csv", "--plot", "out.png", "--report",
               "out.html"],
    "explore": [*MODEL, "-o", "out.html"],
    "plot": ["study.toml", "-o", "out.png"],
    "mechanism": [*SIZES, "--plot", "out.png"],
    "export": [*SIZES, "-o", "out.svg"],
    "drive-torque": ["--speed", "1", "--load-torque", "1", "--follower-inertia", "1", "--plot",
                     "out.png"],
    "measure": ["data.csv", "--slots", "4", "--pins", "1", "-o", "out.csv", "--plot", "out.png"],
    "reproduce": ["filemon", "-o", "out"],
    "bench": ["-o", "out"],
}  # fmt: skip
# mistakes that show only when the work is done, or almost
LATE = [
    ("run", ["--engagements", "60", "--plot", "out.gif"], "at most 50 engagements"),
    ("run", ["--slots", "300", "--pins", "1"], "at most 200 in a drawing"),
    ("run", ["--slots", "300", "--pins", "1", "--plot", "out.gif"], "at most 200 in a drawing"),
    ("mechanism", ["--slots", "300"], "at most 200 in a drawing"),
    ("mechanism", ["--driver-inertia", "1"], "both or none"),
    ("export", ["--thickness", "1 mm"], "--density"),
    ("export", ["--density", "7850"], "--thickness"),
    (
        "export",
        ["--thickness", "1e300", "--density", "1e300"],
        "driver_inertia must be a finite number",
    ),
    ("export", ["--locking-radius", "19.9 mm"], "locking_radius must be between"),
    ("export", ["--kerf", "3 mm"], "narrower kerf"),
    ("drive-torque", [*SIZES], "must be left out at constant speed"),
    ("measure", ["--phase", "1"], "--offset must come with --phase"),
]


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in {"wish.toml": WISH, "study.toml": STUDY, "sample.toml": SAMPLE,
                       "data.csv": DATA}.items():  # fmt: skip
        (tmp_path / name).write_text(text)
    return tmp_path


def files(folder):
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*")}


def test_every_command_is_tried():
    assert {*RIGHT} == {*COMMANDS}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_wrong_value_of_any_option_leaves_nothing(command, place, capsys):
    """Options that take a value get one that they cannot have."""
    before, refused = files(place), 0
    parser = parser_of(command)[1]
    for action in parser._actions:
        if not action.option_strings or action.nargs == 0 or action.dest in ("log", "output"):
            continue
        words = [command, *RIGHT[command], action.option_strings[-1], "no such value"]
        code, err = main(words), capsys.readouterr().err
        if code != 2:
            continue  # a name of a file or a column that may be so
        refused += 1
        assert err.startswith("escapement: error: ")
        assert err.count("\n") == 1
        assert files(place) == before, action.option_strings
    assert refused


@pytest.mark.parametrize(("command", "words", "said"), LATE)
def test_what_is_refused_late_leaves_nothing(command, words, said, place, capsys):
    before = files(place)
    assert main([command, *RIGHT[command], *words]) == 2
    assert said in capsys.readouterr().err
    assert files(place) == before


def test_the_corrected_call_is_not_refused(place, capsys):
    words = ["export", *RIGHT["export"], "--thickness", "1 mm"]
    assert main(words) == 2
    assert main([*words, "--density", "7850"]) == 0
    assert (place / "out.svg").exists()
