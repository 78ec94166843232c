"""Two attitude laws live at 2 kHz: `python -m tests.benchmarks.live_laws --seconds 60`.

A simulated IMU on a pty in a process of its own. The reader process and this one, which decodes, calibrates and
runs the monitor's engine with two laws, share one core. Printed: what was lost, the share of that core, the time
from the byte (as the reader stamped it) of a tick's last sample to the attitude at its end, and what the laws cost
alone in processor time.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from drivers.simulated.truth import Truth
from procedures.attitude.laws import parse_laws
from procedures.units import STANDARD_GRAVITY
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.calibration_in_use import InUse
from station.calibrated.rates_and_forces import RatesAndForces
from station.live_attitude.joint_filter import AttitudeEstimator
from station.live_attitude.side_by_side import SideBySide, compile_laws
from station.monitor.monitor import Monitor, MonitorOptions
from station.monitor.view import MonitorView
from station.stream.live.live_feed import open_feed
from station.stream.reader import Reader
from tests.benchmarks.can_rate import cpu_s
from tests.station.monitor.unit import calibration_of

PERIOD_S, TICK_SAMPLES = 0.0005, 200
SETTLE_S, ASKED_LATENCY_S = 3.0, 0.020


def serve(folder: Path) -> tuple[subprocess.Popen[str], str]:
    """Start a simulated IMU; return its process and its URL."""
    (folder / "truth.toml").write_text(f"sample_period_s = {PERIOD_S}\n")
    options = ("--truth", str(folder / "truth.toml"), "--pty", str(folder / "imu"))
    code = "from station.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code, "simulate", *options], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    while True:
        word, _, rest = process.stdout.readline().strip().partition(" ")
        if word == "url":
            return process, rest.strip()


def measure(seconds: float, laws: tuple[str, ...], core: int, folder: Path) -> bool:
    """Print what came of ``seconds``; say whether it is as asked."""
    compile_laws()
    devices, url = serve(folder)
    os.sched_setaffinity(0, {core})  # the reader inherits it
    latency: list[float] = []
    try:
        with Reader(url, folder / "session.mcap") as reader:
            feed = open_feed(reader)
            feed.identify()
            applied = AppliedCalibration(calibration_of(Truth()), None, InUse("by hand"))

            def seen(view: MonitorView) -> None:
                assert view.reading is not None
                assert len(view.laws) == len(laws)
                latency.append(time.time() - feed.buffer.host_ns(view.reading.sample) / 1e9)

            monitor = Monitor(feed, applied, MonitorOptions(laws=laws), sinks=(seen,))
            caught_up = time.monotonic() + SETTLE_S
            while time.monotonic() < caught_up:
                monitor.round()
            latency.clear()
            used, own, began = cpu_s(reader.pid), cpu_s(os.getpid()), time.monotonic()
            while (took := time.monotonic() - began) < seconds:
                monitor.round()
            shares = (cpu_s(reader.pid) - used) / took, (cpu_s(os.getpid()) - own) / took
            lost = feed.stream.counters.lost
    finally:
        devices.terminate()
        devices.wait()
    p50, p99 = np.percentile(latency, (50, 99))
    print(f"load       {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; laws {', '.join(laws)}")
    print(f"ticks      {len(latency)} of {TICK_SAMPLES} samples in {took:.1f} s; lost {lost}   asked 0")
    print(f"core       reader {100 * shares[0]:.1f} %, decoding and laws {100 * shares[1]:.1f} % of one")
    print(f"latency    p50 {1e3 * p50:.2f} ms, p99 {1e3 * p99:.2f} ms   asked {1e3 * ASKED_LATENCY_S:.0f}")
    return lost == 0 and p99 <= ASKED_LATENCY_S


def print_cost(laws: tuple[str, ...]) -> None:
    """Print what the laws cost a sample, without the rest of the engine."""
    from procedures.attitude.kalman_state import KalmanSettings

    still = RatesAndForces(np.zeros((TICK_SAMPLES, 3)), np.tile([0.0, 0.0, -STANDARD_GRAVITY], (TICK_SAMPLES, 1)))
    beside = SideBySide(
        laws, "none", AttitudeEstimator("none", lambda log, knows: KalmanSettings()), None, STANDARD_GRAVITY
    )
    ticks = 2000
    t = PERIOD_S * np.arange(1, ticks * TICK_SAMPLES + 1, dtype=np.float64).reshape(ticks, TICK_SAMPLES)
    began = time.process_time()
    for each in t:
        beside.take(each, still)
    spent = time.process_time() - began
    share = 100 * spent / (t.size * PERIOD_S)
    print(f"laws alone {1e9 * spent / t.size:.0f} ns a sample: {share:.2f} % of a core")


def main() -> int:
    """Measure; exit 1 where it is not as asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--laws", default="joint,paper")
    parser.add_argument("--core", type=int, default=0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        is_good = measure(asked.seconds, laws := parse_laws(asked.laws), asked.core, Path(folder))
    print_cost(laws)
    return 0 if is_good else 1


if __name__ == "__main__":
    raise SystemExit(main())
