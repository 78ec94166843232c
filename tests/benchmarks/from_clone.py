"""From ``git clone`` to the first position that the screen asks for: ``python -m tests.benchmarks.from_clone``.

What the README says to somebody without hardware: clone, `make install`, `station simulate`, `station calibrate`.
Packages come from the package index or pip's cache, as this machine has them. The unit's warm-up is skipped: it is
the unit's time and not the machine's.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.benchmarks.start import until_shown

LIMIT_S = 180.0
ASKED_FOR = ("position 1:",)


def clean() -> dict[str, str]:
    """Return the environment of somebody who has nothing of this checkout."""
    return {name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "VIRTUAL_ENV"}}


def timed(name: str, *command: str, where: Path) -> float:
    """Run a command and say how long it took [s]."""
    began = time.monotonic()
    subprocess.run(command, check=True, cwd=where, env=clean(), stdout=subprocess.DEVNULL)
    took = time.monotonic() - began
    print(f"{name:<24}{took:6.1f} s", flush=True)
    return took


def first_position(checkout: Path, folder: Path) -> float:
    """Simulate a unit and begin a calibration of it; return the time to the first position asked for [s]."""
    began = time.monotonic()
    station = str(checkout / ".venv/bin/station")
    simulate = [station, "simulate", "--example", "7"]
    with subprocess.Popen(simulate, stdout=subprocess.PIPE, text=True, cwd=folder, env=clean()) as unit:
        assert unit.stdout is not None
        try:
            url = unit.stdout.readline().removeprefix("url ").strip()
            given = ("--device", url, "--latitude", "31.17", "--no-warm-up", "--out", str(folder / "c"))
            until_shown(str(folder), "calibrate", *given, wanted=ASKED_FOR, program=[station])
        finally:
            unit.terminate()
    took = time.monotonic() - began
    print(f"{'simulate, calibrate':<24}{took:6.1f} s", flush=True)
    return took


def main() -> None:
    """Print each part and the whole."""
    here = Path(__file__).parents[2]
    os.environ.pop("PYTHONPATH", None)
    with tempfile.TemporaryDirectory() as made:
        folder, checkout = Path(made), Path(made) / "fog-station"
        total = timed("git clone", "git", "clone", "--quiet", str(here), str(checkout), where=folder)
        total += timed("make install", "make", "install", where=checkout)
        total += first_position(checkout, folder)
    print(f"{'to the first position':<24}{total:6.1f} s, asked {LIMIT_S:g}")
    sys.exit(total > LIMIT_S)


if __name__ == "__main__":
    main()
