"""Tables in binary files: ``.npz``, ``.npy`` and ``.mat``, ``.parquet`` and ``.feather`` (Arrow).

Of arrays, a vector is a column and a matrix ``acc`` becomes ``acc:1``, ``acc:2``, ... Arrays of numpy are read
some rows at a time, as their bytes stand in the file; those of MATLAB as a whole; Arrow's columns batch by batch.
"""

import contextlib
import re
import zipfile
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.table import (
    BLOCK_ROWS,
    DAMAGE,
    DAMAGED_WITHIN,
    HEAD_ROWS,
    Block,
    Table,
    TableReader,
    in_a_line,
    seconds_of,
    undamaged,
)
from station.files.tables.text_table import open_text

READ_BYTES = 2**20
MAX_COLUMNS = 1000  # of one matrix
MAT_HEAD_BYTES = 512
MAX_DEPTH = 4  # of structures in structures
_TEXT = re.compile(rb"[\t\r\n -~]+")
_Cursor = Callable[[int], Any]  # returns the next rows of an array, as many as asked for


@dataclass(frozen=True, slots=True, eq=False)
class _Array:
    """An array of ``rows``; ``opened`` gives a cursor at its first."""

    rows: int
    opened: Callable[[], contextlib.AbstractContextManager[_Cursor]]


def open_npz(file: Path) -> TableReader:
    """Open a ``.npz`` or ``.npy``; raise `DataRefused` where it is none or holds no numbers.

    No pickled object is opened: that would run its code.
    """
    try:
        members = {"data": ""}  # of a single array, also by another name
        if zipfile.is_zipfile(file):
            with zipfile.ZipFile(file) as archive:
                members = {n.removesuffix(".npy"): n for n in archive.namelist() if n.endswith(".npy")}
        arrays, objects = dict[str, _Array](), list[str]()
        for name, member in members.items():
            with _stream(file, member) as stream:
                shape, is_fortran, dtype = _header(stream)
                if dtype.hasobject:
                    objects.append(name)
                elif not _holds_numbers(dtype) or len(shape) not in {1, 2} or not all(shape):
                    continue
                elif len(shape) == 2 and (is_fortran or shape[0] < shape[1]):  # by channels: it cannot be cut
                    with _stream(file, member) as again:
                        arrays[name] = _held(np.lib.format.read_array(again, allow_pickle=False))
                else:
                    arrays[name] = _streamed(file, member, dtype, shape)
        notes = (f"{', '.join(objects)} of Python objects: not used",) if objects else ()
        return _reader(file, arrays, list(members), notes)
    except DataRefused:
        raise
    except DAMAGE as error:
        raise DataRefused(
            file, None, f"no readable arrays ({in_a_line(error)})", "a .npz of numbers", code=ErrorCode.TABLE
        ) from None


def open_mat(file: Path) -> TableReader:
    """Open a ``.mat`` of MATLAB up to version 7, or a table of text that is called so, as imu_tk's are.

    Fields of structures are named ``imu.acc``. Raise `DataRefused` if it is neither, is of version 7.3 or holds no
    numbers.
    """
    with file.open("rb") as stream:
        head = stream.read(MAT_HEAD_BYTES)
    if _TEXT.fullmatch(head) and re.search(rb"[0-9]", head) and not head.startswith(b"MATLAB"):
        return open_text(file)
    from scipy.io import loadmat  # heavy: only where a log is a .mat

    try:
        found = loadmat(file, simplify_cells=True)
    except NotImplementedError:
        remedy = "save it again with save(..., '-v7')"
        raise DataRefused(file, None, "version 7.3 (HDF5)", "a .mat of version 7 or older", remedy) from None
    except OSError:
        raise
    except Exception as error:  # scipy raises of many kinds on damaged files
        raise DataRefused(
            file, None, f"no readable variables ({error})", "a .mat of MATLAB", code=ErrorCode.TABLE
        ) from None
    named = {name: value for name, value in found.items() if not name.startswith("__")}
    return open_arrays(dict(_flat("", named, MAX_DEPTH)), file)


def open_arrays(arrays: Mapping[str, Any], file: Path) -> TableReader:
    """Return arrays in memory as a table; raise `DataRefused` where none has two rows of numbers or more."""
    every = {name: np.asarray(array) for name, array in arrays.items()}
    usable = {name: each for name, each in every.items()
              if each.ndim in {1, 2} and each.size and _holds_numbers(each.dtype)}  # fmt: skip
    return _reader(file, {name: _held(each) for name, each in usable.items()}, list(arrays), ())


