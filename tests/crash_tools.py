"""A small study, a process that writes it, and calls that fail, for tests of crashes."""

import errno
import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from unittest import mock

from escapement.base import files
from escapement.base.errors import CannotCreate, EscapementError
from escapement.study.writer import partial_path, study_writer
from study_tools import block, study

ERRORS = (errno.ENOSPC, errno.EIO, errno.EFBIG, errno.EACCES, errno.EROFS, errno.ENOENT)
NAMES = ["a.h5", "a.csv", *["a.parquet"] * (find_spec("pyarrow") is not None)]
"""Of outputs, one of each format that is to be had here."""
CASES = 40
"""Of the small study: ten blocks of four cases."""


def small_study():
    """A study of random results."""
    return study((CASES,), engine="ivp")


def write(path, whole, *, added=None, pause=0.0, stop_after=None, **options):
    """Write the missing blocks; `added` collects the numbers of those that are safe."""
    with study_writer(path, whole, **options) as writer:
        for number in writer.missing[:stop_after]:
            writer.add(block(whole, number))
            if added is not None:
                added.append(number)
            time.sleep(pause)


def start_writer(path, pause=0.002):
    """A process that writes the small study and tells each block that is safe."""
    return subprocess.Popen(
        [sys.executable, __file__, str(path), str(pause)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def kill_one(path, delay, number=signal.SIGKILL):
    """Start a writer, send it a signal `delay` after it begins; blocks it told."""
    with start_writer(path) as process:
        assert process.stdout.readline() == "begun\n"
        time.sleep(delay)
        process.send_signal(number)
        output, errors = process.communicate(timeout=60)
    assert "Traceback" not in errors or number == signal.SIGINT
    return [int(line) for line in output.split() if line.isdigit()]


def kill_until_done(path, kills, rng):
    """Kill writers of one file, one after the other; how many kills hit a running one."""
    reference = path.with_stem("reference")
    if not reference.exists():
        write(reference, small_study())
    hits = 0
    for _ in range(kills):
        told = kill_one(path, rng.uniform(0.0, 0.06))
        if not path.exists():
            hits += 1
            lost = set(told) & set(missing(path))
            assert not lost, f"blocks {lost} were finished and are lost"
            continue
        assert path.read_bytes() == reference.read_bytes()
        path.unlink()
        partial_path(path).unlink(missing_ok=True)
    write(path, small_study(), resume=True)
    assert path.read_bytes() == reference.read_bytes()
    assert sorted(path.parent.iterdir()) == sorted([path, reference])
    path.unlink()
    return hits


def missing(path):
    """Numbers of the blocks that partial results lack, which stay as they are."""
    try:
        with study_writer(path, small_study(), resume=True) as writer:
            numbers = writer.missing
            raise ZeroDivisionError
    except ZeroDivisionError:
        pass
    return numbers


class Faults:
    """Counts the calls of the write path, and makes one of them fail."""

    def __init__(self, failing=None, code=None):
        self.calls, self._failing, self._code = 0, failing, code

    def spend(self):
        self.calls += 1
        if self.calls - 1 == self._failing:
            raise OSError(self._code, os.strerror(self._code))

    def wrap(self, function):
        def faulty(*arguments, **options):
            self.spend()
            return function(*arguments, **options)

        return faulty


class FaultyFile:
    """A file of which some call fails; one that writes does half of it first."""

    def __init__(self, file, faults):
        self._file, self._faults = file, faults

    def __getattr__(self, name):
        value = getattr(self._file, name)
        if name in ("write", "truncate", "read", "readinto", "seek", "fileno"):
            return self._faults.wrap(value)
        return value

    def write(self, data):
        half = memoryview(data)[: max(1, len(data) // 2)]
        written = self._file.write(half)
        self._faults.spend()
        return written

    def close(self):
        self._file.close()


@contextmanager
def faults(failing=None, code=None):
    """Within, the call number `failing` of the write path raises an OSError."""
    plan = Faults(failing, code)

    def faulty_open(*arguments, **options):
        plan.spend()
        return FaultyFile(open(*arguments, **options), plan)

    class FaultyDatabase(sqlite3.Connection):
        def execute(self, *arguments):
            try:
                plan.spend()
            except OSError as error:
                failure = sqlite3.OperationalError(str(error))
                full = error.errno == errno.ENOSPC
                failure.sqlite_errorcode = sqlite3.SQLITE_FULL if full else sqlite3.SQLITE_IOERR
                raise failure from None
            return super().execute(*arguments)

    connect = sqlite3.connect
    with (
        mock.patch.multiple(
            os,
            fsync=plan.wrap(os.fsync),
            replace=plan.wrap(os.replace),
            unlink=plan.wrap(os.unlink),
            open=plan.wrap(os.open),
        ),
        mock.patch.object(files, "open", faulty_open, create=True),
        mock.patch.object(sqlite3, "connect", partial(connect, factory=FaultyDatabase)),
    ):
        yield plan


def fail_once(path, failing, code, begun):
    """A run of which one call fails, then one that resumes it; False where none failed.

    `begun` : whether the failing run itself resumes another.
    """
    folder, reference, whole = path.parent, path.with_stem("reference"), small_study()
    if not reference.exists():
        write(reference, whole)
    for leftover in [*folder.glob(f"{path.name}*"), *folder.glob(".escapement*")]:
        leftover.unlink()
    if begun:
        leave_half(path)
    path.write_text("precious")
    added: list[int] = []
    refusal = None
    with faults(failing, code) as plan:
        try:
            write(path, whole, added=added, force=True, resume=begun)
        except EscapementError as error:
            refusal = error
    if refusal is not None:
        assert refusal.exit_code in (73, 74)
        assert "\n" not in str(refusal)
        assert str(path) in str(refusal)
        assert path.read_bytes() in (b"precious", reference.read_bytes())
        before = set(range(5)) if begun else set()
        path.unlink()
        assert not (before | set(added)) & set(missing(path)), "a finished block is lost"
        write(path, whole, resume=True)
    assert path.read_bytes() == reference.read_bytes()
    return plan.calls > failing


def leave_half(path):
    """Partial results of the first five blocks of the small study."""
    try:
        write(path, small_study(), stop_after=5)
    except ValueError:
        return


def damage(data, rng):
    """Bytes with one random damage: flipped, overwritten, cut, doubled or dropped."""
    data = bytearray(data)
    place = rng.randrange(len(data))
    span = rng.choice([1, 2, 16, 512, 4096])
    kind = rng.randrange(5)
    if kind == 0:
        data[place] ^= 1 << rng.randrange(8)
    elif kind == 1:
        data[place : place + span] = rng.randbytes(len(data[place : place + span]))
    elif kind == 2:
        del data[place:]
    elif kind == 3:
        data[place:place] = data[place : place + span]
    else:
        del data[place : place + span]
    return bytes(data)


def damage_once(folder, rng):
    """Resume from damaged partial results, with the remedy of a refusal; "" where none was told."""
    path, reference = folder / "a.h5", folder / "reference.h5"
    if not reference.exists():
        write(reference, small_study())
        leave_half(folder / "half.h5")
    whole = partial_path(folder / "half.h5").read_bytes()
    damaged = damage(whole, rng)
    partial_path(path).write_bytes(damaged)
    refusal = ""
    try:
        write(path, small_study(), resume=True)
    except CannotCreate as error:
        refusal = str(error)
        assert "\n" not in refusal
        assert str(path) in refusal
        assert not path.exists()
        if refusal.endswith("; move it away"):  # nothing tells that it was ours
            partial_path(path).unlink()
        else:
            assert refusal.endswith("start over with force=True (--force) and without resume")
        write(path, small_study(), force=True)
    assert path.read_bytes() == reference.read_bytes()
    assert sorted(entry.name for entry in folder.iterdir()) == [
        "a.h5",
        "half.h5.partial",
        "reference.h5",
    ]
    path.unlink()
    return refusal


if __name__ == "__main__":

    class Teller(list):
        def append(self, number):
            print(number, flush=True)

    print("begun", flush=True)
    write(Path(sys.argv[1]), small_study(), added=Teller(), pause=float(sys.argv[2]), resume=True)
