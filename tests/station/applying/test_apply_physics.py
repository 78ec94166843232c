"""`station apply` and the library write nothing that contradicts physics: a known motion, mislabelled."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.calibration import DataRefused, calibration_of
from station.errors import explain
from tests.refusals import refused
from tests.station.applying.inputs import K_A, K_G, NAMES, calibration_file, document, write_csv
from tests.station.applying.run import apply, written
from tests.station.calibrated.test_calibration_applied import D_A, D_G, E_A, E_G

G = 9.80665
UP = np.array([0.05, -0.03, np.sqrt(1 - 0.05**2 - 0.03**2)])


def felt(seconds: float, hz: float, rest: slice | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Specific force [g] and rate [deg/s] of a unit that is shaken, but for a ``rest``; None: it rests always."""
    n = round(seconds * hz)
    t, draw = np.arange(n) / hz, np.random.default_rng(2)
    f, omega = np.tile(UP, (n, 1)), np.tile([0.002, 0.003, 0.001], (n, 1))
    if rest is not None:
        moves = np.ones(n, dtype=bool)
        moves[int(rest.start * hz) : int(rest.stop * hz)] = False
        shaken = np.column_stack([np.sin(2 * np.pi * (0.9 + k / 3) * t + k) for k in range(3)])
        f = np.where(moves[:, None], f + 0.4 * shaken, f)
        omega = np.where(moves[:, None], 40 * shaken, omega)
    return f + draw.normal(0, 1e-3, (n, 3)), omega + draw.normal(0, 2e-3, (n, 3))


