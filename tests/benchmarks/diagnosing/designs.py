"""Campaign designs, each with what it takes to excite some effects; made by `drivers.simulated` alone."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.effects import Planted
from drivers.simulated.effects.bench import auxiliary
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign
from procedures.campaign.plan_steps import Turn, turn_steps
from procedures.frames import rotation
from procedures.positions import TURN_START
from tests.procedures.diagnosis.planted import with_reference_time

MOVED_PERIOD = 0.02  # s
PERIOD = 0.1  # s: ten times fewer samples than a FOG's 100 Hz, the same noise a second
FINE = 5.0  # times finer counts, so that they are still no more than noise
FACES, SLAB = 4e-5, 3e-5  # rad, 1 sigma
SLOW, SPEED, FAST = 15.0, 30.0, 60.0  # deg/s
LONG_S = 1000.0
CERTIFICATE = 5e-6  # rad
JITTER = 1e-3  # s, 1 sigma of a row's reference time
Made = tuple[Campaign, ...]
Make = Callable[[Truth, int], Made]


@dataclass(frozen=True, slots=True)
class Design:
    """How a campaign is made of a truth and a seed, and what of the truth it needs."""

    make: Make
    truth: Mapping[str, float]


def unit(seed: int, **fields: object) -> Truth:
    """Return another unit on another tilted cube and slab, quicker to simulate but as noisy."""
    rng = np.random.default_rng([seed, 77])
    base = Truth.example(seed)
    fine = {"accel_k": base.accel_k * FINE, "gyro_k": base.gyro_k * FINE}
    noise = base.accel_noise_g * np.sqrt(base.sample_period_s / PERIOD)
    return replace(
        base, sample_period_s=PERIOD, accel_noise_g=float(noise), faces_rad=FACES * rng.standard_normal((6, 2)),
        slab_tilt_rad=SLAB * rng.standard_normal(2), **{**fine, **fields},
    )  # fmt: skip


def plain(truth: Truth, seed: int, also: Planted = (), **more: Any) -> Made:
    """Twelve positions and six turns; ``more`` is the simulator's."""
    return (simulate_campaign(truth, seed, draw_stated=False, also=also, **more),)


repeated: Make = partial(plain, repeats=1)  # the usual plan: the first position once more at the end
certified: Make = partial(plain, certificate_sigma=CERTIFICATE)


def stated(truth: Truth, seed: int) -> Made:
    """Certified as a laboratory would: each face is off its certificate by a draw of the certificate's sigma."""
    return tuple(_drawn(campaign, seed) for campaign in certified(truth, seed))


def _drawn(campaign: Campaign, seed: int) -> Campaign:
    rng = np.random.default_rng([seed, 19])
    faces = {
        name: replace(face, up_tilt=face.up_tilt + CERTIFICATE * rng.standard_normal(2))
        for name, face in campaign.fixture.faces.items()
    }
    return replace(campaign, fixture=replace(campaign.fixture, faces=faces))


def with_free(truth: Truth, seed: int) -> Made:
    """In addition to the twelve, sixteen rests near 45 deg between the faces."""
    return plain(truth, seed, free=_between_faces(seed)[:16])


def certified_free(truth: Truth, seed: int) -> Made:
    """Twenty such rests on a cube with a certificate: what separates most."""
    return tuple(_drawn(each, seed) for each in certified(truth, seed, free=_between_faces(seed)))


def _between_faces(seed: int) -> list[np.ndarray]:
    """Return attitudes C_bn (3, 3) near 45 deg: eight on the corners, twelve on the edges."""
    rng = np.random.default_rng([seed, 3])
    corners = [np.array([a, b, c]) for a in (1, -1) for b in (1, -1) for c in (1, -1)]
    edges = [np.roll([s, t, 0], r) for s in (1, -1) for t in (1, -1) for r in range(3)]
    return [_with_up(up / np.linalg.norm(up), rng) for up in (*corners, *edges)]


