"""The result file: its layout, its round trip, and every way a disk can fail."""

import errno
import io
import os
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

from escapement import _whole_file
from escapement._whole_file import check_target
from escapement.errors import CannotCreate, InputFileError, MissingInput, StorageError
from escapement.status import Status
from escapement.store import (
    RESULTS,
    SCHEMA_VERSION,
    Study,
    StudyWriter,
    _image,
    _journal,
    blocks_of,
    encode_block,
    partial_path,
    read_study,
    write_study,
)
from escapement.store._chunks import encode, fletcher32, tiling

ATTRIBUTES = {
    "title": "a study – of µ",
    "schema_version": SCHEMA_VERSION,
    "package_version": "0.1.0",
    "engine": "energy",
    "rtol": 1e-12,
    "created": "2000-01-01T00:00:00+00:00",
}


def study(shape=(3, 5), seed=0):
    """A study of random results, some of them missing."""
    rng = np.random.default_rng(seed)
    names = ("friction", "torque", "slots")[: len(shape)]
    axes = {name: np.linspace(0.1, 0.4, n) for name, n in zip(names, shape, strict=True)}
    if "slots" in axes:
        axes["slots"] = np.arange(3, 3 + shape[2])
    results = {}
    for name, result in RESULTS.items():
        values = rng.integers(0, 6, shape) if name == "status" else rng.random(shape)
        results[name] = values.astype(result.dtype)
    for name in results.keys() - {"status"}:
        results[name][results["status"] > 0] = np.nan
    units = dict.fromkeys(axes, "1") | {"torque": "in lbf"}
    return Study(
        axes=axes,
        results=results,
        units=units | {name: result.units for name, result in RESULTS.items()},
        long_names=dict.fromkeys(axes, "an axis") | {n: r.long_name for n, r in RESULTS.items()},
        configuration={"sweep": {name: values.tolist() for name, values in axes.items()}},
        attributes=ATTRIBUTES,
    )


def block(whole, number):
    cut = blocks_of(whole)
    span = slice(*cut.span(number))
    columns = {name: values.reshape(-1)[span] for name, values in whole.results.items()}
    return encode_block(cut, number, columns)


def write_in_blocks(path, whole, order, **options):
    """Write the missing blocks in some order; returns their numbers."""
    with StudyWriter(path, whole, **options) as writer:
        numbers = order(writer.missing)
        for number in numbers:
            writer.add(block(whole, number))
    return numbers


def assert_same(one, other):
    assert list(one.axes) == list(other.axes)
    for name in one.axes:
        np.testing.assert_array_equal(one.axes[name], other.axes[name])
    for name in RESULTS:
        np.testing.assert_array_equal(one.results[name], other.results[name])
    assert one.attributes == other.attributes
    assert one.configuration == other.configuration


@pytest.mark.parametrize("shape", [(1,), (7,), (3, 5), (3, 1, 4), (2, 70_001), (70_001, 2)])
def test_what_is_written_is_read(tmp_path, shape):
    whole = study(shape)
    write_study(whole, tmp_path / "a.h5")
    again = read_study(tmp_path / "a.h5")
    assert_same(whole, again)
    assert (again.units["torque"] if len(shape) > 1 else "in lbf") == "in lbf"
    assert again.failed == np.isin(whole.results["status"], [2, 3, 4, 5]).sum()