def outputs(f: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Outputs in a second of a unit whose calibration is that of `document`."""
    return np.hstack((K_G * (omega @ E_G.T + D_G / 3600), K_A * (f @ E_A.T + D_A)))


def counts(per_second: np.ndarray, hz: float) -> np.ndarray:
    return np.diff(np.floor(np.cumsum(per_second, axis=0) / hz), axis=0, prepend=0)


def log(path: Path, t: np.ndarray, values: np.ndarray, time: str = "t_s", names: Any = NAMES) -> Path:
    return write_csv(path, {time: t, **dict(zip(names, values.T, strict=True))})


WRONG = [
    ("ms_for_s", 1000.0, 1e-3, 1.0), ("us_for_s", 200.0, 1e-6, 1.0), ("s_for_ms", 2.0, 1e3, 1.0),
    ("min_for_s", 100.0, 60.0, 1.0), ("per_second", 100.0, 1.0, 100.0), ("half_range", 100.0, 1.0, 0.5),
    ("four_times", 200.0, 1.0, 4.0), ("ticks", 100.0, 1e-4, 1.0),
]  # fmt: skip


MOVES = [(*each, slice(20, 24)) for each in WRONG]
RESTS = [(*each, None) for each in WRONG if each[0] in {"s_for_ms", "per_second"}]


@pytest.mark.parametrize(("name", "hz", "time", "factor", "rest"), MOVES + RESTS)
def test_what_is_scaled_wrongly_is_refused_with_what_would_make_it_right(
    tmp_path: Path, name: str, hz: float, time: float, factor: float, rest: slice | None
) -> None:
    f, omega = felt(40.0, hz, rest)
    values = np.rint(counts(outputs(f, omega), hz) * factor)
    t = 5.0 + np.arange(1, len(f) + 1) / hz / time
    source, known = log(tmp_path / "a.csv", t, values), calibration_file(tmp_path)
    asked = (source, "--calibration", known, "--out", tmp_path / "o.npz", "--unit-time", "s")
    result = apply(*asked)
    assert isinstance(result.exception, DataRefused)
    assert result.exception.code == ErrorCode.GRAVITY
    code, line = explain(result.exception)
    assert code == 3
    assert "\n" not in line
    words = {
        "per_second": "per second", "half_range": "2 times", "four_times": "0.25 times", "ms_for_s": "1000 times",
        "us_for_s": "1e6 times", "s_for_ms": "1000 times", "min_for_s": "60 times", "ticks": "10,000 times",
    }  # fmt: skip
    if rest is None or name != "half_range":
        assert words[name] in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "calibration.json"]
    forced = apply(*asked, "--force")
    assert forced.exit_code == 0, repr(forced.exception)
    assert "warning: " in forced.output
    assert len(written(tmp_path / "o.npz")) == len(f)


@pytest.mark.parametrize("hz", [0.5, 1000.0])
@pytest.mark.parametrize("rest", [None, slice(39, 40), slice(0, 0)])
def test_what_is_right_is_applied(tmp_path: Path, hz: float, rest: slice | None) -> None:
    f, omega = felt(max(40.0, 40 / hz), hz, rest)
    values, known = counts(outputs(f, omega), hz), calibration_file(tmp_path)
    source = log(tmp_path / "a.csv", 5.0 + np.arange(1, len(f) + 1) / hz, values)
    result = apply(source, "--calibration", known, "--out", tmp_path / "o.npz", "--unit-time", "s")
    assert result.exit_code == 0, repr(result.exception)
    got = written(tmp_path / "o.npz")
    assert got[:, :3].mean(axis=0) == pytest.approx(G * f.mean(axis=0), abs=0.01)
    assert "warning" not in result.output


@pytest.mark.parametrize("first", [True, False])
def test_free_fall_next_to_a_rest_is_written(tmp_path: Path, first: bool) -> None:
    f, omega = felt(20.0, 100.0)
    f[: 1500 if first else 0] = 0.0
    f[len(f) if first else 500 :] = 0.0
    known, values = calibration_of(document()), counts(outputs(f, omega), 100.0)
    assert known.apply(values, np.arange(1, len(f) + 1) / 100.0).warnings == ()


def test_an_accelerometer_of_one_axis_may_lie(tmp_path: Path) -> None:
    f, omega = felt(10.0, 100.0)
    values = counts(outputs(f[:, [2, 1, 0]] * [0, 0, 1], omega), 100.0)
    names = [name if name in {"gx", "gy", "gz", "az"} else f"channel{name[0]}" * 2 for name in NAMES]
    source = log(tmp_path / "a.csv", np.arange(1, len(f) + 1) / 100.0, values, names=names)
    result = apply(source, "--calibration", calibration_file(tmp_path), "--out", tmp_path / "o.npz")
    assert result.exit_code == 0, repr(result.exception)


def test_rates_in_the_wrong_unit_contradict_gravity_or_the_rest() -> None:
    known, hz = calibration_of(document(unit="output")), 100.0
    f, omega = felt(20.0, hz)
    t, right = np.arange(1, len(f) + 1) / hz, outputs(f, omega)
    assert known.apply(right, t, output="rates").warnings == ()
    for wrong, code in (
        (right * [1, 1, 1, G, G, G], ErrorCode.GRAVITY), (right / hz, ErrorCode.GRAVITY),
        (outputs(f, omega * 180 / np.pi), ErrorCode.RATE_AT_REST),
    ):  # fmt: skip
        with refused(DataRefused, code) as found:
            known.apply(wrong, t, output="rates")
        assert known.apply(wrong, t, output="rates", force=True).warnings == (str(found.value),)


def test_the_bias_of_a_gyroscope_that_changed_is_refused_and_named() -> None:
    known, hz = calibration_of(document()), 100.0
    f, omega = felt(20.0, hz)
    with refused(DataRefused, ErrorCode.RATE_AT_REST):
        known.apply(counts(outputs(f, omega + np.array([0.8, 0.3, 0.0])), hz), np.arange(1, len(f) + 1) / hz)


def test_twos_complement_that_was_not_applied_is_refused(tmp_path: Path) -> None:
    f, omega = felt(20.0, 100.0)
    values = counts(outputs(f * [0.001, 1, 1], omega), 100.0)
    values[:, 3] = np.rint(np.random.default_rng(1).normal(0, 5, len(f)))
    source = log(tmp_path / "a.csv", np.arange(1, len(f) + 1) / 100.0, values % 65536)
    result = apply(source, "--calibration", calibration_file(tmp_path), "--out", tmp_path / "o.npz")
    assert isinstance(result.exception, DataRefused)
    assert result.exception.code == ErrorCode.UNIT
    assert not (tmp_path / "o.npz").exists()


def test_in_parts_the_end_decides() -> None:
    f, omega = felt(20.0, 100.0)
    values, t = counts(outputs(f, omega), 100.0) * 8, np.arange(1, len(f) + 1) / 100.0
    for step in (1, 300, len(f)):
        stream = calibration_of(document()).stream(0.01)
        for i in range(0, len(f), step):
            stream.apply(values[i : i + step], t[i : i + step])
        with refused(DataRefused, ErrorCode.GRAVITY):
            stream.apply(np.empty((0, 6)), [], last=True)
