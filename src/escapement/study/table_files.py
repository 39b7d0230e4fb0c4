"""A study as a table with a row for each case: CSV, or Parquet with pyarrow."""

import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from escapement.base import files, validate
from escapement.base.errors import CannotCreate, InputFileError, InvalidValue
from escapement.base.files import AnyPath
from escapement.base.text import csv_lines, words
from escapement.base.units import unit_name
from escapement.constant_speed.index_record import INDEX
from escapement.dynamics.figure_table import FIGURES
from escapement.study.block import Block, blocks_of, decode
from escapement.study.plan import unit_kind
from escapement.study.reader import check_same
from escapement.study.result import Study, count_failed, kept

CSV, PARQUET = ".csv", ".parquet"
_ROWS = 1 << 17  # rows in a row group of Parquet
# pandas stores its `attrs` under this name, and finds ours there.
_ATTRIBUTES = b"PANDAS_ATTRS"

Columns = dict[str, NDArray[Any]]


def is_table(path: AnyPath) -> bool:
    """Whether a file of this name is a table."""
    return Path(path).suffix.lower() in (CSV, PARQUET)


def check_format(path: AnyPath) -> str:
    """The suffix of the output of a study.

    Raises
    ------
    InvalidValue
        When it is not one of `files.STUDIES`.
    MissingPackage
        When it needs a package that is not installed.
    """
    suffix = files.file_format(path, files.STUDIES)
    if suffix == PARQUET:
        validate.package("pyarrow", f"output {path}")
    return suffix


def _columns(frame: Study, block: Block) -> Columns:
    """A block as columns: axes, sampled parameters, results."""
    start, stop = blocks_of(frame).span(block.number)
    chunks = zip(frame.results.items(), block.chunks, strict=True)
    results = {name: decode(data, result.dtype)[: stop - start] for (name, result), data in chunks}
    return frame.table(start, stop) | results


def _lines(frame: Study, blocks: Iterable[Block]) -> Iterator[bytes]:
    yield (",".join([*frame.axes, *frame.sampled, *frame.results]) + "\n").encode()
    for block in blocks:
        yield csv_lines(_columns(frame, block).values())


def write_csv(
    frame: Study, path: AnyPath, blocks: Iterable[Block], force: bool, temporary: Path | None
) -> None:
    """Write all blocks of a study, a header first; errors as `files.pending_file`."""
    files.write_file(path, _lines(frame, blocks), force, temporary)


def compare_csv(frame: Study, path: AnyPath, blocks: Iterable[Block]) -> None:
    """Raise CannotCreate unless a complete file holds these blocks."""
    with open(path, "rb") as file:
        if any(file.read(len(part)) != part for part in _lines(frame, blocks)) or file.read(1):
            raise CannotCreate(
                f"output {path} must be of this study to be resumed, got other numbers; name "
                "another output, or give force=True (--force) to replace it"
            )


def write_parquet(
    frame: Study, path: AnyPath, blocks: Iterable[Block], force: bool, temporary: Path | None
) -> None:
    """Write all blocks of a study; errors as `files.pending_file`."""
    import pyarrow
    from pyarrow import parquet

    about = json.dumps(frame.root | {"units": frame.units}).encode()
    kinds: dict[str, Any] = {name: values.dtype for name, values in frame.table(0, 1).items()}
    kinds |= {name: result.dtype for name, result in frame.results.items()}
    fields = [
        pyarrow.field(
            name,
            pyarrow.from_numpy_dtype(kind),
            metadata={"units": frame.units[name], "long_name": frame.long_names[name]},
        )
        for name, kind in kinds.items()
    ]
    schema = pyarrow.schema(fields, {_ATTRIBUTES: about})
    with files.pending_file(path, force, temporary) as handle:
        # unlike a plain file it always writes all its data
        disk = files.DeferredErrorFile(handle)
        with parquet.ParquetWriter(disk, schema, write_page_checksum=True) as writer:
            waiting: list[Any] = []
            for block in blocks:
                if disk.error is not None:
                    break
                waiting.append(pyarrow.record_batch(_columns(frame, block), schema))
                if sum(batch.num_rows for batch in waiting) >= _ROWS:
                    writer.write_table(pyarrow.Table.from_batches(waiting))
                    waiting = []
            writer.write_table(pyarrow.Table.from_batches(waiting, schema))
        if disk.error is not None:
            raise disk.error


