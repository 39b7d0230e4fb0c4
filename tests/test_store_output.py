"""Where a result file may be written, and when an existing one is replaced."""

import errno
import os

import pytest

from escapement.base import files
from escapement.base.errors import CannotCreate, StorageError
from escapement.study.reader import read_study
from escapement.study.writer import partial_path, study_writer, write_study
from study_tools import a_file, assert_same, block, study, write_in_blocks

OUTPUTS = [
    (a_file, "must not exist yet, got an existing file; choose another name, or give force=True"),
    (lambda path: path, "must be a file, got a directory"),
    (lambda path: path / "no" / "a.h5", "must be in an existing folder"),
    (lambda path: a_file(path) / "a.h5", "Not a directory"),
    (lambda path: path / ("a" * 300), "File name too long"),
    (lambda path: "/dev/null", "must be an ordinary file"),
]


@pytest.mark.parametrize(("output", "message"), OUTPUTS, ids=[message for _, message in OUTPUTS])
def test_an_output_in_the_way_is_refused_before_any_work(tmp_path, output, message):
    path = output(tmp_path)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(CannotCreate) as caught:
        study_writer(path, study()).__enter__()
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 73
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("code", "error"),
    [
        (errno.EACCES, CannotCreate),
        (errno.EROFS, CannotCreate),
        (errno.EMFILE, CannotCreate),
        (errno.ENOSPC, StorageError),
        (errno.EIO, StorageError),
    ],
)
def test_a_file_that_cannot_be_opened(tmp_path, monkeypatch, code, error):
    def refuse(*_, **__):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(files, "open", refuse, raising=False)
    with pytest.raises(error, match=os.strerror(code)):
        write_study(study(), tmp_path / "a.h5")


def write_then(path, action, force=True):
    """Write everything, and act before the file is put in place."""
    with study_writer(path, study(), force=force) as writer:
        for number in writer.missing:
            writer.add(block(study(), number))
        action()


def test_force_replaces_a_file_only_by_a_complete_one(tmp_path):
    path = a_file(tmp_path)
    with pytest.raises(ZeroDivisionError):
        write_then(path, lambda: path.read_text() == "precious" and 1 / 0)
    assert path.read_text() == "precious"
    assert partial_path(path).exists()
    write_study(study(), path, force=True)
    assert_same(read_study(path), study())


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "link.h5").symlink_to(tmp_path / "real.h5")
    write_study(study(), tmp_path / "link.h5")
    assert (tmp_path / "link.h5").is_symlink()
    assert_same(read_study(tmp_path / "real.h5"), study())


def test_a_file_that_appears_meanwhile_is_not_overwritten(tmp_path):
    path = tmp_path / "a.h5"
    with pytest.raises(CannotCreate, match="existing"):
        write_then(path, lambda: path.write_text("precious"), force=False)
    assert path.read_text() == "precious"
    path.unlink()
    assert write_in_blocks(path, study(), list, resume=True) == []
    assert_same(read_study(path), study())
    assert list(tmp_path.iterdir()) == [path]


def test_too_few_blocks_are_caught(tmp_path):
    with (
        pytest.raises(ValueError, match="lacks 1 blocks"),
        study_writer(tmp_path / "a.h5", study()),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(CannotCreate, match="Permission denied"):
        study_writer(tmp_path / "a.h5", study()).__enter__()
