"""What the kernel holds for the readers of a UDP port: a simulated device that must lose nothing waits for it."""

import os
from contextlib import suppress
from pathlib import Path

TABLE = Path("/proc/net/udp")
LOCAL, QUEUES, INODE = 1, 4, 9  # columns of it


def waiting_for_others(port: int) -> int:
    """Return the bytes that wait at a port's sockets, those of this process aside: a sender hears itself, too."""
    rows = [line.split() for line in TABLE.read_text().splitlines()[1:]]
    own = _own_sockets()
    return sum(
        int(row[QUEUES].partition(":")[2], 16)
        for row in rows
        if int(row[LOCAL].partition(":")[2], 16) == port and row[INODE] not in own
    )


def _own_sockets() -> set[str]:
    found = set[str]()
    for descriptor in os.listdir("/proc/self/fd"):
        with suppress(OSError):  # closed meanwhile
            found.add(os.readlink(f"/proc/self/fd/{descriptor}").removeprefix("socket:[").removesuffix("]"))
    return found
