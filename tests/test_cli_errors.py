"""Command line: a mistake gives one line and the right exit code, and no file is written."""

import os
import shlex

import pytest

RUN = (
    *("run", "--torque", ".10", "--driver-inertia", "3e-6", "--follower-inertia", "50e-6"),
    *("--units", "in-lbf-s"),
)
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


def words(line):
    """A command line as words; RUN stands for a `run` that lacks nothing."""
    known = {"RUN": RUN, "LONG.h5": ["x" * 300 + ".h5"]}
    return [word for typed in shlex.split(line) for word in known.get(typed, [typed])]


@pytest.fixture(autouse=True)
def folder(tmp_path):
    """A folder with a good study, bad ones, and things that are no study."""
    (tmp_path / "good.toml").write_text(STUDY)
    (tmp_path / "bad.toml").write_text(STUDY.replace("friction", "frictoin"))
    (tmp_path / "broken.toml").write_text("units = \n")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "text.h5").write_text("no HDF5")
    (tmp_path / "data.png").write_text("no HDF5")
    (tmp_path / "t.csv").write_text("1,2\n")
    (tmp_path / "link.csv").symlink_to("t.csv")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "loop.h5").symlink_to("loop.h5")
    (tmp_path / "there.h5").write_text("mine")
    (tmp_path / "folder.h5").mkdir()
    return tmp_path


WRONG = {
    "nothing": ("", 2, "required: COMMAND", "--help"),
    "unknown command": ("rnu", 2, "COMMAND", "'rnu'", "did you mean 'run'?"),
    "options before the command": ("--units SI run", 2, "unknown option '--units'"),
    "misspelt option": ("RUN --frictoin .3", 2, "'--frictoin'", "did you mean '--friction'?"),
    "abbreviated option": ("RUN --fric .3", 2, "'--fric'", "did you mean '--friction'?"),
    "unlike a short option": ("bench --xyz", 2, "'--xyz'; see 'escapement bench --help'"),
    "unlike any option": ("index --rpm 60", 2, "'--rpm'; see 'escapement index --help'"),
    "a word of an option": ("RUN --inertia 1", 2, "did you mean '--driver-inertia'?"),
    "more than an option": ("RUN --output-file m.h5", 2, "did you mean '--output'?"),
    "missing torque": ("run --driver-inertia 1 --follower-inertia 1", 2, "required: --torque"),
    "option without value": ("run --torque", 2, "--torque", "expected one argument"),
    "flag with value": ("RUN --json=3", 2, "--json", "'3'"),
    "two kinds": ("RUN geneva geneva", 2, "unrecognized arguments: geneva"),
    "unknown kind": ("RUN genva", 2, "KIND", "'genva'", "did you mean 'geneva'?"),
    "wide pin": ("RUN --crank-radius .4 --pin-radius .2", 2, "less than 0.117157 in, where"),
    "unknown method": ("RUN --engine ivp --method RK54", 2, "method", "'RK45'?"),
    "method of another engine": ("RUN --method RK45", 2, "method", "'RK45'", "ivp"),
    "step of another engine": ("RUN --max-step 1e-3", 2, "max_step must", "ivp"),
    "too many": ("RUN --engagements 1000000000", 2, "engagements must", "need no long motion"),
    "plot too long": ("RUN --engagements 10001 --plot m.png", 2, "at most 10000 engagements"),
    "force without output": ("RUN --force", 2, "--force", "--output"),
    "one inertia": ("mechanism --driver-inertia 1", 2, "must come with --follower-inertia I"),
    "angle without drawing": ("mechanism --angle 3", 2, "--angle", "--plot"),
    "no study": ("sweep", 2, "CONFIG.toml", "sweep --help"),
    "unknown source": ("reproduce meier", 2, "SOURCE", "'meier'", "did you mean 'meyer'?"),
    "study with a mistake": ("sweep bad.toml", 2, "bad.toml", "'frictoin'", "'friction'?"),
    "missing study": ("sweep none.toml", 66, "none.toml", "does not exist"),
    "study after an option": ("compare none.toml --equal-period good.toml", 66, "none.toml"),
    "study is a folder": ("sweep folder.h5", 65, "folder.h5", "not a folder"),
    "study is not TOML": ("sweep broken.toml", 65, "broken.toml", "valid TOML"),
    "missing result": ("plot none.h5", 66, "none.h5", "does not exist"),
    "result is a folder": ("plot folder.h5 -o x.png", 65, "folder.h5", "not a folder"),
    "result is not HDF5": ("plot text.h5", 65, "text.h5", "HDF5", "sweep wrote"),
    "result without rows": ("plot t.csv", 65, "t.csv", "another one (no rows)"),
    "motion there": ("RUN -o there.h5", 73, "there.h5", "existing", "(--force) to replace"),
    "motion into a folder": ("RUN -o folder.h5", 73, "folder.h5", "directory"),
    "motion nowhere": ("RUN -o none/m.h5", 73, "none", "create it first"),
    "study there": ("sweep good.toml -o there.h5", 73, "there.h5", "--force"),
    "name too long": ("RUN -o LONG.h5", 73, "name too long"),
    "picture of no format": ("RUN --plot v.txt", 2, "v.txt", ".png, .pdf, .svg"),
    "picture nowhere": ("RUN --plot none/v.png", 73, "none"),
    "figure over its data": ("plot text.h5 -o text.h5", 2, "text.h5", "suffix"),
    "motion of no format": ("RUN -o a.png --plot ./a.png", 2, ".h5, .hdf5, .nc, .csv, got '.png'"),
    "study of no format": ("sweep good.toml -o good.toml --force", 2, ".parquet, got '.toml'"),
    "figure in the place of its data": ("plot data.png", 73, "data.png", "own"),
    "motion over its study": ("run --from text.h5 -o ./text.h5 --force", 73, "text.h5", "own"),
    "sample over its study": ("budget good.toml -o good.toml --force", 73, "not be good.toml too"),
    "over its table": ("RUN tabulated --table t.csv -o link.csv --force", 73, "link.csv", "t.csv"),
    "errors over it": ("measure text.h5 tabulated --table t.csv -o t.csv --force", 73, "own"),
    "figure of this folder": ("plot .", 65, "ordinary file"),
    "motion into a loop": ("RUN -o loop.h5", 73, "loop", "ordinary file"),
    "table too short": ("mechanism tabulated --table t.csv", 65, "table t.csv: theta must be"),
    "table from a folder": ("mechanism tabulated --table .", 65, "table "),
    "folder is a loop": ("reproduce meyer -o loop", 73, "loop"),
    "folder is a file": ("reproduce meyer -o text.h5", 73, "text.h5", "File exists"),
}


