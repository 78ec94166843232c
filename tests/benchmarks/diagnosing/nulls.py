"""Campaigns in which nothing is wrong with the instrument: a quiet bench, and benches that are anything but."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.truth import Truth
from procedures.diagnosis.diagnose import diagnose
from procedures.frames import FACES, cross_axes, face_of
from tests.benchmarks.diagnosing.designs import DESIGNS, unit
from tests.benchmarks.diagnosing.trials import Outcome, accused, of_bench, untrue

Changed = Callable[[Truth, np.random.Generator], Truth]
LARGE = 5e-4  # rad: dirt, a chip, 0.2 mm on 400 mm
WRONG = 5e-5  # rad: ten sigmas of a certificate


@dataclass(frozen=True, slots=True)
class Null:
    """A design, what is done to its bench, and which names are then true beside the slab's and the faces'."""

    design: str
    changed: Changed
    true: tuple[str, ...] = ()


def quiet(truth: Truth, rng: np.random.Generator) -> Truth:
    """Leave the bench as every unit's is: faces of 4e-5, a slab of 3e-5 rad."""
    return truth


def _tilted(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(
        truth, faces_rad=LARGE * rng.uniform(-1, 1, (6, 2)), slab_tilt_rad=LARGE * rng.uniform(-1, 1, 2)
    )


def _slab(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, slab_tilt_rad=4 * LARGE * rng.uniform(-1, 1, 2))


def _parallelism(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, faces_rad=np.repeat(LARGE * rng.uniform(-1, 1, (3, 2)), 2, axis=0))


def _seating(truth: Truth, rng: np.random.Generator) -> Truth:
    position = int(rng.integers(1, 13))
    across = [str("xyz"[i]) for i in cross_axes(face_of(position))]
    sizes = {axis: float(rng.uniform(-LARGE, LARGE)) for axis in across} | {"position": float(position)}
    return replace(truth, effects={"placement.dwell": sizes})


def _certificate(truth: Truth, rng: np.random.Generator) -> Truth:
    keys = [f"{face}.{'xyz'[i]}" for face in FACES for i in cross_axes(face)]
    wrong = {str(key): float(rng.uniform(-WRONG, WRONG)) for key in rng.choice(keys, 3, replace=False)}
    return replace(truth, effects={"fixture.face_tilt": wrong})


def _azimuth(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, effects={"site.azimuth": {"value": float(rng.uniform(-0.02, 0.02))}})


NULLS: dict[str, Null] = {
    "plain": Null("plain", quiet),
    "certified": Null("certified", quiet),
    "free": Null("free", quiet),
    "certified free": Null("certified free", quiet),
    "warm": Null("warm", quiet),
    "two speeds": Null("two speeds", quiet),
    "auxiliary": Null("auxiliary", quiet),
    "timed": Null("timed", quiet),
    "two temperatures": Null("two temperatures", quiet),
    "two sites": Null("two sites", quiet),
    "large tilts, plain": Null("plain", _tilted),
    "large tilts, certified": Null("certified", _tilted),
    "large tilts, free": Null("free", _tilted),
    "large tilts, warm": Null("warm", _tilted),
    "large tilts, two speeds": Null("two speeds", _tilted),
    "slab of 2e-3 rad": Null("plain", _slab),
    "parallelism alone": Null("plain", _parallelism),
    "one seating off, plain": Null("plain", _seating, ("placement.dwell",)),
    "one seating off, certified": Null("certified", _seating, ("placement.dwell",)),
    "one seating off, free": Null("free", _seating, ("placement.dwell",)),
    "wrong certificate": Null(
        "certified", _certificate, ("fixture.face_tilt", "fixture.parallelism", "placement.dwell")
    ),
    "azimuth off": Null("plain", _azimuth, ("site.azimuth",)),
    "moved": Null("moved", quiet),
    "moved and turned": Null("moved and turned", quiet),
    "moved, one seating off": Null("moved", _seating, ("placement.dwell",)),
}


def null(name: str, seed: int) -> Outcome:
    """Diagnose a campaign with nothing wrong but the bench."""
    what, made = NULLS[name], DESIGNS[NULLS[name].design]
    truth = what.changed(unit(seed, **made.truth), np.random.default_rng([seed, 11]))
    campaigns = made.make(truth, seed, ())
    begun = time.process_time()
    diagnosis = diagnose(campaigns)
    seconds = time.process_time() - begun
    odd = untrue(diagnosis, (*what.true, *of_bench(what.design)))
    word = "false alarm" if accused(diagnosis) else "odd" if odd else "right"
    named = tuple(f.effect + ("?" if f.confidence == "ambiguous" else "") for f in diagnosis.findings)
    return Outcome(f"none, {name}", seed, word, named, float("nan"), diagnosis.verdict, seconds)
