"""A quick start: names that a package hands out are imported when asked for, and garbage is looked for seldom."""

import gc
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazily(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """Return a package's ``__getattr__``; ``homes`` says in which of its modules each name stands."""

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    return get


def collect_seldom() -> None:
    """Look for garbage every 100 000 new objects: imports make many, drop none, and pay a sixth for the search."""
    gc.set_threshold(100_000, 10, 10)
