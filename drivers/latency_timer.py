"""How long a USB adapter holds bytes back before it sends a packet that is not full: 16 ms, asked down to 1.

At 100 Hz frames come up to 30 ms late else, in clumps (pyserial issue 287; a KVH 1750 driver sets the same file).
The serial line's low-latency flag asks the kernel for the same, but not every kernel's driver heeds it.
"""

import contextlib
import os
from pathlib import Path

WANTED_MS = 1
TTYS = Path("/sys/class/tty")


def latency_ms(device: str, ttys: Path = TTYS) -> int | None:
    """Return the adapter's latency timer [ms]; None where the port has none."""
    try:
        return int(_file(device, ttys).read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None


def shorten_latency(device: str, ttys: Path = TTYS) -> int | None:
    """Set the latency timer to 1 ms, where the port has one and it may be set; return what holds now [ms]."""
    before = latency_ms(device, ttys)
    if before is not None and before > WANTED_MS:
        with contextlib.suppress(OSError):  # root alone may, unless a udev rule says otherwise
            _file(device, ttys).write_text(f"{WANTED_MS}", encoding="ascii")
    return latency_ms(device, ttys)


def _file(device: str, ttys: Path) -> Path:
    return ttys / Path(os.path.realpath(device)).name / "device/latency_timer"
