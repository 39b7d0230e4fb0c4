"""The HDF5 file of a study, with dimension scales and attributes after netCDF-4 and CF."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from escapement.base import files
from escapement.base.files import AnyPath
from escapement.study.block import CELLS, Block, blocks_of
from escapement.study.result import Study

FILTERS: dict[str, Any] = {"compression": "gzip", "shuffle": True, "fletcher32": True}
"""Filters of every dataset that has chunks."""


def write_hdf5(
    frame: Study, path: AnyPath, blocks: Iterable[Block], force: bool, temporary: Path | None
) -> None:
    """Write all blocks of a study; errors as `files.pending_file`."""
    cut = blocks_of(frame)
    with files.pending_hdf5(path, force, temporary) as (hdf5, disk):
        results = create_datasets(hdf5, frame, cut.tile)
        for block in blocks:
            if disk.error is not None:
                break
            for dataset, data in zip(results, block.chunks, strict=True):
                dataset.id.write_direct_chunk(cut.offset(block.number), data)


def create_datasets(hdf5: Any, frame: Study, tile: tuple[int, ...]) -> list[Any]:
    """Write everything except the results; returns their datasets, which are empty."""
    hdf5.attrs.update(frame.root)
    for name, values in frame.axes.items():
        _create_line(hdf5, name, values).make_scale(name)
    for name, values in frame.sampled.items():
        _create_line(hdf5, name, values)
    for name, value in frame.fixed.items():
        hdf5.create_dataset(name, data=value, dtype="<i8" if isinstance(value, int) else "<f8")
    results = [
        hdf5.create_dataset(name, frame.shape, result.dtype, chunks=tile, **FILTERS)
        for name, result in frame.results.items()
    ]
    for dataset in results:
        # as the CF conventions prescribe
        dataset.attrs["coordinates"] = " ".join([*frame.sampled, *frame.fixed])
    for name, dataset in hdf5.items():
        along, attributes = frame.described(name)
        dataset.attrs.update(attributes)
        if name not in frame.axes:
            for dimension, axis in zip(dataset.dims, along, strict=True):
                dimension.attach_scale(hdf5[axis])
    return results


def _create_line(hdf5: Any, name: str, values: Any) -> Any:
    kind = "<i8" if values.dtype.kind == "i" else "<f8"
    return hdf5.create_dataset(
        name, data=values, dtype=kind, chunks=(min(values.size, CELLS),), **FILTERS
    )
