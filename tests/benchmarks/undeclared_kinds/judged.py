"""What became of a campaign with an undeclared effect: one word of the name, by what was planted alone.

A name is right if it is the kind's, or if the kind does to the campaign just what that effect does: what is left
of both beside all that is innocent is correlated by 0.98 or more (of several coefficients, the best combination).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drivers.simulated.effects import EFFECTS
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, Finding
from tests.benchmarks.undeclared_kinds.campaigns import DESIGNS, DWELL_S, campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.kind import Kind
from tests.benchmarks.undeclared_kinds.sized import Bench, sized

ALIKE = 0.98
SMALL = 1e-3  # of a plausible size: responses are compared, not sizes
WORDS = (
    "named", "group led by it", "group with it", "group without it", "wrong, likely", "wrong, established",
    "unexplained", "partly", "missed",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one campaign: a word of `WORDS`; ``also`` where the name is right by what it does alone."""

    kind: str
    seed: int
    word: str
    named: tuple[str, ...]
    verdict: str
    sigmas: float
    also: bool = False


def told(kind: Kind, seed: int) -> Outcome:
    """Plant a kind and diagnose."""
    size, sigmas, bench = sized(kind, seed)
    truth = truth_of(kind.design, seed)
    made = campaigns_of(truth, kind.design, seed, kind.planted(seed, truth, size))
    found = diagnose(made.campaigns)
    right, also = set(kind.right), False
    ends = {each.name: float(each.series.t[-1]) for one in made.campaigns for each in one.steps}
    innocent = {*kind.of_bench, *of_bench(kind.design)}
    for finding in found.findings:
        for name in {finding.effect, *finding.aliases} - right - innocent:
            if likeness(bench, kind, size, name, finding, ends) >= ALIKE:
                right, also = {*right, name}, True
    return Outcome(kind.name, seed, word_of(found, right, innocent), said(found), found.verdict, sigmas, also)


def of_bench(design: str) -> tuple[str, ...]:
    """Return what is true of every bench of a design, unplanted."""
    certified = DESIGNS[design].is_certified
    return ("slab.tilt",) if certified else ("slab.tilt", "fixture.parallelism", "fixture.face_tilt")


def word_of(found: Diagnosis, right: set[str], innocent: set[str]) -> str:
    """Return the worst that may be said of a diagnosis, else the best."""
    for confidence in ("established", "likely"):
        if any(f.confidence == confidence and f.effect not in right | innocent for f in found.findings):
            return f"wrong, {confidence}"
    here = [f for f in found.findings if {f.effect, *f.aliases} & right]
    if any(f.effect in right and f.confidence != "ambiguous" for f in here):
        return "named"
    if here:
        return "group led by it" if any(f.effect in right for f in here) else "group with it"
    if found.verdict in {"unexplained", "partly"}:
        return found.verdict
    if any(not ({f.effect, *f.aliases} & innocent) for f in found.findings):
        return "group without it"
    return "missed"


def said(found: Diagnosis) -> tuple[str, ...]:
    """Return the names, a group's with a question mark."""
    return tuple(f.effect + ("?" if f.confidence == "ambiguous" else "") for f in found.findings)


def likeness(
    bench: Bench, kind: Kind, size: float, name: str, finding: Finding, ends: Mapping[str, float]
) -> float:
    """Return how alike an effect and a kind are in what they do: a multiple correlation, 0 where it is unknown.

    ``ends`` are the times [s] at which steps end.
    """
    ways = [bench.with_effect(name, sizes) for sizes in _ways(name, finding, ends)]
    ways = [way / np.linalg.norm(way) for way in ways if way.any()]
    if not ways:
        return 0.0
    added = bench.added(kind.planted(bench.seed, bench.truth, size))
    M = bench.products(np.stack((added, *ways), axis=1))
    inside = float(M[0, 1:] @ np.linalg.pinv(M[1:, 1:], rcond=1e-9) @ M[0, 1:])
    return float(np.sqrt(max(inside, 0.0) / max(M[0, 0], 1e-30)))


def _ways(name: str, finding: Finding, ends: Mapping[str, float]) -> list[dict[str, float]]:
    """Return the sizes by which the simulator plants each coefficient of an effect, bent as the finding is."""
    effect = EFFECTS.get(name)
    if effect is None or name in {"auxiliary.channel", "placement.label", "clock.rate"}:
        return []
    options = dict(effect.options)
    if name == "placement.dwell":
        place = finding.where.get("position", 1)
        options["position"] = float(place[0] if isinstance(place, list) else int(str(place)))
    if name == finding.effect:
        fitted = dict(zip(finding.coefficients, finding.value.tolist(), strict=True))
        options |= {key: value for key, value in fitted.items() if key in options}
    if name.endswith("jump"):
        options["after_s"] = ends.get(str(finding.where.get("after")), 0.0) + 1.0
        if "in" in finding.where:
            within = float(str(finding.where["after_s"]))
            options["after_s"] = ends.get(str(finding.where["in"]), 0.0) - DWELL_S + within
        options["scale"] = float(finding.shape == "scale factor")
    keys = [key for key in effect.keys if len(key) > 1] or list(effect.keys)
    return [{**options, key: _small(effect.unit, options)} for key in keys]


def _small(unit: str, options: Mapping[str, float]) -> float:
    """Return a size of a unit that changes nothing but the count."""
    if unit == "ppm" or options.get("scale") or unit.startswith("ppm"):
        return 10.0
    return 1e-5 if unit.startswith(("g", "rad")) else 0.1