@pytest.mark.parametrize(
    ("line", "code", "said"), [(a, c, s) for a, c, *s in WRONG.values()], ids=WRONG
)
def test_what_is_wrong_is_told(refusal, line, code, said):
    told = refusal(code, *words(line))
    assert [text for text in said if text not in told] == []


PROTECTED = {
    "RUN -o new.h5 --plot there.png": "there.png",
    "mechanism --plot there.png": "there.png",
    "plot text.h5 -o there.png": "there.png",
    "reproduce filemon -o .": "filemon_table_1.json",
}


@pytest.mark.parametrize(("line", "name"), PROTECTED.items())
def test_read_only_file_is_not_replaced(refusal, folder, monkeypatch, line, name):
    """And nothing else is made where its place was known before."""
    (folder / name).write_text("old")
    # root may write every file
    monkeypatch.setattr(os, "access", lambda path, _: os.path.basename(path) != name)
    told = refusal(73, *words(line))
    assert f"{name} must be a file that may be replaced, got a read-only" in told
    assert (folder / name).read_text() == "old"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
@pytest.mark.parametrize("argv", [["plot", "pipe"], ["run", "--from", "pipe"]])
def test_a_pipe_is_not_waited_for(refusal, folder, argv):
    os.mkfifo(folder / "pipe")
    assert "pipe must be an ordinary file" in refusal(65, *argv)
