"""The result file: its layout, its bytes and its round trip."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from escapement.base.status import Status
from escapement.study.block import blocks_of, fletcher32, tiling
from escapement.study.reader import read_study
from escapement.study.result import RESULTS
from escapement.study.writer import write_study
from study_tools import ATTRIBUTES, assert_same, study, write_in_blocks


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
        assert dict(file.attrs) == ATTRIBUTES | {"configuration": json.dumps(whole.configuration)}
        assert set(file) == {*whole.axes, *whole.fixed, *RESULTS}
        for name, dataset in file.items():
            assert dataset.attrs["units"]
            assert dataset.attrs["long_name"]
            if name in whole.fixed:
                assert dataset[()] == whole.fixed[name]
                continue
            assert dataset.dtype.str == {"status": "|u1", "slots": "<i8"}.get(name, "<f8")
            filters = (dataset.compression, dataset.shuffle, dataset.fletcher32)
            assert filters == ("gzip", True, True)
            if name in whole.axes:
                assert dataset.is_scale
            else:
                scales = [dimension[0].name for dimension in dataset.dims]
                assert scales == ["/friction", "/torque", "/slots"]
        status = file["status"].attrs
        assert status["flag_values"].dtype == np.uint8
        assert list(status["flag_values"]) == [member.value for member in Status]
        assert status["flag_meanings"].split() == [member.label for member in Status]


def test_bytes_do_not_depend_on_the_order_of_the_blocks(tmp_path):
    whole = study((3, 30_000))
    write_study(whole, tmp_path / "a.h5")
    files = {(tmp_path / "a.h5").read_bytes()}
    for name, order in {"b": list, "c": reversed, "d": lambda n: [*n[1::2], *n[::2]]}.items():
        write_in_blocks(tmp_path / f"{name}.h5", whole, order)
        files.add((tmp_path / f"{name}.h5").read_bytes())
    assert len(files) == 1
    assert len(list(tmp_path.iterdir())) == 4


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


@pytest.mark.parametrize(
    ("shape", "blocks", "slow"),
    [((100,), 1, 25), ((1000,), 1, 250), ((70_001,), 65, 17501), ((2, 70_001), 66, 35002)],
)
def test_as_many_cores_have_work_as_a_study_has_blocks(shape, blocks, slow):
    whole = study(shape)
    assert len(blocks_of(whole)) == blocks
    by_ivp = replace(whole, attributes=ATTRIBUTES | {"engine": "ivp"})
    assert len(blocks_of(by_ivp)) == slow


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


def test_permissions_are_those_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    write_study(study(), tmp_path / "a.h5")
    assert (tmp_path / "a.h5").stat().st_mode == (tmp_path / "plain").stat().st_mode
