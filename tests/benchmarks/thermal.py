"""Print what a diagnosis makes of measured recordings that temperature moves, beside what a hand would fit.

`python -m tests.benchmarks.thermal` (`STATION_DATA`): error where each block is left out in turn. By hand are
plain least squares, of numpy alone: nothing of temperature, a line, a cubic, a cubic with a first-order lag beside
it whose time constant is the best of sixty, and degree 13.
"""

import json
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station import cli
from tests.paths import DATA

G = 9.80665
BLOCKS_OF_TABLE = 9
BY_HAND = ("constant", "linear", "cubic", "cubic with a lag", "degree 13")


def diagnosed(log: Path, *options: str) -> Mapping[str, Any]:
    """Return the diagnosis/1 of a log."""
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        out = Path(folder) / "out.json"
        cli.run(["diagnose", str(log), *options, "--json", str(out)])
        found: Mapping[str, Any] = json.loads(out.read_text())
        return found


def left_out(design: FloatArray, y: FloatArray, block: FloatArray) -> float:
    """Return the rms error, in the unit of ``y`` (n, m), of blocks left out in turn; ``design`` (n, p)."""
    error = np.empty_like(y)
    for number in np.unique(block):
        out = block == number
        size = np.abs(design[~out]).max(axis=0)
        x = np.linalg.lstsq(design[~out] / size, y[~out], rcond=None)[0]
        error[out] = y[out] - design[out] / size @ x
    return float(np.sqrt(np.mean(error**2)))


def followed(t: FloatArray, T: FloatArray, tau: float) -> FloatArray:
    """Return T_s (n,) [degC], from the first T on, sample by sample."""
    found = np.empty_like(T)
    found[0] = T[0]
    for i in range(1, len(T)):
        found[i] = found[i - 1] + (1 - np.exp(-(t[i] - t[i - 1]) / tau)) * ((T[i] + T[i - 1]) / 2 - found[i - 1])
    return found


def powers(T: FloatArray, degree: int) -> FloatArray:
    """Return 1, x, ... (n, degree + 1) of x = (T - mean) / half range."""
    x = (T - T.mean()) / (np.ptp(T) / 2)
    return np.vander(x, degree + 1, increasing=True)


def sweep_by_hand(log: Path) -> dict[str, float]:
    """Return the errors [mg] of a static sweep, of block means."""
    table = np.loadtxt(log, delimiter=",", skiprows=1)
    t, force, T = (table[:, 0] - table[0, 0]) * 1e-6, table[:, 1:4] / G * 1e3, table[:, 4]
    edges = np.linspace(0, len(t), int(np.ceil(t[-1] / 100)) + 1).round().astype(int)[:-1]
    size = np.diff([*edges, len(t)])

    def mean(values: FloatArray) -> FloatArray:
        found: FloatArray = (np.add.reduceat(values, edges, axis=0).T / size).T
        return found

    def error(design: FloatArray) -> float:
        return left_out(mean(design), mean(force), np.arange(len(edges)))

    lags = [np.column_stack((powers(T, 3), followed(t, T, tau))) for tau in np.geomspace(3, 5000, 60)]
    plain = {name: error(powers(T, n)) for name, n in zip(BY_HAND, (0, 1, 3), strict=False)}
    return plain | {BY_HAND[3]: min(error(lag) for lag in lags), BY_HAND[4]: error(powers(T, 13))}


def table_by_hand(log: Path) -> dict[str, float]:
    """Return the errors [mdeg/s] of a rate table whose line is bent by a cubic in the rate.

    Temperature multiplies the whole output; the lag's time is the row's number.
    """
    omega, out, T = np.loadtxt(log, delimiter=",", skiprows=1).T
    block = np.repeat(np.arange(BLOCKS_OF_TABLE), [len(b) for b in np.array_split(out, BLOCKS_OF_TABLE)])
    scale = np.polyfit(omega, out, 1)[0]
    x = omega / np.abs(omega).max()

    def error(of_temperature: FloatArray) -> float:
        wide = [of_temperature * part[:, None] for part in (x, x**3)]
        return left_out(np.column_stack([np.ones(len(x)), *wide]), out[:, None] / abs(scale), block) * 1e3

    rows = np.arange(len(T), dtype=float)
    lags = [np.column_stack((powers(T, 3), followed(rows, T, tau))) for tau in np.geomspace(1, 2000, 60)]
    plain = {name: error(powers(T, n)) for name, n in zip(BY_HAND, (0, 1, 3), strict=False)}
    return plain | {BY_HAND[3]: min(error(lag) for lag in lags), BY_HAND[4]: error(powers(T, 13))}


def rows() -> Iterator[str]:
    """Yield what is to be printed."""
    sweep = DATA / "foreign/thermal_sweep_accelerometer/log.csv"
    yield from _lines(sweep, (), sweep_by_hand(sweep), "accelerometer soaks", 1e3, "mg")
    table = DATA / "measured/fog_rate_temperature/rates.csv"
    options = ("--reference", "rate_ref_deg_s")
    yield from _lines(table, options, table_by_hand(table), "gyroscope rate points", 1e3, "mdeg/s")


def _lines(
    log: Path, options: Sequence[str], by_hand: Mapping[str, float], quantity: str, scale: float, unit: str
) -> Iterator[str]:
    found = diagnosed(log, *options)
    error = next(each for each in found["error"] if each["quantity"] == quantity)
    yield f"{log.parent.name}, left out [{unit}]: " + ", ".join(f"{n} {v:.3g}" for n, v in by_hand.items())
    ours, best = error["held_out_after"] * scale, min(by_hand.values())
    yield f"    ours {error['held_out_before'] * scale:.3g} -> {ours:.3g}, {ours / best:.2f} of the best by hand"
    for one in found["findings"]:
        coefficients = ", ".join(f"{k} {v['value']:.4g} +- {v['std']:.2g}" for k, v in one["coefficients"].items())
        yield f"    {one['effect']} ({one['confidence']}, share {one['share']:.2f}): {coefficients} {one['unit']}"


def main() -> None:
    """Print a few lines for each recording."""
    for line in rows():
        print(line, flush=True)


if __name__ == "__main__":
    main()
