"""Results held to stored ones, to 1e-6: `docs/station-tests.md` says when they may be written anew, and how.

A result is taken apart to its numbers. What stands in a list of like things, or a long one, is one column; of a
column of more than `MOST` numbers are kept its length, its RMS and two means weighted by fixed cosines, which no
single number leaves as they are.
"""

import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray

RELATIVE, OF_COLUMN = 1e-6, 1e-9  # of the number; of the largest one of its column: rounding
MOST, DIGITS = 12, 10
HERE = Path(__file__).parent
Columns = dict[str, list[Any]]


def assert_held(area: str, name: str, found: object, without: Sequence[str] = ()) -> None:
    """Compare a result with ``name`` of ``area``.json; ``without`` are ends of paths that are not held."""
    left_out = tuple(without)
    columns = {path: kept(values) for path, values in columns_of(found).items() if not path.endswith(left_out)}
    file = HERE / f"{area}.json"
    stored = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    if os.environ.get("SNAPSHOTS") == "new":
        stored = dict(sorted((stored | {name: columns}).items()))
        file.write_text(written(stored), encoding="utf-8")
    assert name in stored, f"{file.name} has no {name}; write it by SNAPSHOTS=new"
    different = list(differences(columns, stored[name]))
    assert not different, f"{name}: {len(different)} of {len(columns)} differ\n" + "\n".join(different[:10])


def written(stored: Mapping[str, Mapping[str, Any]]) -> str:
    """Return results as JSON, a column a line."""
    results = list[str]()
    for name, columns in stored.items():
        lines = ",\n".join(f"  {json.dumps(path)}: {json.dumps(values)}" for path, values in columns.items())
        results.append(f"{json.dumps(name)}: {{\n{lines}\n}}")
    return "{\n" + ",\n".join(results) + "\n}\n"


def columns_of(found: object) -> Columns:
    """Return the numbers and names of a result by their path without indices; sentences are left out."""
    columns: Columns = {}
    for path, values in _leaves(found, ""):
        columns.setdefault(path, []).extend(values)
    return columns


def _leaves(value: Any, path: str) -> Iterator[tuple[str, list[Any]]]:
    if isinstance(value, Enum):
        value = value.name
    if is_dataclass(value) and not isinstance(value, type):
        value = {each.name: getattr(value, each.name) for each in fields(value) if not each.name.startswith("_")}
    if isinstance(value, Mapping):
        for key, each in value.items():
            yield from _leaves(each, f"{path}.{key}")
    elif isinstance(value, np.ndarray) and value.ndim == 2 and value.shape[1] <= MOST:
        for i, column in enumerate(value.T):
            yield from _leaves(column, f"{path}.{i}")
    elif isinstance(value, np.ndarray) and value.size and value.dtype.kind in "biuf":
        yield path, value.ravel().tolist()
    elif isinstance(value, np.ndarray):
        yield from _leaves(value.ravel().tolist(), path)
    elif isinstance(value, list | tuple | set | frozenset):
        several = sorted(value, key=repr) if isinstance(value, set | frozenset) else value
        are_alike = len(several) > MOST or len({_kind(each) for each in several}) <= 1
        for i, each in enumerate(several):
            yield from _leaves(each, path if are_alike else f"{path}[{i}]")
    elif isinstance(value, bytes):
        yield path, [value.hex() if len(value) <= MOST else _digest(value)]
    elif isinstance(value, np.generic):
        yield path, [value.item()]
    elif value is None or isinstance(value, bool | int | float) or (isinstance(value, str) and " " not in value):
        yield path, [value]


def _kind(value: object) -> object:
    return "number" if value is None or isinstance(value, int | float | np.generic) else type(value)


def kept(values: list[Any]) -> list[Any]:
    """Return a column, or what stands for it: "n=", RMS, and sums weighted by cosines; nan as text."""
    if len(values) > MOST:
        numbers = np.array(
            [each for each in values if isinstance(each, int | float) and math.isfinite(each)], float
        )
        words = [each for each in values if isinstance(each, str)]
        of_words = [_digest("|".join(words).encode())] if words else []
        values = [f"n={len(values)},{len(numbers)}", *_sums(numbers), *of_words]
    return [_rounded(each) for each in values]


def _sums(numbers: FloatArray) -> list[float]:
    if not len(numbers):
        return []
    place = np.arange(1.0, len(numbers) + 1)
    weighted = [float(np.mean(numbers * weight)) for weight in (np.cos(place), np.cos(place**2))]
    return [float(np.sqrt(np.mean(numbers**2))), *weighted]


def _digest(value: bytes) -> str:
    return hashlib.sha256(value).hexdigest()[:16]


def _rounded(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else str(value)


def differences(found: Mapping[str, list[Any]], stored: Mapping[str, list[Any]]) -> Iterator[str]:
    """Yield what differs, a line each; what a result says beyond what is stored is not compared."""
    for path, expected in stored.items():
        if len(now := found.get(path, [])) != len(expected) or not _same(now, expected):
            yield f"{path}: found {now}, expected {expected}"


def _same(found: list[Any], stored: list[Any]) -> bool:
    numbers = [abs(each) for each in stored if isinstance(each, float)]
    floor = OF_COLUMN * max(numbers, default=0.0)
    return all(
        abs(a - b) <= RELATIVE * abs(b) + floor if isinstance(a, float) and isinstance(b, float | int) else a == b
        for a, b in zip(found, stored, strict=True)
    )
