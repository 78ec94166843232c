"""Print the confusion matrix of a diagnosis: `python -m tests.benchmarks.diagnosis --trials 100`.

Each trial plants one effect of 6 to 12 times the sigma of its own estimate in a campaign of another unit, on
another tilted cube and slab. ``drivers.simulated`` plants, ``procedures.effects`` names: they share no code.
"""

import argparse
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

from procedures.diagnosis.result import Finding
from procedures.frames import cross_axes, face_of
from tests.benchmarks.diagnosing.designs import DESIGNS, unit
from tests.benchmarks.diagnosing.outside import outside
from tests.benchmarks.diagnosing.trials import PLANTS, Outcome, diagnosed, judge, sigma_of

LEAST, MOST = 6.0, 12.0  # sigmas
WORDS = ("right", "group", "missed", "wrong", "false alarm")


def planted(name: str, sigma: dict[tuple[int, str], float], seed: int) -> Outcome:
    """Plant one effect, on one coefficient or on several, and diagnose."""
    rng = np.random.default_rng([seed, 5])
    effect, keys = name.split(",")[0], list(PLANTS[name][1])
    several = rng.random() < 0.5
    chosen = rng.choice(keys, rng.integers(1, len(keys) + 1), replace=False) if several else [rng.choice(keys)]
    position = int(rng.integers(1, 13)) if effect == "placement.dwell" else 0
    if position:  # along the vertical it is the heading, of which accelerometers see nothing
        chosen = ["xyz"[i] for i in cross_axes(face_of(position))]
    sizes = {str(k): _drawn(rng) * _sigma(sigma, position, str(k)) for k in chosen}
    if effect == "gyroscope.sagnac_sine":
        sizes = {k: float(np.sqrt(rng.uniform(LEAST, MOST))) * _sigma(sigma, 0, k) for k in sizes}
    if position:
        sizes["position"] = float(position)
    begun = time.process_time()
    diagnosis = diagnosed(name, sizes, seed)
    word, named = judge(diagnosis, effect)
    found = [f for f in diagnosis.findings if f.effect == effect]
    worst = _error(found[0], sizes) if found else float("nan")
    return Outcome(name, seed, word, named, worst, diagnosis.verdict, time.process_time() - begun)


def _drawn(rng: np.random.Generator) -> float:
    return float(rng.choice([-1, 1]) * rng.uniform(LEAST, MOST))


def _error(finding: Finding, sizes: dict[str, float]) -> float:
    """Return the largest error of a coefficient over its sigma, nan where planter and catalogue have two words."""
    if finding.effect.split(".")[0] in {"slab", "fixture"} or finding.shape == "u^3":
        return float("nan")
    planted_sizes = np.array([sizes.get(k, 0.0) for k in finding.coefficients])
    if finding.effect == "accelerometer.cross_product":
        same = {catalogued(key): size for key, size in sizes.items()}
        planted_sizes = np.array([same.get(k, 0.0) for k in finding.coefficients])
    if finding.effect == "placement.dwell" and first_of(finding) != sizes["position"]:
        planted_sizes = -planted_sizes  # the pair's other position, seen from which it is the other way round
    if finding.effect == "site.gravity" and finding.where.get("campaign") == 1:
        planted_sizes = -planted_sizes
    return float(np.max(np.abs(finding.value - planted_sizes) / finding.std))


def first_of(finding: Finding) -> object:
    """Return the position that a finding's coefficients are about, of two that cannot be told."""
    position = finding.where["position"]
    return position[0] if isinstance(position, list) else position


def catalogued(key: str) -> str:
    """Return the catalogue's key of a planted cross product: sensor and two axes."""
    return key[0] + ("".join(sorted(key)) if len(key) == 2 else key[1:])


def _sigma(sigma: dict[tuple[int, str], float], position: int, key: str) -> float:
    for one in (key, catalogued(key) if set(key) <= set("xyz") else key):
        if (position, one) in sigma:
            return sigma[position, one]
    return float(np.median(list(sigma.values())))


def null(design: str, seed: int) -> Outcome:
    """Diagnose a campaign with nothing planted but the bench."""
    from procedures.diagnosis.diagnosis import diagnose

    begun = time.process_time()
    made = DESIGNS[design]
    diagnosis = diagnose(made.make(unit(seed, **made.truth), seed, ()))
    word, named = judge(diagnosis, "")
    return Outcome(
        f"none, {design}", seed, word, named, float("nan"), diagnosis.verdict, time.process_time() - begun
    )


def unheard(name: str, seed: int) -> Outcome:
    """Diagnose a campaign with an effect of no catalogue in it."""
    from procedures.diagnosis.diagnosis import diagnose

    size = float(np.random.default_rng([seed, 9]).uniform(1.5e-6, 4e-6)) * (1.0 if "heading" in name else 0.3)
    begun = time.process_time()
    made = DESIGNS["warm" if "temperature" in name else "plain"]
    diagnosis = diagnose(made.make(unit(seed, **made.truth), seed, outside(name, size)))
    word, named = judge(diagnosis, "")
    word = "unexplained" if diagnosis.verdict == "unexplained" and word == "right" else word
    return Outcome(
        f"outside, {name}", seed, word, named, float("nan"), diagnosis.verdict, time.process_time() - begun
    )


def table(outcomes: list[Outcome]) -> None:
    """Print a line per effect."""
    for name in dict.fromkeys(o.effect for o in outcomes):
        here = [o for o in outcomes if o.effect == name]
        words = Counter(o.word for o in here)
        worst = [o.worst for o in here if np.isfinite(o.worst)]
        covered = f"{np.mean(np.array(worst) < 4) * 100:5.1f}" if worst else "    -"
        others = Counter(n for o in here for n in o.named if n not in {name.split(",")[0]})
        seen = ", ".join(f"{n} {c}" for n, c in others.most_common(4))
        lost = [o.seed for o in here if o.word in {"missed", "wrong", "false alarm"}]
        verdicts = ", ".join(f"{n} {c}" for n, c in Counter(o.verdict for o in here).most_common())
        print(
            f"{name:38s} {len(here):4d}  " + "  ".join(f"{w} {c}" for w, c in words.most_common()),
            f"| <4s {covered} | {verdicts} | {np.mean([o.seconds for o in here]):.1f} s | also: {seen} | {lost}",
            flush=True,
        )


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=5)
    parser.add_argument("--only", default="", help="a part of the name")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.trials)
    with ProcessPoolExecutor(options.processes) as pool:
        for design in ("plain", "certified", "warm", "two speeds", "free"):
            if options.only in f"none, {design}":
                table(list(pool.map(partial(null, design), seeds)))
        for name in PLANTS:
            if options.only in name:
                table(list(pool.map(partial(planted, name, sigma_of(name)), seeds)))
        for name in ("heading, accelerometers", "heading, all", "dead zone", "temperature rate times temperature"):
            if options.only in f"outside, {name}":
                table(list(pool.map(partial(unheard, name), seeds)))


if __name__ == "__main__":
    main()