def test_layout(tmp_path):
    whole = study((3, 5, 2))
    write_study(whole, tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        assert dict(file.attrs) == ATTRIBUTES
        assert set(file) == {*whole.axes, *RESULTS, "configuration"}
        for name, dataset in file.items():
            assert dataset.attrs["units"]
            assert dataset.attrs["long_name"]
            if name == "configuration":
                assert dataset.shape == ()
                assert h5py.check_string_dtype(dataset.dtype).encoding == "utf-8"
                continue
            assert dataset.dtype.str == {"status": "|u1", "slots": "<i8"}.get(name, "<f8")
            assert (dataset.compression, dataset.shuffle, dataset.fletcher32) == (
                "gzip",
                True,
                True,
            )
            if name in whole.axes:
                assert dataset.is_scale
            else:
                assert [dimension[0].name for dimension in dataset.dims] == [
                    "/friction",
                    "/torque",
                    "/slots",
                ]
        status = file["status"].attrs
        assert status["flag_values"].dtype == np.uint8
        assert list(status["flag_values"]) == [member.value for member in Status]
        assert status["flag_meanings"].split() == [member.label for member in Status]


def test_xarray_opens_it_without_this_package(tmp_path):
    whole = study()
    write_study(whole, tmp_path / "a.h5")
    with xarray.open_dataset(tmp_path / "a.h5", engine="h5netcdf") as dataset:
        assert dataset.period.dims == ("friction", "torque")
        assert dataset.torque.attrs["units"] == "in lbf"
        assert dataset.attrs["title"] == ATTRIBUTES["title"]
        for name in RESULTS:
            np.testing.assert_array_equal(dataset[name], whole.results[name])
        picked = dataset.period.sel(friction=0.25, method="nearest")
        np.testing.assert_array_equal(picked, whole.results["period"][1])


def test_bytes_do_not_depend_on_the_order_of_the_blocks(tmp_path):
    whole = study((3, 30_000))
    write_study(whole, tmp_path / "a.h5")
    files = {(tmp_path / "a.h5").read_bytes()}
    for name, order in {"b": list, "c": reversed, "d": lambda n: [*n[1::2], *n[::2]]}.items():
        write_in_blocks(tmp_path / f"{name}.h5", whole, order)
        files.add((tmp_path / f"{name}.h5").read_bytes())
    assert len(files) == 1
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.parametrize("kept", [0, 2])
def test_blocks_that_memory_no_longer_holds_are_read_back(tmp_path, monkeypatch, kept):
    monkeypatch.setattr(_journal, "_RECENT", kept)
    whole = study((3, 30_000))
    write_study(whole, tmp_path / "a.h5")
    write_in_blocks(tmp_path / "b.h5", whole, reversed)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


@pytest.mark.parametrize("advice", [None, OSError])
def test_the_systems_memory_is_left_where_it_can_be(tmp_path, monkeypatch, advice):
    def refuse(*_):
        raise advice(errno.EINVAL, "no")

    monkeypatch.setattr(_journal, "SYNC_EVERY", 0.0)
    if advice is None:
        monkeypatch.delattr(os, "posix_fadvise", raising=False)
    else:
        monkeypatch.setattr(os, "posix_fadvise", refuse, raising=False)
    write_in_blocks(tmp_path / "a.h5", study(), list)
    assert_same(read_study(tmp_path / "a.h5"), study())


@settings(deadline=None)
@given(st.lists(st.integers(1, 9), min_size=1, max_size=4), st.integers(1, 40))
def test_chunks_hold_every_case_once_in_order(shape, cells):
    cut = tiling(tuple(shape), cells)
    numbers = np.arange(np.prod(shape)).reshape(shape)
    assert cut.cells < 2 * max(cells, 2)
    position = 0
    for chunk in range(len(cut)):
        start, stop = cut.span(chunk)
        box = tuple(slice(o, o + n) for o, n in zip(cut.offset(chunk), cut.tile, strict=True))
        assert start == position
        assert numbers[box].ravel().tolist() == list(range(start, stop))
        position = stop
    assert position == numbers.size


@settings(deadline=None)
@given(st.binary(max_size=2000))
def test_checksum_is_the_published_algorithm(data):
    first = second = 0
    for i in range(0, len(data) - len(data) % 2, 2):
        first = (first + (data[i] << 8 | data[i + 1])) % 65535
        second = (second + first) % 65535
    if len(data) % 2:
        first = (first + (data[-1] << 8)) % 65535
        second = (second + first) % 65535
    value = fletcher32(data)
    assert (value & 0xFFFF) % 65535 == first
    assert (value >> 16) % 65535 == second
    assert (value == 0) == (not any(data))


@pytest.mark.parametrize("values", [np.zeros(9), np.full(9, np.nan), np.arange(9.0)])
def test_chunks_are_what_hdf5_itself_decodes(values):
    with h5py.File(io.BytesIO(), "w") as file:
        dataset = file.create_dataset(
            "x", (9,), "<f8", chunks=(9,), compression="gzip", shuffle=True, fletcher32=True
        )
        dataset.id.write_direct_chunk((0,), encode(values, 9))
        np.testing.assert_array_equal(dataset[()], values)


def a_file(tmp_path):
    (tmp_path / "file").write_text("precious")
    return tmp_path / "file"


OUTPUTS = [
    (a_file, "must not exist yet, got an existing file; choose another name or give --force"),
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
        StudyWriter(path, study()).__enter__()
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 73
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(CannotCreate, match="Permission denied"):
        StudyWriter(tmp_path / "a.h5", study()).__enter__()


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

    monkeypatch.setattr(_whole_file, "open", refuse, raising=False)
    with pytest.raises(error, match=os.strerror(code)):
        write_study(study(), tmp_path / "a.h5")


def write_then(path, action, force=True):
    """Write everything, and act before the file is put in place."""
    with StudyWriter(path, study(), force=force) as writer:
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
    (tmp_path / "link").symlink_to(tmp_path / "real.h5")
    write_study(study(), tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
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


def test_a_folder_that_vanishes(tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    with pytest.raises(StorageError, match="were removed"):
        write_then(folder / "a.h5", lambda: shutil.rmtree(folder))


def test_too_few_blocks_are_caught(tmp_path):
    with pytest.raises(ValueError, match="lacks 1 blocks"), StudyWriter(tmp_path / "a.h5", study()):
        pass
    assert list(tmp_path.iterdir()) == []


class FailingFile:
    """A file whose writes fail from one call on, after doing them by halves."""

    def __init__(self, file, failing_call, code):
        self._file, self._left, self._code = file, failing_call, code

    def __getattr__(self, name):
        return getattr(self._file, name)

    def _spend(self):
        self._left -= 1
        if self._left < 0:
            raise OSError(self._code, os.strerror(self._code))

    def write(self, data):
        self._spend()
        return self._file.write(data[: max(1, len(data) // 2)])

    def truncate(self, size):
        self._spend()
        return self._file.truncate(size)

    def fileno(self):
        self._spend()
        return self._file.fileno()


def write_to_failing_disk(path, failing_call, code, monkeypatch):
    """Message of the storage error, None where nothing failed."""

    class Failing(_whole_file.PendingFile):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            self.handle = FailingFile(self.handle, failing_call, code)

    with monkeypatch.context() as patch:
        patch.setattr(_image, "PendingFile", Failing)
        try:
            write_study(study((2, 40_000)), path, force=True)
        except StorageError as error:
            return str(error)
    return None


def test_a_disk_that_fails_at_any_write_costs_one_clean_error(tmp_path, monkeypatch):
    path = a_file(tmp_path)
    codes = [errno.ENOSPC, errno.EIO, errno.EFBIG, errno.EDQUOT, errno.EPERM]
    calls = [*range(0, 60), *range(60, 10_000, 29)]
    for call in calls:
        code = codes[call % len(codes)]
        message = write_to_failing_disk(path, call, code, monkeypatch)
        if message is None:
            break
        assert message.startswith(f"writing {path} failed: {os.strerror(code)}; ")
        assert path.read_text() == "precious"
        assert list(tmp_path.iterdir()) == [path]
    assert call > 100
    assert_same(read_study(path), study((2, 40_000)))


SMALL_DISK = """
import resource, sys
sys.path.insert(0, {folder!r})
from test_store import study
from escapement.errors import EscapementError
from escapement.store import write_study
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
try:
    write_study(study((3, 70_000)), {path!r})
except EscapementError as error:
    print(error)
    sys.exit(error.exit_code)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no resource limits")
@pytest.mark.parametrize("limit", [100, 5_000, 300_000, 3_000_000])
def test_a_full_disk_ends_the_process_in_peace(tmp_path, limit):
    path = str(tmp_path / "a.h5")
    code = SMALL_DISK.format(folder=os.path.dirname(__file__), limit=limit, path=path)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (74, "")
    assert done.stdout.startswith(f"writing {path} failed: File too large; nothing was left")
    assert done.stdout.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


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


INPUTS = [
    (lambda path: None, MissingInput, 66, "does not exist"),
    (lambda path: path.mkdir(), InputFileError, 65, "must be an ordinary file"),
    (lambda path: path.write_text("a,b\n1,2\n"), InputFileError, 65, "must be an HDF5 file"),
    (lambda path: path.write_bytes(b""), InputFileError, 65, "must be an HDF5 file"),
    (not_ours, InputFileError, 65, "must hold a study, and lacks configuration, velocity_max"),
    (newer, InputFileError, 65, f"schema_version {SCHEMA_VERSION} or less, got"),
    (cut_short, InputFileError, 65, "is damaged"),
    (flipped, InputFileError, 65, "is damaged"),
]


@pytest.mark.parametrize(("make", "error", "code", "message"), INPUTS)
def test_an_unreadable_study_is_refused_in_one_line(tmp_path, make, error, code, message):
    path = tmp_path / "a.h5"
    make(path)
    with pytest.raises(error) as caught:
        read_study(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == code


def test_permissions_are_those_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    write_study(study(), tmp_path / "a.h5")
    assert (tmp_path / "a.h5").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_target_is_checked_without_being_made(tmp_path):
    assert check_target(tmp_path / "a.h5") == (tmp_path / "a.h5").resolve()
    assert list(tmp_path.iterdir()) == []
