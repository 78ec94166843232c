"""A quick start: imports make many objects and drop none; looking for garbage would take a sixth of their time."""

import gc


def collect_seldom() -> None:
    """Look for garbage every 100 000 new objects."""
    gc.set_threshold(100_000, 10, 10)
