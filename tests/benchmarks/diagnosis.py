"""Print how well effects are named: `python -m tests.benchmarks.diagnosis --trials 100 --nulls 100`.

Each trial plants one effect of 6 to 12 times the sigma of its own estimate in a campaign of another unit, on
another tilted cube and slab. ``drivers.simulated`` plants, ``procedures.effects`` names: they share no code.
`--power`: sizes from 0.3 sigma up, one effect and several at once.
"""

import argparse
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial

from tests.benchmarks.diagnosing.nulls import NULLS, null
from tests.benchmarks.diagnosing.plants import PLANTS
from tests.benchmarks.diagnosing.power import power
from tests.benchmarks.diagnosing.sigmas import Sigmas, sigmas_of
from tests.benchmarks.diagnosing.table import HEAD, figures, row
from tests.benchmarks.diagnosing.trials import Outcome, planted, unheard

OUTSIDE = ("heading, accelerometers", "heading, all", "dead zone", "temperature rate times temperature")
MOVED = "moved"
APART = 10_000  # seeds between rows: no two share a draw of noise
Trial = Callable[[int], Outcome]


def trials() -> Iterator[tuple[str, Callable[[], Trial]]]:
    """Return each row's name and how its trial is made; those with moves last, so that no other's seeds change."""
    yield from (each for each in _trials() if MOVED not in each[0])
    yield from (each for each in _trials() if MOVED in each[0])


def _trials() -> Iterator[tuple[str, Callable[[], Trial]]]:
    for name in NULLS:
        yield f"none, {name}", partial(partial, null, name)
    for name in PLANTS:
        yield name, partial(_planted, name)
    for name in OUTSIDE:
        yield f"outside, {name}", partial(partial, unheard, name)


def _planted(name: str) -> Trial:
    plant = PLANTS[name]
    given = plant.sigma or (1.0 if plant.between else 0.0)
    sigmas = Sigmas({}, given) if given else sigmas_of(plant.effect, plant.design, plant.beside, plant.but_for)
    return partial(planted, name, sigmas)


def confusion(pool: Executor, only: str, first: int, amounts: tuple[int, int], seed: int | None) -> None:
    """Print a row as each is done, then the figures; ``amounts`` of trials and of nulls, or one ``seed``."""
    outcomes = list[Outcome]()
    print(HEAD)
    for number, (name, made) in enumerate(trials()):
        begin = first + number * APART
        numbers = range(begin, begin + amounts[name.startswith("none")]) if seed is None else [seed]
        if only in name and numbers:
            outcomes += (found := list(pool.map(made(), numbers)))
            print(row(found), flush=True)
    print()
    print(figures(outcomes))


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=5, help="of each effect, and of each outside the catalogue")
    parser.add_argument("--nulls", type=int, default=5, help="of each campaign with nothing planted but the bench")
    parser.add_argument("--only", default="", help="a part of the row's name: 'none', 'outside', 'separated', ...")
    parser.add_argument("--power", action="store_true", help="sizes from 0.3 sigma up")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seed", type=int, help="this one alone, as a row's last column gives it")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.trials)
    with ProcessPoolExecutor(options.processes) as pool:
        if options.power:
            power(pool, options.only, seeds)
        else:
            confusion(pool, options.only, options.first, (options.trials, options.nulls), options.seed)


if __name__ == "__main__":
    main()