def _flat(path: str, values: Mapping[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping) and depth:
            yield from _flat(f"{path}{name}.", value, depth - 1)
        elif isinstance(value, np.ndarray):
            yield f"{path}{name}", value


def _reader(file: Path, arrays: Mapping[str, _Array], held: Sequence[str], notes: tuple[str, ...]) -> TableReader:
    """Return the columns of all arrays that have as many rows as the longest; others are not used."""
    rows = max((each.rows for each in arrays.values()), default=0)
    heads = dict[str, Any]()
    for name, each in arrays.items():
        if each.rows == rows:
            with each.opened() as take:
                heads[name] = take(min(HEAD_ROWS, rows))
    columns = {name: _columns(name, head) for name, head in heads.items()}
    source = {column: name for name, own in columns.items() for column in own}
    if rows < 2 or not source:
        found = ", ".join(held) or "nothing"
        raise DataRefused(
            file, None, found, "arrays of numbers with a row a sample", "save them so", code=ErrorCode.TABLE
        )
    moments = frozenset(column for column, name in source.items() if heads[name].dtype.kind in "mM")
    named = {column: values for own in columns.values() for column, values in own.items()}

    def read(wanted: Sequence[str]) -> Generator[Block]:
        with contextlib.ExitStack() as stack:
            takes = {
                name: stack.enter_context(arrays[name].opened()) for name in {source[each] for each in wanted}
            }
            for begin in range(0, rows, BLOCK_ROWS):
                count = min(BLOCK_ROWS, rows - begin)
                found = dict[str, FloatArray]()
                for name, take in takes.items():
                    found |= _columns(name, take(count))
                lines = range(begin + 1, begin + count + 1)
                yield Block({each: found[each] for each in wanted}, (begin + count) / rows, lines)

    return TableReader(
        Table(file, named, notes=notes, moments=moments), lambda wanted: undamaged(read(wanted), file)
    )


def _holds_numbers(dtype: "np.dtype[Any]") -> bool:
    if dtype.names:
        return any(_holds_numbers(dtype[name]) for name in dtype.names)
    return dtype.base.kind in "buifmM"


def _columns(name: str, array: Any) -> dict[str, FloatArray]:
    """Return the columns of an array's rows; none of what holds no numbers, the fields of a structure by name."""
    if fields := array.dtype.names:
        return {key: each for field in fields for key, each in _columns(f"{name}.{field}", array[field]).items()}
    if array.dtype.kind not in "buifmM" or array.ndim > 2:
        return {}
    matrix = seconds_of(array).reshape(len(array), -1)
    if matrix.shape[1] == 1:
        return {name: matrix[:, 0]}
    if matrix.shape[1] > MAX_COLUMNS:
        return {}
    return {f"{name}:{j + 1}": np.ascontiguousarray(matrix[:, j]) for j in range(matrix.shape[1])}


def _held(array: Any) -> _Array:
    """Return an array in memory; one with a row a channel, as many tools write, is turned."""
    upright = array.T if array.ndim == 2 and array.shape[1] > array.shape[0] else array

    @contextlib.contextmanager
    def opened() -> Iterator[_Cursor]:
        at = 0

        def take(count: int) -> Any:
            nonlocal at
            at += count
            return upright[at - count : at]

        yield take

    return _Array(len(upright), opened)


def _streamed(file: Path, member: str, dtype: "np.dtype[Any]", shape: tuple[int, ...]) -> _Array:
    """Return an array of a file, whose rows are read as they are asked for."""
    width = int(np.prod(shape[1:]))

    @contextlib.contextmanager
    def opened() -> Iterator[_Cursor]:
        with _stream(file, member) as stream:
            _header(stream)

            def take(count: int) -> Any:
                found = np.frombuffer(_exactly(stream, count * width * dtype.itemsize, file), dtype)
                return found.reshape(count, width) if width > 1 else found

            yield take

    return _Array(shape[0], opened)


def _exactly(stream: IO[bytes], size: int, file: Path) -> bytes:
    parts = list[bytes]()
    while size:
        if not (part := stream.read(min(size, READ_BYTES))):
            raise DataRefused(
                file, None, "an array that is cut short", "a whole file", "copy it again", code=ErrorCode.TABLE
            )
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


@contextlib.contextmanager
def _stream(file: Path, member: str) -> Iterator[IO[bytes]]:
    if not member:
        with file.open("rb") as plain:
            yield plain
        return
    with zipfile.ZipFile(file) as archive, archive.open(member) as inside:
        yield inside


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, "np.dtype[Any]"]:
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        return np.lib.format.read_array_header_1_0(stream)
    return np.lib.format.read_array_header_2_0(stream)


