"""Monte Carlo on the engine of `station resolve`: many seeds on local workers or a cluster, restartable.

`python -m tests.benchmarks.coverage --keep FOLDER` goes on where it was killed; with ``--scheduler ADDRESS`` the
workers of a cluster draw. A number depends on its seed alone.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from station.results.cluster.engine import open_engine
from station.results.cluster.progress import Progress
from station.results.cluster.restartable_map import map_restartable

I = TypeVar("I")  # noqa: E741


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add who draws, and where results are kept."""
    parser.add_argument("--workers", type=int, default=None)
    parser.add_argument("--scheduler", default=None, metavar="ADDRESS")
    parser.add_argument("--keep", type=Path, default=None, metavar="FOLDER")


def draws(
    module: str, name: str, items: Sequence[I], options: argparse.Namespace, key: Callable[[I], object] = repr
) -> list[dict[str, Any]]:
    """Return what the function ``name`` of ``module`` makes of each item, in the order of the items.

    It is named, not given: workers cannot import what was started as ``__main__``.
    """
    function, found = getattr(import_module(module), name), dict[int, dict[str, Any]]()
    progress = Progress(sys.stderr, name, len(items))
    with open_engine(options.workers, options.scheduler) as engine:
        for done in map_restartable(function, items, key, options.keep, engine):
            if done.answer.result is None:
                raise SystemExit(f"{done.item}: {done.answer.fault}")
            found[done.index] = dict(done.answer.result)
            progress.advance(was_kept=done.was_kept)
    progress.end()
    return [found[index] for index in range(len(items))]