def _with_up(up: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return C_bn (3, 3) with ``up`` (3,) in the cube's axes, about 3 deg off, at a random heading."""
    up = rotation(0.05 * rng.standard_normal(3)) @ up
    east = np.cross(rng.standard_normal(3), up)
    east /= np.linalg.norm(east)
    return np.stack((east, np.cross(up, east), up), axis=1)


def two_speeds(truth: Truth, seed: int) -> Made:
    """Every turn slowly and fast."""
    turns = [Turn(a, d, 3, TURN_START[a], 5.0, speed) for a in "xyz" for speed in (SLOW, FAST) for d in "+-"]
    return plain(truth, seed, turns=turns)


def turned_thrice(truth: Truth, seed: int) -> Made:
    """The usual plan, its turns three times over: fifteen numbers in addition to three scale factors."""
    return repeated(truth, seed, turns=[replace(each, speed_deg_s=SPEED) for each in 3 * turn_steps()])


def moved(truth: Truth, seed: int, turns: Sequence[Turn] = ()) -> Made:
    """Twelve positions and the moves between them, at 50 Hz: a hand's moves are too brisk for less."""
    noise = truth.accel_noise_g * np.sqrt(truth.sample_period_s / MOVED_PERIOD)
    truth = replace(truth, sample_period_s=MOVED_PERIOD, accel_noise_g=float(noise))
    return plain(truth, seed, turns=turns, moves=True)


def timed(truth: Truth, seed: int) -> Made:
    """With reference time in addition to the counts, true to `JITTER`."""
    ppm = truth.effects.get("clock.rate", {}).get("value", 0.0)
    return tuple(with_reference_time(campaign, ppm, seed, JITTER) for campaign in plain(truth, seed))


def clock_sigma(campaign: Campaign) -> float:
    """Return 1 sigma [ppm] of a line through all reference times, by the textbook."""
    t = np.concatenate([d.series.t[np.isfinite(d.series.extra["utc_s"])] for d in campaign.dwells])
    return float(1e6 * JITTER / np.sqrt(np.sum((t - t.mean()) ** 2)))


def with_auxiliary(truth: Truth, seed: int) -> Made:
    """With an auxiliary channel in addition to the counts."""
    return tuple(_auxiliary(campaign) for campaign in plain(truth, seed))


def _auxiliary(campaign: Campaign) -> Campaign:
    def add(record):  # type: ignore[no-untyped-def]
        series = record.series
        return replace(record, series=replace(series, extra={"aux_pump": auxiliary(series.t)}))

    return replace(campaign, dwells=tuple(map(add, campaign.dwells)), turns=tuple(map(add, campaign.turns)))


def two_sites(truth: Truth, seed: int) -> Made:
    """The same unit at two sites; what is planted of the site is at the second."""
    home = replace(truth, effects={k: v for k, v in truth.effects.items() if k != "site.gravity"})
    return _twice(home, replace(truth, latitude_deg=48.0, gravity_m_s2=9.8081), seed)


def two_temperatures(truth: Truth, seed: int) -> Made:
    """The same unit twice, the second time 20 K warmer."""
    return _twice(truth, replace(truth, temperature_start_c=truth.temperature_start_c + 20.0), seed)


def _twice(first: Truth, second: Truth, seed: int) -> Made:
    both = (*plain(first, seed), *plain(second, seed + 1_000_000))
    return tuple(replace(c, fixture=replace(c.fixture, id="CUBE")) for c in both)


WARM = {
    "temperature_rise_k": 6.0, "temperature_tau_s": 900.0,
    "temperature_swing_k": 2.0, "temperature_swing_period_s": 1300.0,
}  # fmt: skip
LONG: Make = partial(repeated, dwell_s=LONG_S)  # a heading is seen by what it turns of the Earth's rate
STEADY: dict[str, Make] = {
    "plain": plain, "repeated": repeated, "turned thrice": turned_thrice, "long dwells": LONG, "certified": stated,
    "free": with_free, "certified free": certified_free, "two speeds": two_speeds, "timed": timed,
    "auxiliary": with_auxiliary, "two sites": two_sites, "two temperatures": two_temperatures, "moved": moved,
    "moved and turned": partial(moved, turns=turn_steps()),  # as a guided campaign records them
}  # fmt: skip
WHILE_WARM: dict[str, Make] = {"warm": plain, "certified warm": stated, "moved while warm": moved}
DESIGNS = {
    name: Design(make, truth) for made, truth in ((STEADY, {}), (WHILE_WARM, WARM)) for name, make in made.items()
}
