"""A disk that fails at its n-th call, met by Python and SQLite alike: a shim in C, compiled at run time.

A process must be started with the shim (`LD_PRELOAD`), and arms it for itself.
"""

import ctypes
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

SOURCE = Path(__file__).with_name("failing_calls.c")
WRITES, SYNCS, NAMES = 1, 2, 4
SHIM = "FAILING_DISK_SHIM"


def scratch_folder() -> Path:
    """Return where to work: in memory where that is."""
    return Path(tempfile.mkdtemp(dir="/dev/shm" if os.path.isdir("/dev/shm") else None)).resolve()


def begun_anew(arguments: Sequence[str], scratch: Path) -> int:
    """Run ``python arguments`` with the shim; return its exit code."""
    shim = scratch / "failing_calls.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-O1", "-o", str(shim), str(SOURCE), "-ldl"], check=True)
    environment = {**os.environ, "LD_PRELOAD": str(shim), SHIM: str(shim)}
    return subprocess.run([sys.executable, *arguments], env=environment, check=False).returncode


class FailingDisk:
    """What lies below a folder, as if on a disk that fails when told."""

    def __init__(self, folder: Path) -> None:
        self._folder = os.fsencode(folder)
        self._shim = ctypes.CDLL(os.environ[SHIM])
        self._shim.arm_disk.argtypes = (
            ctypes.c_char_p, ctypes.c_int, ctypes.c_long, ctypes.c_int, ctypes.c_int, ctypes.c_double,
        )  # fmt: skip

    def arm(self, kinds: int, nth: int, error: int, *, stays: bool = False, delay_s: float = 0.0) -> None:
        """Let the ``nth`` call of ``kinds`` from now on fail with ``error``, with ``stays`` all after it too."""
        self._shim.arm_disk(self._folder, kinds, nth, error, stays, delay_s)

    def heal(self) -> None:
        """Let all calls succeed again."""
        self._shim.arm_disk(b"", 0, 0, 0, 0, 0.0)

    @property
    def calls(self) -> int:
        """How many calls there were since it was armed."""
        return int(self._shim.calls_counted())

    @property
    def failed(self) -> int:
        """How many of them failed."""
        return int(self._shim.calls_failed())
