"""Print how well the monitor reads a simulated FOG, and what it costs: `python -m tests.benchmarks.monitor`.

Parts: ``rest`` (12 positions, level error and its ratio to 1 sigma after a minute, each with a calibration that is
wrong by as much as its sigmas say), ``move`` (hand moves of 20 s from face to face, error at their end by the
monitor's settings and the filter's own), ``cpu`` (the whole program on a pty of 80x24, IMU at 100 Hz).
"""

import argparse
import os
import pty
import resource
import subprocess
import sys
import tempfile
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.frames import nominal_C_lb
from station.calibrated.body_axes import body_axes
from station.calibrated.filter_settings import filter_settings
from station.monitor import monitor
from station.monitor.monitor import MonitorOptions
from station.monitor.view import MonitorView
from tests.station.monitor.rig import MonitorRig
from tests.station.monitor.unit import calibration_of, write_calibration

LATITUDE = np.radians(31.17)
ASKED_CPU = 30.0


def unit(seed: int) -> Truth:
    """Return a unit on a level slab."""
    return replace(Truth.example(seed), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))


def drawn(calibration: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """Return a calibration that is wrong by as much as its own sigmas say."""
    for triad in ("gyroscope", "accelerometer"):
        for part in calibration[triad].values():
            value, std = np.array(part["value"]), np.array(part["std"])
            part["value"] = (value + std * rng.standard_normal(value.shape)).tolist()
    return calibration


def off_deg(view: MonitorView, position: int) -> float:
    assert view.reading is not None
    roll, pitch = np.radians([view.reading.roll, view.reading.pitch])
    down: FloatArray = np.array([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
    true = body_axes("x,-y,-z") @ nominal_C_lb(position).T @ np.array([0.0, 0.0, -1.0])
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(down, true)), down @ true)))


def rest(seeds: int) -> None:
    offs, ratios = list[float](), list[float]()
    for seed in range(seeds):
        for position in range(1, 13):
            calibration = drawn(calibration_of(unit(seed)), np.random.default_rng([seed, position]))
            rig = MonitorRig(
                unit(seed), MonitorOptions(latitude=LATITUDE), position=position, calibration=calibration
            )
            rig.run(80.0)
            late = [view for view in rig.lines if view.reading is not None and view.reading.t > 62.0]
            offs += [off_deg(view, position) for view in late]
            ratios += [off_deg(view, position) / view.reading.sigma for view in late if view.reading]
    rms, ratio = (float(np.sqrt(np.mean(np.square(values)))) for values in (offs, ratios))
    print(f"at rest, {12 * seeds} positions, after 60 s: rms {rms:.4f} deg (asked 0.02), {ratio:.2f} of 1 sigma")


def moved(seed: int, position: int) -> tuple[float, float]:
    """Return error and 1 sigma [deg] as a hand move from position 9 ends."""
    rig = MonitorRig(unit(seed), MonitorOptions(latitude=LATITUDE))
    rig.run(40.0)
    rig.hands(f"place {position} 20")
    end = rig.source.device.imu.done
    view = rig.run(60.0, lambda view: view.reading is not None and view.reading.t >= end)
    assert view.reading is not None
    return off_deg(view, position), view.reading.sigma


def move(seeds: int) -> None:
    for name in ("the monitor's settings", "the filter's own"):
        if name == "the filter's own":
            monitor.settings_of = lambda _, *rest: filter_settings(None, *rest)  # type: ignore[assignment]
        found = np.array([moved(seed, position) for seed in range(seeds) for position in (1, 5, 12)])
        ratio = np.sqrt(np.mean((found[:, 0] / found[:, 1]) ** 2))
        print(f"hand moves of 20 s, {name}: rms {np.sqrt(np.mean(found[:, 0] ** 2)):.3f} deg, largest "
              f"{found[:, 0].max():.3f}, {ratio:.2f} of 1 sigma")  # fmt: skip
    monitor.settings_of = filter_settings


def cpu(seconds: float) -> None:
    truth = replace(unit(5), sample_period_s=0.01)
    with tempfile.TemporaryDirectory() as folder, SimulatedDevice(truth, 5) as device:
        calibration = write_calibration(Path(folder), truth)
        asked = ["--calibration", str(calibration), "--latitude", "31"]
        used = [
            _run([*asked, "--folder", f"{folder}/{s:g}", "--seconds", str(s)], device.url)
            for s in (1.0, 1.0 + seconds)
        ]
    share = 100 * (used[1] - used[0]) / seconds
    print(f"the program, screen and reader, IMU at 100 Hz: {share:.0f} % of a core (asked {ASKED_CPU:g})")


def _run(arguments: list[str], url: str) -> float:
    """Return the processor time [s] of a run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    far, near = pty.openpty()
    command = [sys.executable, "-P", "-c", "from station.cli import main; main()", "monitor", url, *arguments]
    process = subprocess.Popen(command, stdin=near, stdout=near, env=os.environ | {"COLUMNS": "80", "LINES": "24"})
    threading.Thread(target=_drain, args=(far,), daemon=True).start()
    process.wait()
    os.close(near)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _drain(descriptor: int) -> None:
    try:
        while os.read(descriptor, 65536):
            pass
    except OSError:
        pass


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", nargs="*", default=["rest", "move", "cpu"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    if "rest" in options.parts:
        rest(options.seeds)
    if "move" in options.parts:
        move(options.seeds)
    if "cpu" in options.parts:
        cpu(options.seconds)
