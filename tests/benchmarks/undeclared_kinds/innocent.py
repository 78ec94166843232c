"""Campaigns in which nothing is wrong with the instrument: a quiet bench, and the hands and the bench alone."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign
from procedures.positions import FACES, cross_axes, face_of
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of

Changed = Callable[[Truth, np.random.Generator], Truth]
TIMES = (3.0, 6.0)  # worse than stated


@dataclass(frozen=True, slots=True)
class Innocent:
    """A campaign's design, what is done to its bench that its files do not say, and by which effect that shows."""

    design: str
    changed: Changed
    effect: str = ""


def as_it_is(truth: Truth, rng: np.random.Generator) -> Truth:
    """Leave the bench as every unit's is."""
    return truth


def _latitude(truth: Truth, rng: np.random.Generator) -> Truth:
    off = float(rng.choice([-1, 1]) * rng.uniform(0.3, 0.5))
    return replace(truth, latitude_deg=truth.latitude_deg + off, gravity_m_s2=truth.local_gravity)


def _closure(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, closure_std_deg=truth.closure_std_deg * float(rng.uniform(*TIMES)))


def _heading(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, heading_std_deg=truth.heading_std_deg * float(rng.uniform(*TIMES)))


def _azimuth(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, slab_azimuth_rad=float(rng.uniform(-0.02, 0.02)))


def _seat(truth: Truth, rng: np.random.Generator) -> Truth:
    position = int(rng.integers(1, 13))
    across = ["xyz"[i] for i in cross_axes(face_of(position))]
    seat = {axis: float(rng.uniform(-5e-4, 5e-4)) for axis in across} | {"position": float(position)}
    return replace(truth, effects={"placement.dwell": seat})


def _label(truth: Truth, rng: np.random.Generator) -> Truth:
    position, actual = rng.choice(np.arange(1, 13), 2, replace=False)
    return replace(truth, effects={"placement.label": {"position": float(position), "actual": float(actual)}})


def _tilts(truth: Truth, rng: np.random.Generator) -> Truth:
    return replace(truth, faces_rad=5e-4 * rng.uniform(-1, 1, (6, 2)), slab_tilt_rad=5e-4 * rng.uniform(-1, 1, 2))


def _certificate(truth: Truth, rng: np.random.Generator) -> Truth:
    keys = [f"{face}.{'xyz'[i]}" for face in FACES for i in cross_axes(face)]
    wrong = {str(key): float(rng.uniform(-5e-5, 5e-5)) for key in rng.choice(keys, 3, replace=False)}
    return replace(truth, effects={"fixture.face_tilt": wrong})


INNOCENT = {
    "quiet": Innocent("plain", as_it_is),
    "quiet, temperature and a soak": Innocent("soak", as_it_is),
    "quiet, free positions": Innocent("free", as_it_is),
    "quiet, certified": Innocent("certified free", as_it_is),
    "quiet, three speeds": Innocent("speeds", as_it_is),
    "quiet, two temperatures": Innocent("two temperatures", as_it_is),
    "large tilts": Innocent("plain", _tilts),
    "wrong certificate": Innocent("certified free", _certificate, "fixture.face_tilt"),
    "latitude wrong": Innocent("plain", _latitude, "site.latitude"),
    "closure looser": Innocent("plain", _closure, "procedure.closure"),
    "closure looser, three speeds": Innocent("speeds", _closure, "procedure.closure"),
    "headings looser": Innocent("plain", _heading, "procedure.heading"),
    "one seat": Innocent("plain", _seat, "placement.dwell"),
    "azimuth": Innocent("plain", _azimuth, "site.azimuth"),
    "a wrong label": Innocent("plain", _label, "placement.label"),
}


def innocent(name: str, seed: int) -> tuple[Truth, tuple[Campaign, ...]]:
    """Return a good instrument on such a bench, and its campaigns."""
    one = INNOCENT[name]
    stated = truth_of(one.design, seed)
    truth = one.changed(stated, np.random.default_rng([seed, 47]))
    return truth, campaigns_of(truth, one.design, seed, stated=stated).campaigns
