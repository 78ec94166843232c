"""A layout for Foxglove: specific force, angular rate, temperature and flags of ``/imu/calibrated``.

It has the form in which Foxglove imports and exports layouts: each panel's settings by its name, a tree of splits.
"""

import json
from pathlib import Path
from typing import Any

from station.files.atomic_file import replace_file
from station.files.mcap_files.calibrated_sample import COLUMNS, TOPIC

COLOURS = ("#d62728", "#2ca02c", "#1f77b4")  # x, y, z
FORCE, RATE, TEMPERATURE, FLAGS, MESSAGE = (
    "Plot!force", "Plot!rate", "Plot!temperature", "StateTransitions!flags", "RawMessages!sample",
)  # fmt: skip


def write_layout(file: Path) -> None:
    """Write the layout; raise `CannotWrite` if that is refused."""
    replace_file(file, (json.dumps(layout(), indent=1) + "\n").encode())


def layout() -> dict[str, Any]:
    """Return the layout as Foxglove's JSON."""
    panels = {
        FORCE: _plot("Specific force [m/s2]", COLUMNS[:3]),
        RATE: _plot("Angular rate [rad/s]", COLUMNS[3:]),
        TEMPERATURE: _plot("Temperature [degC]", ("temperature_c",)),
        FLAGS: {"isSynced": True, "paths": [{"value": f"{TOPIC}.flags", "timestampMethod": "receiveTime"}]},
        MESSAGE: {"topicPath": TOPIC},
    }
    below = _split("row", TEMPERATURE, _split("row", FLAGS, MESSAGE, 55), 40)
    return {
        "configById": panels, "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1},
        "layout": _split("column", FORCE, _split("column", RATE, below, 55), 38),
    }  # fmt: skip


def _plot(title: str, fields: tuple[str, ...]) -> dict[str, Any]:
    paths = [
        {"value": f"{TOPIC}.{field}", "enabled": True, "timestampMethod": "receiveTime", "color": colour}
        for field, colour in zip(fields, COLOURS, strict=False)
    ]
    return {
        "title": title, "paths": paths, "isSynced": True, "xAxisVal": "timestamp", "followingViewWidth": 20,
        "showLegend": True, "legendDisplay": "floating", "showXAxisLabels": True, "showYAxisLabels": True,
        "showPlotValuesInLegend": True,
    }  # fmt: skip


def _split(direction: str, first: Any, second: Any, percentage: float) -> dict[str, Any]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percentage}
