"""A quick start and a quick end: imports make many objects and drop none, and to look for garbage takes long."""

import gc


def collect_seldom() -> None:
    """Look for garbage every 100 000 new objects; else it would take a sixth of the time of imports."""
    gc.set_threshold(100_000, 10, 10)


def leave_garbage() -> None:
    """Have what is left go with the process: it ends, and to look through all of it takes a tenth of a solve."""
    gc.freeze()
