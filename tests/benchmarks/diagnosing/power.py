"""How small an effect may be and still be found, and whether small ones bring wrong names: `--power`."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from tests.benchmarks.diagnosing.plants import PLANTS, drawn_sizes
from tests.benchmarks.diagnosing.sigmas import Sigmas, sigmas_of
from tests.benchmarks.diagnosing.trials import accused, diagnosed, judge, of_bench, untrue

EDGES = (0.3, 1.0, 2.0, 3.0, 4.0, 6.0, 10.0)  # sigmas of the effect's own estimate
BINS = tuple(pairwise(EDGES))
NAMES = tuple(
    name for name, plant in PLANTS.items()
    if name == plant.effect and not plant.sigma and name not in {"placement.label", "disturbance.dwell"}
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Found:
    """One trial: size bin and word of each planted effect, what untrue was said, and what of it accuses."""

    bins: tuple[int, ...]
    words: tuple[str, ...]
    untrue: tuple[str, ...]
    accused: tuple[str, ...]
    seed: int


def tried(names: Sequence[str], sigmas: Mapping[str, Sigmas], bins: Sequence[int], seed: int) -> Found:
    """Plant several effects of a design at once, each of its own size, and diagnose."""
    rng, design = np.random.default_rng([seed, 13]), PLANTS[names[0]].design
    effects = {n: drawn_sizes(n, sigmas[n], rng, *BINS[b]) for n, b in zip(names, bins, strict=True)}
    _, diagnosis, _ = diagnosed(design, seed, effects)
    true = (*names, *of_bench(design))
    words = judge(diagnosis, tuple(names), design)
    if untrue(diagnosis, true):
        here = {n: any(n in {f.effect, *f.aliases} for f in diagnosis.findings) for n in names}
        words = {n: "group" if here[n] else "missed" for n in names}
    wrong = tuple(each for each in accused(diagnosis) if each not in true)
    return Found(tuple(bins), tuple(words.values()), tuple(untrue(diagnosis, true)), wrong, seed)


def several(seed: int, sigmas: Mapping[str, Sigmas]) -> tuple[list[str], list[int]]:
    """Draw two or three effects that one design excites, and a size bin for each."""
    rng = np.random.default_rng([seed, 17])
    of = dict[str, list[str]]()
    for name in sigmas:
        of.setdefault(PLANTS[name].design, []).append(name)
    designs = [design for design, names in of.items() if len(names) > 1]
    names = of[str(rng.choice(designs))]
    chosen = [str(n) for n in rng.choice(names, min(int(rng.integers(2, 4)), len(names)), replace=False)]
    return chosen, [int(b) for b in rng.integers(0, len(BINS), len(chosen))]


def _of_one(name: str, sigmas: Mapping[str, Sigmas], seed: int) -> Found:
    return tried([name], sigmas, [seed % len(BINS)], seed)


def _of_several(sigmas: Mapping[str, Sigmas], seed: int) -> Found:
    names, bins = several(seed, sigmas)
    return tried(names, sigmas, bins, seed)


def power(pool: Executor, only: str, seeds: range) -> None:
    """Print the share named by size, of each effect and of all, alone in its campaign and one of several."""
    sigmas = {name: sigmas_of(name, PLANTS[name].design) for name in NAMES if only in name}
    head = " | ".join(f"{low:g}-{high:g}" for low, high in BINS)
    print(f"| named of, by size in sigmas | {head} | untrue | instrument wrongly accused | seeds |")
    print("|---|" + "---|" * (len(BINS) + 3))
    every = list[Found]()
    for name in sigmas:
        here = list(pool.map(partial(_of_one, name, sigmas), seeds))
        every += here
        print(_row(name, here), flush=True)
    print(_row("all of these, one at a time", every), flush=True)
    for b, (low, high) in enumerate(BINS):
        print(_row(f"  of {low:g}-{high:g} sigma", [f for f in every if f.bins == (b,)]))
    if len({PLANTS[name].design for name in sigmas}) < len(sigmas):
        amount = range(seeds.start, seeds.start + 5 * len(seeds))
        print(_row("two or three at once", list(pool.map(partial(_of_several, sigmas), amount))))


def _row(name: str, found: Sequence[Found]) -> str:
    cells = [name]
    for b in range(len(BINS)):
        words = [w for f in found for w, at in zip(f.words, f.bins, strict=True) if at == b]
        cells.append(f"{np.mean([w in {'right', 'group'} for w in words]):.0%} of {len(words)}" if words else "")
    untrue_, wrong = [f for f in found if f.untrue], [f for f in found if f.accused]
    cells += [f"{len(untrue_) / max(len(found), 1):.1%}", f"{len(wrong) / max(len(found), 1):.1%} of {len(found)}"]
    seeds = " ".join(f"{f.seed}:{','.join(f.untrue)}" for f in untrue_[:6])
    return "| " + " | ".join([*cells, "" if name.startswith("  ") else seeds]) + " |"
