"""How well effects are named: one of the catalogue, none, or one of no catalogue in a simulated campaign.

Each trial plants one effect of 6 to 12 times the sigma of its own estimate in a campaign of another unit, on
another tilted cube and surface plate. ``drivers.simulated`` plants, ``procedures.effects`` names: they share no
code.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from tests.benchmarks.diagnosing.plants import PLANTS
from tests.benchmarks.diagnosing.sigmas import Sigmas, sigmas_of
from tests.benchmarks.diagnosing.trials import Outcome, nothing, planted, unheard
from tests.proof.evidence import Figure, spread

OUTSIDE = ("heading, accelerometers", "heading, all", "dead zone", "temperature rate times temperature")
QUIET = (
    "plain", "certified", "free", "certified free", "warm", "two speeds", "auxiliary", "timed", "two temperatures",
    "two sites", "moved", "moved and turned",
)  # fmt: skip
APART = 10_000  # seeds between kinds: no two share a draw of noise
Trial = Callable[[int], Outcome]


def trials() -> dict[str, Callable[[], Trial]]:
    """Return each kind of campaign, and how its trial is made."""
    every: dict[str, Callable[[], Trial]] = {name: partial(_planted, name) for name in PLANTS}
    every |= {f"none, {name}": partial(partial, nothing, name) for name in QUIET}
    return every | {f"outside, {name}": partial(partial, unheard, name) for name in OUTSIDE}


def _planted(name: str) -> Trial:
    plant = PLANTS[name]
    given = plant.sigma or (1.0 if plant.between else 0.0)
    sigmas = Sigmas({}, given) if given else sigmas_of(plant.effect, plant.design)
    return partial(planted, name, sigmas)


def _run(item: tuple[str, range]) -> tuple[str, list[Outcome]]:
    name, seeds = item
    trial = trials()[name]()
    return name.partition(", ")[0], [trial(number) for number in seeds]


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` campaigns of each kind were taken for."""
    items = [(name, range(begin := seed + i * APART, begin + size)) for i, name in enumerate(trials())]
    every = spread(_run, items)
    quiet, outside, inside = (
        [one for kind, each in every for one in each if is_of(kind)]
        for is_of in (lambda kind: kind == "none", lambda kind: kind == "outside", lambda kind: "." in kind)
    )
    errors = np.array([one.worst for one in inside if not np.isnan(one.worst)])
    close = 100 * float(np.mean(errors < 4))
    return {
        "kinds of campaigns": Figure(len(items)),
        "an effect of the catalogue: named alone or in its group": share(inside, "right", "group", at_least=97),
        "an effect of the catalogue: named alone": share(inside, "right"),
        "an effect of the catalogue: another was named": share(inside, "wrong", at_most=1),
        "its coefficients within 4 u of what was planted": Figure(close, "%", None, 97, len(errors)),
        "nothing planted: an effect of the instrument claimed": share(quiet, "false alarm", at_most=3),
        "nothing planted: something else untrue": share(quiet, "odd"),
        "an effect of no catalogue: reported as unexplained": share(outside, "unexplained"),
        "an effect of no catalogue: a wrong name": share(outside, "wrong"),
    }


def share(
    outcomes: Sequence[Outcome], *words: str, at_least: float | None = None, at_most: float | None = None
) -> Figure:
    """Return how many outcomes [%] have one of these words."""
    return Figure(100 * np.mean([one.word in words for one in outcomes]), "%", at_most, at_least, of=len(outcomes))
