"""A step's MCAP file in memory, as arrays."""

from dataclasses import dataclass, field
from itertools import chain
from operator import attrgetter
from typing import Any

import numpy as np

from procedures.arrays import FloatArray, IntArray
from station.files.mcap_files.schemas import COUNTS

_SCALARS = attrgetter("device_ns", "host_ns", "counter", "status", "temperature_c")


@dataclass(frozen=True, slots=True, eq=False)
class StepContents:
    """All messages of a step; every array has a row per sample.

    ``device_ns``, ``host_ns`` (n,) ns; ``gyro``, ``accel`` (n, 3) int64 counts (``output`` is
    ``station.Counts``) or float64, None where the triad is absent; ``temperature`` (n,) degC or nan; ``counter``,
    ``status`` (n,) as sent; ``aux`` (n,) by name, nan where a sample lacks it; ``raw`` the bytes as read with
    their time [ns]. ``damage`` says what is wrong with the end of the file, None if nothing is.
    """

    output: str
    device_ns: IntArray
    host_ns: IntArray
    gyro: IntArray | FloatArray | None
    accel: IntArray | FloatArray | None
    temperature: FloatArray
    counter: IntArray
    status: IntArray
    aux: dict[str, FloatArray]
    raw: tuple[tuple[int, bytes], ...]
    sha256: str
    damage: str | None = field(default=None)

    def __len__(self) -> int:
        return len(self.device_ns)


def step_contents(
    output: str, samples: list[Any], raw: tuple[tuple[int, bytes], ...], sha256: str, damage: str | None
) -> StepContents:
    """Return protobuf samples as arrays; raises ValueError where a triad is neither whole nor absent."""
    maps = [s.aux for s in samples]
    names = sorted({name for values in maps for name in values})
    aux = {name: np.array([values.get(name, np.nan) for values in maps]) for name in names}
    columns = list(zip(*map(_SCALARS, samples), strict=True)) or [()] * 5
    device_ns, host_ns, counter, status = (np.array(column, dtype=np.int64) for column in columns[:4])
    kind = np.int64 if output == COUNTS else np.float64
    return StepContents(
        output,
        device_ns,
        host_ns,
        _triad(samples, "gyro", kind),
        _triad(samples, "accel", kind),
        np.array(columns[4], dtype=np.float64),
        counter,
        status,
        aux,
        raw,
        sha256,
        damage,
    )


def _triad(samples: list[Any], name: str, kind: type) -> Any:
    values = [getattr(sample, name) for sample in samples]
    lengths = set(map(len, values))
    if lengths - {0}:
        if lengths != {3}:
            raise ValueError(f"messages with {', '.join(map(str, sorted(lengths)))} values of {name}, not 3")
        return np.array(list(chain.from_iterable(values)), dtype=kind).reshape(-1, 3)
    return None
