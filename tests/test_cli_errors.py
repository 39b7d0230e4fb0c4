"""Command line: whatever a user gets wrong is one line, the right exit code, and no file."""

import os

import pytest

BASE = {
    "--torque": ".10",
    "--driver-inertia": "3e-6",
    "--follower-inertia": "50e-6",
    "--units": "in-lbf-s",
}
STUDY = """
units = "in-lbf-s"
friction = 0.3
torque = 0.1
[mechanism]
slots = 4
[inertia]
driver = 3e-6
follower = 50e-6
[sweep]
load_torque = [0.0, 0.01]
"""


def run(*extra, without=()):
    """A `run` that is right but for `extra` and for what it lacks."""
    given = {name: value for name, value in BASE.items() if name not in without}
    return ["run", *(word for pair in given.items() for word in pair), *extra]


@pytest.fixture(autouse=True)
def folder(tmp_path):
    """A folder with a good study, bad ones, and things that are no study."""
    (tmp_path / "good.toml").write_text(STUDY)
    (tmp_path / "broken.toml").write_text("units = \n")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "text.h5").write_text("no HDF5")
    (tmp_path / "data.png").write_text("no HDF5")
    (tmp_path / "t.csv").write_text("1,2\n")
    (tmp_path / "link.csv").symlink_to("t.csv")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "there.h5").write_text("mine")
    (tmp_path / "folder.h5").mkdir()
    return tmp_path


USAGE = {
    "nothing": ([], "required: COMMAND", "--help"),
    "nothing after all": (["--", "run"], "COMMAND"),
    "unknown command": (["rnu"], "COMMAND", "'rnu'", "did you mean 'run'?"),
    "options before the command": (["--units", "SI", "run"], "unknown option '--units'"),
    "misspelt version": (["--verison"], "did you mean '--version'?"),
    "misspelt option": (run("--frictoin", ".3"), "'--frictoin'", "did you mean '--friction'?"),
    "abbreviated option": (run("--fric", ".3"), "'--fric'", "did you mean '--friction'?"),
    "misspelt before missing": (["run", "--torqe", "1"], "did you mean '--torque'?"),
    "unlike a short option": (["bench", "--foo"], "'--foo'; see 'escapement bench --help'"),
    "missing torque": (run(without=["--torque"]), "required: --torque"),
    "missing inertia": (run(without=["--driver-inertia"]), "required: --driver-inertia"),
    "option without value": (["run", "--torque"], "--torque", "expected one argument"),
    "flag with value": (run("--json=3"), "--json", "'3'"),
    "two kinds": (run("geneva", "geneva"), "unrecognized arguments: geneva"),
    "unknown kind": (run("genva"), "KIND", "'genva'", "did you mean 'geneva'?"),
    "unknown units": (run("--units", "in-lb-s"), "--units", "SI, in-lbf-s", "'in-lbf-s'?"),
    "unknown method": (run("--engine", "ivp", "--method", "RK54"), "method", "'RK45'?"),
    "method of another engine": (run("--method", "RK45"), "method", "'RK45'", "ivp"),
    "step of another engine": (run("--max-step", "1e-3"), "max_step must", "ivp"),
    "too many engagements": (
        run("--engagements", "1000000000"),
        "engagements must",
        "figures of merit need no long motion",
    ),
    "too many pins": (run("--slots", "4", "--pins", "5"), "pins must", "at most 4", "got 5"),
    "two lengths": (
        run("--engagements", "3", "--duration", "1"),
        "engagements and duration must",
        "3",
        "1.0",
    ),
    "force without output": (run("--force"), "--force", "--output"),
    "one inertia": (
        ["mechanism", "--driver-inertia", "1"],
        "required, both or none: --follower-inertia",
    ),
    "angle without drawing": (["mechanism", "--angle", "3"], "--angle", "--plot"),
    "negative word": (["mechanism", "--", "-5"], "KIND", "'-5'"),
    "no study": (["sweep"], "CONFIG.toml", "sweep --help"),
    "no file": (["plot"], "FILE.h5", "plot --help"),
    "no source": (["reproduce"], "SOURCE"),
    "unknown source": (["reproduce", "meier"], "SOURCE", "'meier'", "did you mean 'meyer'?"),
}