PAGE_BYTES = 2**16  # read at a time of each column, in place of a whole row group
_Batches = Callable[[Path, Sequence[str] | None, int], Iterator[tuple[Any, float]]]


def open_parquet(file: Path) -> TableReader:
    """Open a ``.parquet``; raise `DataRefused` where it is none or holds no numbers."""
    return _opened(file, _parquet_batches, "a .parquet")


def open_feather(file: Path) -> TableReader:
    """Open a ``.feather`` of version 2; raise `DataRefused` where it is none or holds no numbers."""
    return _opened(file, _feather_batches, "a .feather of version 2")


def _parquet_batches(file: Path, names: Sequence[str] | None, rows: int) -> Iterator[tuple[Any, float]]:
    """Yield batches, and how much of the file has been read with each."""
    from pyarrow import parquet

    done = 0
    with parquet.ParquetFile(file, buffer_size=PAGE_BYTES, pre_buffer=False) as opened:
        total = max(opened.metadata.num_rows, 1)
        for batch in opened.iter_batches(rows, columns=names, use_threads=False):
            done += batch.num_rows
            yield batch, done / total


def _feather_batches(file: Path, names: Sequence[str] | None, rows: int) -> Iterator[tuple[Any, float]]:
    """Yield batches, and how much of the file has been read with each."""
    import pyarrow

    with pyarrow.memory_map(str(file)) as mapped, pyarrow.ipc.open_file(mapped) as opened:
        for i in range(opened.num_record_batches):
            batch = opened.get_batch(i)
            for begin in range(0, batch.num_rows, rows):
                part = batch.slice(begin, rows)
                share = min(begin + rows, batch.num_rows) / batch.num_rows
                yield part if names is None else part.select(names), (i + share) / opened.num_record_batches


def _opened(file: Path, batches: _Batches, expected: str) -> TableReader:
    try:
        first, _ = next(batches(file, None, HEAD_ROWS), (None, 0))
        columns, moments = _numbers_of(first)
    except FileNotFoundError:
        raise
    except DAMAGED_WITHIN as error:  # pyarrow's own are of these kinds
        raise DataRefused(
            file, None, f"no readable table ({in_a_line(error)})", expected, code=ErrorCode.TABLE
        ) from None
    if not columns:
        raise DataRefused(
            file, None, "no column of numbers", "columns of numbers, a row a sample", code=ErrorCode.COLUMNS
        )

    def read(wanted: Sequence[str]) -> Generator[Block]:
        before = 0
        for batch, done in batches(file, list(wanted), BLOCK_ROWS):
            lines = range(before + 1, before + batch.num_rows + 1)
            before += batch.num_rows
            yield Block({name: _numbers(batch.column(name)) for name in wanted}, done, lines)

    head = Table(file, columns, moments=frozenset(moments))
    return TableReader(head, lambda wanted: undamaged(read(wanted), file))


def _numbers_of(batch: Any) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the first rows by column, of those that hold numbers, and which of them are moments."""
    columns, moments = dict[str, FloatArray](), list[str]()
    if batch is not None and batch.num_rows > 1:
        for name, column in zip(batch.schema.names, batch.columns, strict=True):
            if (values := _values(column)) is not None:
                columns[name] = seconds_of(values)
                moments += [name] if values.dtype.kind in "mM" else []
    return columns, moments


def _numbers(column: Any) -> FloatArray:
    found = _values(column)
    return np.full(len(column), np.nan) if found is None else seconds_of(found)


def _values(column: Any) -> Any:
    """Return a column as numpy's numbers, moments or spans of time (n,), None if it holds none.

    Decimals are numbers, times of the day spans of time since midnight.
    """
    from pyarrow import duration, float64, int64, types

    if types.is_decimal(column.type):
        column = column.cast(float64())
    elif types.is_time32(column.type):
        column = column.cast("time64[us]")
    if types.is_time64(column.type):
        column = column.cast(int64()).cast(duration(column.type.unit))
    values = column.to_numpy(zero_copy_only=False)
    return values if values.dtype.kind in "buifmM" else None
