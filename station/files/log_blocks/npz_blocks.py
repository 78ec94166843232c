"""``.npz`` and ``.npy`` block by block: some rows of each array at a time, as their bytes stand in the file."""

import contextlib
import zipfile
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.log_blocks.log_blocks import BLOCK_ROWS, HEAD_ROWS, Block, LogBlocks, undamaged
from station.files.logs.array_columns import MAX_COLUMNS, seconds_of
from station.files.logs.damage import DAMAGE, in_a_line
from station.files.logs.log_table import LogTable

READ_BYTES = 2**20


def npz_blocks(file: Path) -> LogBlocks:
    """Open an archive of arrays; no pickled object is opened."""
    if not zipfile.is_zipfile(file):
        return npy_blocks(file)
    try:
        with zipfile.ZipFile(file) as archive:
            names = [name for name in archive.namelist() if name.endswith(".npy")]
    except DAMAGE as error:
        raise DataRefused(
            file, None, f"no readable archive ({in_a_line(error)})", "a .npz of numbers", code=ErrorCode.TABLE
        ) from None
    return _opened(file, {name.removesuffix(".npy"): name for name in names})


def npy_blocks(file: Path) -> LogBlocks:
    """Open a single array."""
    return _opened(file, {"data": ""})


@dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """An array's bytes: rows of ``dtype``, ``width`` of them a row; ``rows`` of all."""

    dtype: "np.dtype[Any]"
    width: int
    rows: int


def _opened(file: Path, members: Mapping[str, str]) -> LogBlocks:
    try:
        layouts, whole = dict[str, _Layout](), dict[str, Any]()
        for name, member in members.items():
            with _stream(file, member) as stream:
                shape, is_fortran, dtype = _header(stream)
                if dtype.hasobject:
                    continue
                by_rows = len(shape) == 1 or (len(shape) == 2 and shape[0] >= shape[1] and not is_fortran)
                if by_rows and all(shape):
                    layouts[name] = _Layout(dtype, int(np.prod(shape[1:])), shape[0])
            if name not in layouts and len(shape) == 2:  # a row a channel: it cannot be cut
                whole[name] = _whole(file, member)
        sizes = [layout.rows for layout in layouts.values()] + [max(each.shape) for each in whole.values()]
        rows = max(sizes, default=0)
        heads = {name: _rows(file, members[name], each, HEAD_ROWS) for name, each in layouts.items()
                 if each.rows == rows}  # fmt: skip
        heads |= {name: _upright(each)[:HEAD_ROWS] for name, each in whole.items() if max(each.shape) == rows}
    except DataRefused:
        raise
    except DAMAGE as error:
        raise DataRefused(
            file, None, f"no readable arrays ({in_a_line(error)})", "a .npz of numbers", code=ErrorCode.TABLE
        ) from None
    columns = {name: _columns(name, head) for name, head in heads.items()}
    source = {column: name for name, own in columns.items() for column in own}
    if rows < 2 or not source:
        held = ", ".join(members) or "nothing"
        raise DataRefused(
            file, None, held, "arrays of numbers with a row a sample", "save them so", code=ErrorCode.TABLE
        )
    moments = frozenset(column for column, name in source.items() if heads[name].dtype.kind in "mM")
    named = {column: values for own in columns.values() for column, values in own.items()}
    head = LogTable(file, named, "", moments=moments)

    def read(wanted: Sequence[str]) -> Generator[Block]:
        used = {source[each] for each in wanted}
        with contextlib.ExitStack() as stack:
            streams = dict[str, IO[bytes]]()
            for name in used - set(whole):
                streams[name] = stack.enter_context(_stream(file, members[name]))
                _header(streams[name])
            for begin in range(0, rows, BLOCK_ROWS):
                count = min(BLOCK_ROWS, rows - begin)
                columns = dict[str, FloatArray]()
                for name in used:
                    part = (
                        _upright(whole[name])[begin : begin + count] if name in whole
                        else _read(streams[name], layouts[name], count, file)
                    )  # fmt: skip
                    columns |= _columns(name, part)
                yield Block({each: columns[each] for each in wanted}, (begin + count) / rows)

    return LogBlocks(head, lambda wanted: undamaged(read(wanted), file))


def _columns(name: str, array: Any) -> dict[str, FloatArray]:
    """Return an array's columns, named as `array_columns` does; none of one that holds no numbers."""
    if fields := array.dtype.names:
        return {key: each for field in fields for key, each in _columns(f"{name}.{field}", array[field]).items()}
    if array.dtype.kind not in "buifmM" or array.ndim > 2:
        return {}
    matrix = seconds_of(array).astype(np.float64).reshape(len(array), -1)
    if matrix.shape[1] == 1:
        return {name: matrix[:, 0]}
    return {
        f"{name}:{j + 1}": np.ascontiguousarray(matrix[:, j]) for j in range(min(matrix.shape[1], MAX_COLUMNS))
    }


def _whole(file: Path, member: str) -> Any:
    with _stream(file, member) as stream:
        return np.lib.format.read_array(stream, allow_pickle=False)


def _upright(array: Any) -> Any:
    return array if array.shape[0] >= array.shape[1] else array.T


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


def _rows(file: Path, member: str, layout: _Layout, count: int) -> Any:
    with _stream(file, member) as stream:
        _header(stream)
        return _read(stream, layout, min(count, layout.rows), file)


def _read(stream: IO[bytes], layout: _Layout, count: int, file: Path) -> Any:
    left, parts = count * layout.width * layout.dtype.itemsize, list[bytes]()
    while left:
        if not (part := stream.read(min(left, READ_BYTES))):
            raise DataRefused(
                file, None, "an array that is cut short", "a whole file", "copy it again", code=ErrorCode.TABLE
            )
        parts.append(part)
        left -= len(part)
    found = np.frombuffer(b"".join(parts), layout.dtype)
    return found.reshape(count, layout.width) if layout.width > 1 else found
