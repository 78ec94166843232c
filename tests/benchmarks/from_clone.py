"""From ``git clone`` to the first position that the screen asks for: ``python -m tests.benchmarks.from_clone``.

What the README says to somebody without hardware: clone, `make install`, `station simulate`, `station calibrate`.
Packages come from the package index or pip's cache, as this machine has them. The unit's warm-up is skipped: it is
the unit's time and not the machine's. Judged is processor time of all processes; the wall clock stands beside.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.benchmarks.start import until_shown
from tests.paths import ROOT

LIMIT_S = 180.0
ASKED_FOR = ("position 1:",)


def clean() -> dict[str, str]:
    """Return the environment of somebody who has nothing of this checkout."""
    return {name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "VIRTUAL_ENV"}}


class Times:
    """Adds up what each part takes [s], of the processor and by the clock."""

    def __init__(self) -> None:
        self.processor = self.wall = 0.0
        self._processor, self._wall = self._now()

    def end(self, part: str) -> None:
        """Say how long the part took that ends now."""
        before, (self._processor, self._wall) = (self._processor, self._wall), self._now()
        processor, wall = self._processor - before[0], self._wall - before[1]
        self.processor, self.wall = self.processor + processor, self.wall + wall
        print(f"{part:<24}{processor:6.1f} s of processor time, {wall:6.1f} s", flush=True)

    def _now(self) -> tuple[float, float]:
        own = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(each.ru_utime + each.ru_stime for each in own), time.monotonic()


def first_position(checkout: Path, folder: Path) -> None:
    """Simulate a unit and begin a calibration of it, up to the first position asked for."""
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


def main() -> None:
    """Print each part and the whole."""
    here = ROOT
    os.environ.pop("PYTHONPATH", None)
    with tempfile.TemporaryDirectory() as made:
        folder, checkout, times = Path(made), Path(made) / "fog-station", Times()
        subprocess.run(["git", "clone", "--quiet", str(here), str(checkout)], check=True)
        times.end("git clone")
        subprocess.run(["make", "--silent", "install"], check=True, cwd=checkout, env=clean())
        times.end("make install")
        first_position(checkout, folder)
        times.end("simulate, calibrate")
    said = f"{times.processor:.0f} s of processor time (asked: {LIMIT_S:g}), {times.wall:.0f} s"
    print(f"to the first position: {said}")
    sys.exit(times.processor > LIMIT_S)


if __name__ == "__main__":
    main()