def failed_rows(path: Path, frame: Study) -> int | None:
    """Like `reader.failed_cases`, for a table; None for CSV, which does not contain its study."""
    if path.suffix.lower() == CSV:
        return None
    from pyarrow import ArrowException, parquet

    with suppress(ArrowException, LookupError, ValueError):
        file = parquet.ParquetFile(path, page_checksum_verification=True)
        about = json.loads(file.schema_arrow.metadata[_ATTRIBUTES])
        check_same(path, json.loads(about["configuration"]), about, frame)
        status = [batch["status"].to_numpy() for batch in file.iter_batches()]
        found = np.concatenate(status)
        return count_failed(found) if found.size == frame.cases else None
    return None


def read_rows(path: AnyPath, cases: Sequence[int] | None = None) -> Columns:
    """Columns of a table, for some cases in ascending order or for all."""
    if Path(path).suffix.lower() == PARQUET:
        from pyarrow import dataset

        rows = dataset.dataset(path, format="parquet")
        table = rows.to_table() if cases is None else rows.take(cases)
        return {name: table[name].to_numpy() for name in table.column_names}
    with open(path, encoding="ascii") as file:
        names = next(file).strip().split(",")
        wanted = None if cases is None else set(cases)
        lines = (line for n, line in enumerate(file) if wanted is None or n in wanted)
        rows = chain([next(lines)], lines)  # `loadtxt` would only warn of a file without rows
        return dict(zip(names, np.loadtxt(rows, delimiter=",", ndmin=2).T, strict=True))


def read_table(path: AnyPath, system: str | None = None) -> Study:
    """The study of a table that `sweep` wrote.

    Parameters
    ----------
    path : path
        CSV or Parquet.
    system : str, optional
        System of units of a CSV table, which does not hold it.

    Raises
    ------
    InputFileError
        When it is not such a table.
    InvalidValue
        When a CSV table has no `system`.
    """
    try:
        columns, about = read_rows(path), _about(Path(path), system)
        names = kept(about["configuration"])
        given = [name for name in columns if name not in names]
        cut = given.index("case") + 1 if "case" in given else len(given)
        axes = {name: columns[name][np.sort(_firsts(columns[name]))] for name in given[:cut]}
        shape = tuple(values.size for values in axes.values())
        last = slice(axes[given[cut - 1]].size)
        return Study(
            axes=axes,
            results={n: columns[n].astype(x.dtype).reshape(shape) for n, x in names.items()},
            units=about["units"], long_names=about["long_names"],
            configuration=about["configuration"], attributes=about["attributes"],
            sampled={name: columns[name][last] for name in given[cut:]},
        )  # fmt: skip
    except (LookupError, ValueError, TypeError, StopIteration) as error:
        if isinstance(error, InvalidValue):
            raise
        raise InputFileError(
            f"file {path} must be a table that sweep wrote, got another one "
            f"({str(error) or 'no rows'}); sweep into an HDF5 file"
        ) from None


def _firsts(values: NDArray[Any]) -> NDArray[Any]:
    """Index of the first occurrence of each value."""
    return np.unique(values, return_index=True)[1]


def _about(path: Path, system: str | None) -> dict[str, Any]:
    """Configuration, units and descriptions of a table; of CSV those of its names."""
    if path.suffix.lower() == PARQUET:
        from pyarrow import parquet

        schema = parquet.read_schema(path)
        about: dict[str, Any] = json.loads(schema.metadata[_ATTRIBUTES])
        described = {one.name: one.metadata[b"long_name"].decode() for one in schema}
        configuration = json.loads(about["configuration"])
        about |= {"configuration": configuration, "attributes": {"title": about["title"]}}
        return about | {"long_names": described}
    if system is None:
        rule, remedy = "given for CSV, which does not hold them", "give --units of the study"
        raise validate.fail("units", rule, None, remedy)
    with open(path, encoding="ascii") as file:
        names = next(file).strip().split(",")
    results = [name for name in names if name in FIGURES | INDEX]
    drive = not {*results} <= {*FIGURES}
    configuration = {"units": system, "results": results, "title": path.stem}
    configuration |= {"study": "index"} if drive else {}
    declared = FIGURES | INDEX
    return {
        "configuration": configuration, "attributes": {"title": path.stem},
        "units": {name: unit_name(unit_kind(name), system) for name in names},
        "long_names": {
            name: declared[name].long_name if name in declared else words(name) for name in names
        },
    }  # fmt: skip
