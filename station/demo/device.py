"""The demo's device: ``python -m station.demo.device SEED SPEED LINK``, serving until stdin is closed."""

import sys
from dataclasses import replace
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth

EFFECT, KEY = "gyroscope.magnetic", "zz"  # the Faraday effect in a coil that is not well shielded
COEFFICIENT = 0.02  # deg/h/uT


def demo_truth(seed: int) -> Truth:
    """Return a random unit whose gyroscope z also measures the magnetic field along its axis."""
    return replace(Truth.example(seed), effects={EFFECT: {KEY: COEFFICIENT}})


def main(seed: int, speed: float, link: Path) -> None:
    """Serve a random unit on a pty; say its URL and the address of its hands."""
    with SimulatedDevice(demo_truth(seed), seed, "counts", speed, link=link) as device:
        sys.stdout.write(f"{device.url}\n{device.control}\n")
        sys.stdout.flush()
        sys.stdin.read()


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3]))
