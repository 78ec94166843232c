"""`stored_result`: a whole result as a YAML file next to the test, compared within a tolerance.

Written again by ``pytest tests/stored --force-regen`` after a change that is meant to move these numbers.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pydantic import BaseModel
from pytest_datadir.plugin import LazyDataDir
from pytest_regressions.common import perform_regression_check
from pytest_regressions.data_regression import RegressionYamlDumper

RELATIVE, OF_LARGEST = 1e-5, 1e-8  # of the number; of the largest number of its list
OF_PROBABILITY = 1e-9  # absolute: less is what rounding leaves of 1 - p
PROBABILITIES = {"share", "shares", "probability", "probabilities"}
DIGITS = 8
LONG = (
    12  # of a longer list of numbers: how many, RMS, and two means with weights that no single change leaves alone
)


@dataclass(frozen=True)
class StoredResult:
    """Compares results with the file of a name, or of the test's own name."""

    folder: LazyDataDir
    source: Path
    request: pytest.FixtureRequest

    def check(self, result: object, name: str | None = None, without: Iterable[str] = ()) -> None:
        """Compare; ``without`` are names of fields that rounding alone determines."""
        now = _plain(result, frozenset(without))

        def dump(file: Path) -> None:
            text = yaml.dump(now, Dumper=RegressionYamlDumper, default_flow_style=None, width=115, sort_keys=False)
            file.write_text(text, encoding="utf-8")

        def compare(obtained: Path, expected: Path) -> None:
            found, stored = (yaml.safe_load(file.read_text(encoding="utf-8")) for file in (obtained, expected))
            different = list(_differences(found, stored, ""))
            assert not different, f"{expected.name}: {len(different)} differ\n" + "\n".join(different[:12])

        perform_regression_check(self.folder, self.source, self.request, compare, dump, ".yml", name)


@pytest.fixture
def stored_result(
    lazy_datadir: LazyDataDir, original_datadir: Path, request: pytest.FixtureRequest
) -> StoredResult:
    return StoredResult(lazy_datadir, original_datadir, request)


def _plain(value: Any, without: frozenset[str]) -> Any:
    """Return numbers and names of a result; sentences are omitted."""
    if isinstance(value, Enum):
        return value.name
    if is_dataclass(value) and not isinstance(value, type):
        value = {each.name: getattr(value, each.name) for each in fields(value) if not each.name.startswith("_")}
    if isinstance(value, BaseModel):
        value = value.model_dump()
    if isinstance(value, Mapping):
        kept = {str(key): each for key, each in value.items() if key not in without and not _is_sentence(each)}
        return {key: _plain(each, without) for key, each in kept.items()}
    if isinstance(value, bytes):
        return f"{len(value)} bytes {sha256(value).hexdigest()[:16]}"
    if isinstance(value, set | frozenset):
        value = sorted(value, key=str)
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        return _of_array(value)
    if isinstance(value, np.ndarray | list | tuple):
        return _of_list([each for each in value if not _is_sentence(each)], without)
    if isinstance(value, np.generic):
        value = value.item()
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def _of_array(value: np.ndarray) -> Any:
    if value.ndim == 2 and len(value) > LONG and value.shape[1] <= LONG:
        return [_of_array(column) for column in value.T]
    if value.size <= LONG:
        return _plain(value.tolist(), frozenset())
    numbers = value.ravel().astype(float)
    here = np.isfinite(numbers)
    numbers, place = numbers[here], np.arange(1.0, 1 + len(here))[here]
    rms = np.sqrt(np.mean(numbers**2)) if len(numbers) else 0.0
    means = [np.mean(numbers * weight) if len(numbers) else 0.0 for weight in (np.cos(place), np.cos(place**2))]
    return {"count": len(here), "finite": len(numbers), "rms_and_means": _plain([rms, *means], frozenset())}


def _of_list(value: list[Any], without: frozenset[str]) -> Any:
    kinds = {type(each) for each in value}
    if len(value) <= LONG or len(kinds) > 1:
        return [_plain(each, without) for each in value]
    if all(issubclass(kind, bool | int | float | np.number) for kind in kinds):
        return _of_array(np.array(value))
    if kinds == {str}:
        return f"{len(value)} texts {sha256(' '.join(value).encode()).hexdigest()[:16]}"
    if is_dataclass(value[0]):
        names = [each.name for each in fields(value[0]) if not each.name.startswith("_")]
        return {
            name: _of_list([getattr(each, name) for each in value], without)
            for name in names
            if name not in without
        }
    if kinds == {np.ndarray} and len({each.shape[1:] for each in value}) == 1:
        return _of_array(np.concatenate(value))
    return [_plain(each, without) for each in value]


def _is_sentence(value: object) -> bool:
    return isinstance(value, str) and " " in value


def _differences(found: Any, stored: Any, path: str, floor: float = 0.0) -> Iterable[str]:
    if isinstance(found, dict) and isinstance(stored, dict) and found.keys() == stored.keys():
        for key in stored:
            least = OF_PROBABILITY if key in PROBABILITIES else floor
            yield from _differences(found[key], stored[key], f"{path}.{key}", least)
    elif isinstance(found, list) and isinstance(stored, list) and len(found) == len(stored):
        floats = [abs(each) for each in stored if isinstance(each, float) and np.isfinite(each)]
        least = max(floor, OF_LARGEST * max(floats, default=0.0))
        for i, (now, then) in enumerate(zip(found, stored, strict=True)):
            yield from _differences(now, then, f"{path}[{i}]", least)
    elif not _close(found, stored, floor):
        yield f"{path}: found {found}, stored {stored}"


def _close(found: Any, stored: Any, floor: float) -> bool:
    if isinstance(found, float) and isinstance(stored, float):
        return bool(found == pytest.approx(stored, rel=RELATIVE, abs=max(floor, 1e-300), nan_ok=True))
    return bool(found == stored)
