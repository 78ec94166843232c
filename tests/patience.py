"""How slow this machine is just now, for tests in which bytes flow in real time, and when a wait is a hang.

A test waits for what it is about, not for a time. Where a simulated device goes `speed` times as fast as the
clock, a process that gets a tenth of a core would take it for a silent one: the device goes as much slower as the
machine is.
"""

import os
import time
from collections.abc import Callable

HANG_S = 900.0  # a wait as long as this has failed; pytest's own timeout is the last resort
WORK_S = 0.01  # of a core: three turns of a busy machine's scheduler
NAP_S, TRIES = 0.005, 4
OWN_S = 0.02  # a nap may end so late on a machine of its own
NOT_REAL = 0.85
FULL = 1.5  # processes that want to run on each core and still get along


def slowness() -> float:
    """Return how many times longer things take here and now than on a machine of one's own; at least 1.

    The greatest of how long some work takes, how late a nap ends, and how far the load that each core has had goes
    beyond `FULL`. Of several tries the slowest is left out: one that waited for seconds says nothing of the next.
    """
    work, late = zip(*((_work(), _nap()) for _ in range(TRIES)), strict=True)
    share, nap = (sorted(each)[-2] for each in (work, late))
    return max(1.0, share / WORK_S, nap / OWN_S, os.getloadavg()[0] / (os.cpu_count() or 1) / FULL)


def paced(speed: float) -> float:
    """Return the speed at which a simulated device can be followed here and now, ``speed`` at most.

    Not one that is nearly the clock's: a device at such a pace is taken to have a wrong sample rate.
    """
    slower = speed / slowness()
    return NOT_REAL if abs(slower - 1) < abs(NOT_REAL - 1) else slower


def longer(seconds: float) -> float:
    """Return how long a look at what comes must be here and now, ``seconds`` at least."""
    return seconds * slowness()


def until(holds: Callable[[], object], act: Callable[[], object] = lambda: time.sleep(0.01)) -> None:
    """Do something again and again until something holds."""
    deadline = time.monotonic() + HANG_S
    while not holds():
        assert time.monotonic() < deadline, f"not within {HANG_S:g} s"
        act()


def _work() -> float:
    began, used = time.perf_counter(), time.thread_time()
    while time.thread_time() < used + WORK_S:
        pass
    return time.perf_counter() - began


def _nap() -> float:
    began = time.perf_counter()
    time.sleep(NAP_S)
    return time.perf_counter() - began - NAP_S
