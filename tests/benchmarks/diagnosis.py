"""How well effects are named: one of the catalogue, none, or one of no catalogue in a simulated campaign.

Each trial plants one effect of 6 to 12 times the sigma of its own estimate in a campaign of another unit, on
another tilted cube and surface plate. ``drivers.simulated`` plants, ``procedures.effects`` names: they share no code.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from tests.benchmarks.diagnosing.nulls import NULLS, null
from tests.benchmarks.diagnosing.plants import PLANTS
from tests.benchmarks.diagnosing.sigmas import Sigmas, sigmas_of
from tests.benchmarks.diagnosing.trials import Outcome, planted, unheard
from tests.proof.evidence import Figure, spread

OUTSIDE = ("heading, accelerometers", "heading, all", "dead zone", "temperature rate times temperature")
APART = 10_000  # seeds between kinds: no two share a draw of noise
Trial = Callable[[int], Outcome]


def trials() -> dict[str, Callable[[], Trial]]:
    """Return each kind of campaign, and how its trial is made: those with moves last, so that they move no seeds."""
    every: dict[str, Callable[[], Trial]] = {f"none, {name}": partial(partial, null, name) for name in NULLS}
    every |= {name: partial(_planted, name) for name in PLANTS}
    every |= {f"outside, {name}": partial(partial, unheard, name) for name in OUTSIDE}
    return dict(sorted(every.items(), key=lambda item: "moved" in item[0]))


def _planted(name: str) -> Trial:
    plant = PLANTS[name]
    given = plant.sigma or (1.0 if plant.between else 0.0)
    sigmas = Sigmas({}, given) if given else sigmas_of(plant.effect, plant.design, plant.beside, plant.but_for)
    return partial(planted, name, sigmas)


def _run(item: tuple[str, range]) -> list[Outcome]:
    name, seeds = item
    trial = trials()[name]()
    return [trial(number) for number in seeds]


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` campaigns of each kind were taken for."""
    items = [(name, range(begin := seed + i * APART, begin + size)) for i, name in enumerate(trials())]
    every = [outcome for each in spread(_run, items) for outcome in each]
    nothing = [one for one in every if one.effect.startswith("none")]
    outside = [one for one in every if one.effect.startswith("outside")]
    inside = [one for one in every if one.effect in PLANTS]
    errors = np.array([one.worst for one in inside if not np.isnan(one.worst)])
    close = 100 * np.mean(errors < 4)
    return {
        "kinds of campaigns": Figure(len(items)),
        "an effect of the catalogue: named alone or first of a group": share(
            inside, "right", "group", at_least=97
        ),
        "an effect of the catalogue: named alone": share(inside, "right"),
        "an effect of the catalogue: another was named": share(inside, "wrong", at_most=1),
        "its coefficients within 4 u of what was planted": Figure(close, "%", at_least=97.0),
        "nothing but the bench: an effect of the instrument claimed": share(nothing, "false alarm", at_most=3),
        "nothing but the bench: something else untrue": share(nothing, "odd"),
        "an effect of no catalogue: reported as unexplained": share(outside, "unexplained"),
        "an effect of no catalogue: a wrong name": share(outside, "wrong"),
    }


def share(
    outcomes: Sequence[Outcome], *words: str, at_least: float | None = None, at_most: float | None = None
) -> Figure:
    """Return how many outcomes [%] have one of these words."""
    return Figure(100 * np.mean([one.word in words for one in outcomes]), "%", at_most, at_least, of=len(outcomes))
