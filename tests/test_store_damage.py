"""Disks that fail, and files that cannot be read: each gives one clear error."""

import os
import subprocess
import sys

import h5py
import pytest

import escapement as esc
from escapement.base.errors import InputFileError, MissingInput
from escapement.study.reader import read_study
from escapement.study.stored import SCHEMA_VERSION
from escapement.study.writer import write_study
from study_tools import assert_same, read_whole, study, write_in_blocks

pytestmark = pytest.mark.slow


def not_ours(path, **attributes):
    with h5py.File(path, "w") as file:
        file.attrs.update(attributes)


def newer(path):
    write_study(study(), path)
    with h5py.File(path, "r+") as file:
        file.attrs["schema_version"] = SCHEMA_VERSION + 1


def cut_short(path):
    write_study(study(), path)
    os.truncate(path, path.stat().st_size // 2)


def flipped(path):
    """One bit of a chunk of results is wrong."""
    write_study(study((200, 50)), path)
    with h5py.File(path) as file:
        chunk = file["period"].id.get_chunk_info(0)
    data = bytearray(path.read_bytes())
    data[chunk.byte_offset + chunk.size // 2] ^= 1
    path.write_bytes(data)


def changed(name, values):
    """A study with other values of one dataset or root attribute; None deletes it."""

    def make(path):
        write_study(study(), path)
        with h5py.File(path, "r+") as file:
            if values is None:
                del file[name]
            elif name in file.attrs:
                file.attrs[name] = values
            else:
                file[name][...] = values

    return make


INPUTS = [
    (lambda path: None, MissingInput, 66, "does not exist"),
    (lambda path: path.mkdir(), InputFileError, 65, "must be an ordinary file"),
    (lambda path: path.write_text("a,b\n1,2\n"), InputFileError, 65, "must be an HDF5 file"),
    (lambda path: path.write_bytes(b""), InputFileError, 65, "must be an HDF5 file"),
    (not_ours, InputFileError, 65, "must hold a study, and lacks configuration, status"),
    (newer, InputFileError, 65, f"schema_version {SCHEMA_VERSION} or less, got"),
    (cut_short, InputFileError, 65, "cannot be read in full"),
    (flipped, InputFileError, 65, "cannot be read in full"),
    (changed("period", None), InputFileError, 65, "object 'period' doesn't exist"),
    (changed("status", 77), InputFileError, 65, "status must hold known values"),
    (changed("friction", float("nan")), InputFileError, 65, "friction must be finite"),
    (changed("configuration", "[]"), InputFileError, 65, "must be a JSON object, got []"),
]


@pytest.mark.parametrize(("make", "error", "code", "message"), INPUTS)
def test_an_unreadable_study_is_refused_in_one_line(tmp_path, make, error, code, message):
    path = tmp_path / "a.h5"
    make(path)
    with pytest.raises(error) as caught:
        read_whole(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == code


@pytest.mark.parametrize(
    "damage", [flipped, *(changed(*what) for what in (("period", None), ("status", 77)))]
)
def test_a_damaged_study_is_not_taken_for_complete(tmp_path, damage):
    path, whole = tmp_path / "a.h5", study((200, 50) if damage is flipped else (3, 5))
    damage(path)
    before = path.read_bytes()
    with pytest.raises(InputFileError, match="cannot be read in full"):
        write_in_blocks(path, whole, list, resume=True)
    assert path.read_bytes() == before
    write_in_blocks(path, whole, list, force=True)
    assert_same(read_study(path), whole)


@pytest.fixture
def held(tmp_path):
    """A study and a motion that another program has open for writing."""
    paths = tmp_path / "study.h5", tmp_path / "motion.h5"
    write_study(study(), paths[0])
    timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113)
    esc.write_motion(esc.simulate(timer, 2), paths[1])
    hold = "import h5py, sys; f = [h5py.File(p, 'r+') for p in sys.argv[1:]]; print(); input()"
    command = [sys.executable, "-c", hold, *map(str, paths)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as program:
        program.stdout.readline()
        yield paths
        program.communicate("\n")


def test_a_file_that_is_open_elsewhere_is_not_called_damaged(held, command):
    for path in held:
        code, _, err = command("plot", path)
        assert code == 65
        assert err.startswith(f"escapement: error: file {path} must not be open for writing")
        assert err.count("\n") == 1
    with pytest.raises(InputFileError, match="must not be open for writing"):
        write_in_blocks(held[0], study(), list, resume=True)


@pytest.mark.parametrize(
    ("message", "remedy"),
    [
        ("unable to lock file, errno = 37, error message = 'No locks available'", "with locks"),
        ("file is already open for write (may use <h5clear file>)", "close it there"),
    ],
)
def test_missing_locks_and_left_marks_are_told(tmp_path, monkeypatch, message, remedy):
    def refuse(*arguments):
        raise OSError(message)

    write_study(study(), tmp_path / "a.h5")
    monkeypatch.setattr(h5py, "File", refuse)
    with pytest.raises(InputFileError, match=remedy) as caught:
        read_study(tmp_path / "a.h5")
    assert "HDF5_USE_FILE_LOCKING=FALSE" in str(caught.value)