FILES = {
    "missing study": (["sweep", "none.toml"], 66, "none.toml", "does not exist"),
    "study is a folder": (["sweep", "folder.h5"], 65, "folder.h5", "not a folder"),
    "study is not TOML": (["sweep", "broken.toml"], 65, "broken.toml", "line 1"),
    "study is not text": (["sweep", "binary.toml"], 65, "binary.toml", "utf-8"),
    "missing result": (["plot", "none.h5"], 66, "none.h5", "does not exist"),
    "result is a folder": (["plot", "folder.h5", "-o", "x.png"], 65, "folder.h5", "not a folder"),
    "result is not HDF5": (["plot", "text.h5"], 65, "text.h5", "HDF5", "sweep wrote"),
    "motion there": (run("-o", "there.h5"), 73, "there.h5", "existing", "(--force) to replace"),
    "motion into a folder": (run("-o", "folder.h5"), 73, "folder.h5", "directory"),
    "motion nowhere": (run("-o", "none/m.h5"), 73, "none", "create it first"),
    "motion under a file": (run("-o", "text.h5/m.h5"), 73, "text.h5"),
    "study there": (["sweep", "good.toml", "-o", "there.h5"], 73, "there.h5", "--force"),
    "study into a folder": (["sweep", "good.toml", "-o", "folder.h5"], 73, "folder.h5"),
    "study nowhere": (["sweep", "good.toml", "-o", "none/x.h5"], 73, "none"),
    "name too long": (run("-o", "x" * 300 + ".h5"), 73, "name too long"),
    "picture of no format": (run("--plot", "v.txt"), 2, "v.txt", ".png, .pdf, .svg"),
    "picture without suffix": (run("--plot", "v"), 2, ".png, .pdf, .svg", "change the suffix"),
    "figure of no format": (["plot", "text.h5", "-o", "a.foo"], 2, "a.foo", ".png, .pdf, .svg"),
    "picture nowhere": (run("--plot", "none/v.png"), 73, "none"),
    "drawing nowhere": (["mechanism", "--plot", "none/v.png"], 73, "none"),
    "figure over its data": (["plot", "text.h5", "-o", "text.h5"], 2, "text.h5", "suffix"),
    "picture over the motion": (run("-o", "a.png", "--plot", "./a.png"), 73, "own"),
    "study over its configuration": (
        ["sweep", "good.toml", "-o", "good.toml", "--force"],
        73,
        "good.toml",
        "own",
    ),
    "figure in the place of its data": (["plot", "data.png"], 73, "data.png", "own"),
    "motion over its study": (
        ["run", "--from", "text.h5", "-o", "./text.h5", "--force"],
        73,
        "text.h5",
        "own",
    ),
    "motion over its table": (
        run("tabulated", "--table", "t.csv", "-o", "link.csv", "--force"),
        73,
        "link.csv",
        "t.csv",
    ),
    "errors over their table": (
        ["measure", "text.h5", "tabulated", "--table", "t.csv", "-o", "t.csv", "--force"],
        73,
        "t.csv",
        "own",
    ),
    "figure of this folder": (["plot", "."], 65, "ordinary file"),
    "figure of a loop": (["plot", "loop"], 66, "loop"),
    "motion into a loop": (run("-o", "loop"), 73, "loop", "ordinary file"),
    "picture into a loop": (["mechanism", "--plot", "loop/x.png"], 73, "loop"),
    "study into a loop": (["sweep", "good.toml", "-o", "loop"], 73, "loop"),
    "readings from a loop": (["measure", "loop", "-o", "x.csv"], 65, "loop"),
    "table from a loop": (["mechanism", "tabulated", "--table", "loop"], 65, "loop"),
    "table too short": (
        ["mechanism", "tabulated", "--table", "t.csv"],
        65,
        "table t.csv: theta must be at least",
    ),
    "table from a folder": (["mechanism", "tabulated", "--table", "."], 65, "table "),
    "folder is a loop": (["reproduce", "meyer", "-o", "loop"], 73, "loop"),
    "folder is a file": (["reproduce", "meyer", "-o", "text.h5"], 73, "text.h5", "File exists"),
    "folder nowhere": (["reproduce", "meyer", "-o", "none/there"], 73, "none/there"),
}


WRONG = {name: (argv, 2, said) for name, (argv, *said) in USAGE.items()}
WRONG |= {name: (argv, code, said) for name, (argv, code, *said) in FILES.items()}


@pytest.mark.parametrize(("argv", "code", "said"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_told(refusal, argv, code, said):
    line = refusal(code, *argv)
    assert [words for words in said if words not in line] == []


PROTECTED = {
    "velocities": (run("-o", "new.h5", "--plot", "there.png"), "there.png"),
    "drawing": (["mechanism", "--plot", "there.png"], "there.png"),
    "figure of a study": (["plot", "text.h5", "-o", "there.png"], "there.png"),
    "table": (["reproduce", "filemon", "-o", "."], "filemon_table_1.json"),
}


@pytest.mark.parametrize(("argv", "name"), PROTECTED.values(), ids=PROTECTED)
def test_read_only_file_is_not_replaced(refusal, folder, monkeypatch, argv, name):
    """And nothing else is made where its place was known before."""
    (folder / name).write_text("old")
    # root may write every file
    monkeypatch.setattr(os, "access", lambda path, _: os.path.basename(path) != name)
    assert f"{name} must be a file that may be replaced, got a read-only" in refusal(73, *argv)
    assert (folder / name).read_text() == "old"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
@pytest.mark.parametrize("argv", [["plot", "pipe"], ["run", "--from", "pipe"]])
def test_a_pipe_is_not_waited_for(refusal, folder, argv):
    os.mkfifo(folder / "pipe")
    assert "pipe must be an ordinary file" in refusal(65, *argv)


STUDIES = {
    "unknown key": (("friction = 0.3", "frictoin = 0.3"), "frictoin", "friction"),
    "negative inertia": (("driver = 3e-6", "driver = -3e-6"), "driver", "-3e-06"),
    "empty axis": (("[0.0, 0.01]", "[]"), "load_torque", "at least one value"),
    "no such solution": (
        (
            "slots = 4",
            'kind = "gear-driven"\nstations = 6\nlobes = 1\ncurve = "epicycloid"\nsolution = 99',
        ),
        "solution",
        "99",
    ),
    "a table too short": (
        ("slots = 4", 'kind = "tabulated"\ntheta = [0.0, 1.0]\nphi = [0.0, 1.0]'),
        "theta must be at least 12 rows long",
    ),
    "nothing swept": (("load_torque = [0.0, 0.01]", ""), "sweep"),
}


@pytest.mark.parametrize(("change", "said"), [(c, s) for c, *s in STUDIES.values()], ids=STUDIES)
def test_wrong_study(refusal, folder, change, said):
    text = STUDY.replace(*change)
    if "tabulated" in text:
        text = text.replace("friction = 0.3", "")  # a mesh has none
    (folder / "bad.toml").write_text(text)
    line = refusal(2, "sweep", "bad.toml")
    assert [words for words in ("bad.toml", *said) if words not in line] == []
