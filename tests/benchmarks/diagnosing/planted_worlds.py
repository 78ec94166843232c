"""Planted worlds of every kind, to hold a diagnosis against: campaigns whose cause is known."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign
from procedures.effects import EFFECTS
from procedures.evidence.residual_rows import Evidence
from tests.benchmarks.diagnosing.designs import DESIGNS, WARM, plain, unit
from tests.benchmarks.diagnosing.outside import outside
from tests.benchmarks.diagnosing.plants import PLANTS, drawn_sizes
from tests.benchmarks.diagnosing.sigmas import Sigmas, sigmas_of
from tests.benchmarks.discovering.laws import LAWS
from tests.benchmarks.discovering.planting import bare_evidence, with_law
from tests.benchmarks.undeclared_kinds.campaigns import truth_of
from tests.benchmarks.undeclared_kinds.innocent import INNOCENT, as_it_is, innocent
from tests.benchmarks.undeclared_kinds.literature import LITERATURE, Kind

OUTSIDE = ("heading, accelerometers", "heading, all", "dead zone", "temperature rate times temperature")
QUIET = (
    "plain", "certified", "free", "certified free", "warm", "two speeds", "auxiliary", "timed", "two temperatures",
    "two sites", "moved", "moved and turned",
)  # fmt: skip
APART = 10_000  # seeds between kinds: no two share a draw of noise
HELD_BY_THE_MODEL = {each.name for each in EFFECTS if each.is_bench_parameter}  # no causes
NAMED_LAWS = {"counts lost": "gyroscope.counts_lost", "bias warms up": "gyroscope.bias_settling",
              "source warms up": "gyroscope.scale_settling"}  # fmt: skip
Rows = Callable[[Evidence], np.ndarray]


@dataclass(frozen=True)
class World:
    """Campaigns with a known cause.

    ``group`` is catalogue, outside, bench or null; ``does`` gives what the cause does to rows.
    """

    group: str
    campaigns: Sequence[Campaign]
    truth: Truth
    right: frozenset[str] = frozenset()
    does: Rows | None = None
    sizes: Mapping[str, float] | None = None


def worlds() -> dict[str, Callable[[int], World]]:
    """Return by kind what makes a world of a seed."""
    return {
        **{name: partial(_planted, name) for name in PLANTS},
        **{f"law, {law.name}": partial(_law, law) for law in LAWS},
        **{f"outside, {name}": partial(_outside, name) for name in OUTSIDE},
        **{f"bench, {name}": partial(_innocent, name) for name in INNOCENT},
        **{f"none, {name}": partial(_quiet, name) for name in QUIET},
        **{f"literature, {name}": partial(_of_literature, kind) for name, kind in LITERATURE.items()},
    }


@lru_cache
def _sigmas(name: str) -> Sigmas:
    plant = PLANTS[name]
    given = plant.sigma or (1.0 if plant.between else 0.0)
    return Sigmas({}, given) if given else sigmas_of(plant.effect, plant.design)


def _planted(name: str, seed: int) -> World:
    plant, made = PLANTS[name], DESIGNS[PLANTS[name].design]
    sizes = drawn_sizes(name, _sigmas(name), np.random.default_rng([seed, 5]))
    truth = unit(seed, **made.truth, effects={plant.effect: sizes})
    bare = unit(seed, **made.truth)
    group = "null" if plant.effect in HELD_BY_THE_MODEL else "catalogue"
    campaigns = made.make(truth, seed)
    does = _differs(campaigns, lambda: made.make(bare, seed))
    return World(group, campaigns, truth, frozenset({plant.effect}), does, sizes)


def _differs(campaigns: Sequence[Campaign], bare: Callable[[], Sequence[Campaign]]) -> Rows:
    """Return by how much rows differ from those of the same campaign without the cause, in sigmas."""

    def does(evidence: Evidence) -> np.ndarray:
        with_it, without = bare_evidence(tuple(campaigns)), bare_evidence(tuple(bare()))
        if not len(with_it.residual) == len(without.residual) == len(evidence.residual):
            return np.zeros(len(evidence.residual))
        return (with_it.residual - without.residual) / evidence.sigma

    return does


def _law(law: Any, seed: int) -> World:
    drawn, truth, campaigns = with_law(law, seed)
    named = NAMED_LAWS.get(law.name)
    return World(
        "catalogue" if named else "outside", campaigns, truth, frozenset(filter(None, [named])), drawn.done
    )


def _outside(name: str, seed: int) -> World:
    size = float(np.random.default_rng([seed, 9]).uniform(1.5e-6, 4e-6)) * (1.0 if "heading" in name else 0.3)
    truth = unit(seed, **(WARM if "temperature" in name else {}))
    campaigns = plain(truth, seed, outside(name, size))
    return World("outside", campaigns, truth, does=_differs(campaigns, lambda: plain(truth, seed)))


def _of_literature(kind: Kind, seed: int) -> World:
    group, campaigns = "catalogue" if kind.truth else "outside", kind.campaigns(seed)
    does = _differs(campaigns, lambda: kind.campaigns(seed, 0.0))
    return World(group, campaigns, truth_of(kind.design, seed), kind.acceptable, does)


def _innocent(name: str, seed: int) -> World:
    one, (truth, campaigns) = INNOCENT[name], innocent(name, seed)
    right = frozenset(filter(None, [one.effect]))
    return World("null" if one.changed is as_it_is or not right else "bench", campaigns, truth, right)


def _quiet(name: str, seed: int) -> World:
    truth = unit(seed, **DESIGNS[name].truth)
    return World("null", DESIGNS[name].make(truth, seed), truth)
