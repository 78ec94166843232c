"""The demo's device: ``python -m station.demo.device SEED SPEED LINK``, serving until stdin is closed."""

import sys
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from station.demo.unit import demo_truth


def main(seed: int, speed: float, link: Path) -> None:
    """Serve a random unit on a pty; say its URL and the address of its hands."""
    with SimulatedDevice(demo_truth(seed), seed, "counts", speed, link=link) as device:
        sys.stdout.write(f"{device.url}\n{device.control}\n")
        sys.stdout.flush()
        sys.stdin.read()


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3]))
