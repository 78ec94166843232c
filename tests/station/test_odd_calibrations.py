"""Every key of calibration/1 with something odd in it: applied, exported and streamed, or refused in one line."""

import copy
import hashlib
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station.applying.applying import OutputRequest, Progress, apply_to
from station.applying.open_source import open_source
from station.calibrated.calibration_choice import chosen_calibration
from station.calibration import load
from station.errors import DataRefused
from station.exports import EXPORTS, Request
from station.files.calibration_document import parsed_calibration
from station.files.logs.log_columns import ColumnOptions
from station.sending.to_stdout import lines
from tests.station.exports.every_effect import EFFECTS
from tests.station.monitor.unit import calibration_of
from tests.station.sending.rig import UNIT, LiveRig

UNREAD = ("inputs", "reference_temperature_c", "operator", "verdict", "limits")
TERM = (
    'format = "effect/1"\nname = "own"\ntriad = "gyroscope"\nterm = "lag(T, tau) * u / w"\nunit = "1/K"\n'
    'plausible = 1\nsource = "x"\nshape.w = {unit = "deg/s", low = 1, high = 1e3}\n'
    'shape.tau = {unit = "min", low = 1, high = 60}\n'
)
OWN = {
    "name": "gyroscope.own", "unit": "1/K", "term": ["lag(T, tau) * u / w"], "definition": TERM,
    "units": {"w": "deg/s", "tau": "min"}, "reference": {"temperature_c": 25.0},
    "sha256": hashlib.sha256(TERM.encode()).hexdigest(),
    "coefficients": {key: {"value": v, "std": 1e-7} for key, v in {"x": 1e-6, "w": 300.0, "tau": 7.0}.items()},
}  # fmt: skip
KINDS = (
    "quadratic",
    "cross_product",
    "bias_temperature",
    "temperature_lag",
    "g_sensitivity",
    "u |u|",
    "sagnac_sine",
)
SOME = [one for one in EFFECTS if one["name"].split(".")[1] in KINDS or one.get("shape") in KINDS]
DOCUMENT = calibration_of(UNIT) | {
    "valid_until": "2099-01-01T00:00:00Z", "temperature_range_c": [5.0, 45.0], "effects": [*SOME, OWN],
    "reference_temperature_c": 25.0, "status_reason": "", "operator": "A", "verdict": "PASS", "limits": [],
}  # fmt: skip
DEEP: Any = json.loads("[" * 400 + "]" * 400)
ODD: tuple[Any, ...] = (
    None, True, "7", "", "\ud800", [], ["7"], {}, {"value": "7"}, [1.0] * 4, DEEP, -1.0, 0, 1e308, -1e308, 1e-308,
    1e29, 10**400, float("nan"), float("inf"), "count/s", "2026-01-01",
)  # fmt: skip


def paths(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield where every part of a document is; of numbers in a list, and of coefficients, the last alone."""
    if at:
        yield at
    if isinstance(value, dict):
        alike = at[-1:] == ("coefficients",)
        for key in [*value][-1:] if alike else [*value]:
            yield from paths(value[key], (*at, key))
    elif isinstance(value, list) and value:
        alike = not isinstance(value[0], dict)
        for i in range(len(value))[-1 if alike else 0 :]:
            yield from paths(value[i], (*at, i))


def changed(at: tuple[Any, ...], odd: Any) -> dict[str, Any]:
    found = copy.deepcopy(DOCUMENT)
    inner: Any = found
    for key in at[:-1]:
        inner = inner[key]
    inner[at[-1]] = odd
    return found


@pytest.fixture(scope="module")
def accepted() -> list[str]:
    """Documents with something odd in them that are taken all the same; every other is refused in one line."""
    found, reported = list[str](), list[str]()
    for at in paths(DOCUMENT):
        for odd in ODD[:: 7 if at[0] in UNREAD else 2]:
            text = json.dumps(changed(at, odd))
            try:
                parsed_calibration(text, "c.json")
                found.append(text)
            except DataRefused as error:
                reported.append(str(error))
    assert not [line for line in reported if "\n" in line or len(line) > 300]
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of counts of the calibration's unit."""
    made, rig = tmp_path_factory.mktemp("odd"), LiveRig()
    rig.run(0.6)
    sent = rig.sent()
    rows = np.column_stack((sent.device_time, sent.gyro, sent.accel, sent.temperature))
    lines = [",".join(map(repr, row)) for row in rows.tolist()]
    (made / "a.csv").write_text("\n".join(["t_s,gx,gy,gz,ax,ay,az,temp_c", *lines]) + "\n")
    return made


def applied(folder: Path) -> None:
    source = open_source(folder / "a.csv", ColumnOptions(), None)
    apply_to(source, load(folder / "c.json"), folder / "out.csv", OutputRequest(), Progress())


def streamed(folder: Path) -> None:
    """As `station stream` does it, without a reader's process for each."""
    rig = LiveRig()
    assert rig.feed.unit is not None
    found = chosen_calibration(f"{folder}/c.json", None, rig.feed.unit, rig.feed.wire)
    lines(LiveRig(calibration=dict(found.document or {})).run(0.1))


def exported(folder: Path, to: str) -> None:
    next(one for one in EXPORTS if one.name == to).files(Request(folder / "c.json"))


USES = {"apply": applied, "stream": streamed, **{one.name: partial(exported, to=one.name) for one in EXPORTS}}


@pytest.mark.parametrize("use", USES)
def test_an_odd_calibration_is_used_or_refused_in_one_line_and_nothing_is_written(
    use: str, folder: Path, accepted: list[str]
) -> None:
    wrong = list[str]()
    for text in accepted:
        (folder / "c.json").write_text(text)
        try:
            USES[use](folder)
        except DataRefused as error:
            if "\n" in str(error) or len(list(folder.iterdir())) != 2:
                wrong.append(str(error))
        except Exception as error:  # what a command would call a bug
            wrong.append(f"{type(error).__name__}: {error} of {text[:2000]}")
        for name in ("out.csv", "out.csv.json"):
            (folder / name).unlink(missing_ok=True)
    assert not wrong, f"{len(wrong)} of {len(accepted)}: {wrong[:5]}"
