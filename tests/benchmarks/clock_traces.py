"""How late a device and a receiver beside it were read on a loaded machine, recorded once.

A simulated device on a real pty and a simulated receiver on UDP, in a process of their own, were read by the
station's reader processes while as many processes burned the processor as a trace's ``load`` says. True time is
that of the device's own schedule.
"""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from tests.paths import ROOT

STORE = ROOT / "tests" / "data" / "clock_traces.npz"
UNITS = {"row_s": 1e4, "mark_s": 1e4, "step_s": 1e4, "row": 1e5, "mark": 1e5, "step": 1e5}  # kept as integers


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """One recording. True times [s] and by how much later each was stamped [s]: of rows (n,) and of marks (m,).

    ``step_s`` and ``step`` (k,) are when the simulated device, having fallen behind, began its schedule anew, and
    by how much later than before [s]. ``runnable`` is the mean number of processes that wanted a processor.
    """

    load: int
    is_killed: bool
    runnable: float
    row_s: FloatArray
    row: FloatArray
    mark_s: FloatArray
    mark: FloatArray
    step_s: FloatArray
    step: FloatArray


def read_traces(path: Path = STORE) -> list[Trace]:
    """Return the traces that a file holds."""
    with np.load(path) as held:
        count = len({name.split("_")[0] for name in held.files})
        return [
            _read_trace({field.name: held[f"{i}_{field.name}"] for field in fields(Trace)}) for i in range(count)
        ]


def _read_trace(held: dict[str, np.ndarray]) -> Trace:  # type: ignore[type-arg]
    whole = {name: held[name] / unit for name, unit in UNITS.items()}
    return Trace(int(held["load"]), bool(held["is_killed"]), float(held["runnable"]), **whole)
