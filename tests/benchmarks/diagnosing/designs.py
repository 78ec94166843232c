"""Campaign designs, each with what it takes to excite some effects; made by `drivers.simulated` alone."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

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


@dataclass(frozen=True, slots=True)
class Design:
    """How a campaign is made of a truth and a seed, and what of the truth it needs."""

    make: Callable[[Truth, int, Planted], Made]
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


def plain(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """Twelve positions and six turns."""
    return (simulate_campaign(truth, seed, draw_stated=False, also=also),)


def repeated(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The usual plan: the first position once more at the end."""
    return (simulate_campaign(truth, seed, draw_stated=False, repeats=1, also=also),)


def certified(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The same on a cube with a certificate."""
    return (simulate_campaign(truth, seed, certificate_sigma=CERTIFICATE, draw_stated=False, also=also),)


def stated(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """Certified as a laboratory would: each face is off its certificate by a draw of the certificate's sigma."""
    return tuple(_drawn(campaign, seed) for campaign in certified(truth, seed, also))


def _drawn(campaign: Campaign, seed: int) -> Campaign:
    rng = np.random.default_rng([seed, 19])
    faces = {
        name: replace(face, up_tilt=face.up_tilt + CERTIFICATE * rng.standard_normal(2))
        for name, face in campaign.fixture.faces.items()
    }
    return replace(campaign, fixture=replace(campaign.fixture, faces=faces))


def with_free(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """In addition to the twelve, sixteen rests near 45 deg between the faces."""
    free = _between_faces(seed)[:16]
    return (simulate_campaign(truth, seed, draw_stated=False, free=free, also=also),)


def certified_free(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """Twenty such rests on a cube with a certificate: what separates most."""
    made = simulate_campaign(
        truth, seed, certificate_sigma=CERTIFICATE, draw_stated=False, free=_between_faces(seed), also=also
    )
    return (_drawn(made, seed),)


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


def two_speeds(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """Every turn slowly and fast."""
    turns = [Turn(a, d, 3, TURN_START[a], 5.0, speed) for a in "xyz" for speed in (SLOW, FAST) for d in "+-"]
    return (simulate_campaign(truth, seed, draw_stated=False, turns=turns, also=also),)


def turned_thrice(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The usual plan, its turns three times over: fifteen numbers in addition to three scale factors."""
    turns = [replace(each, speed_deg_s=SPEED) for each in 3 * turn_steps()]
    return (simulate_campaign(truth, seed, draw_stated=False, repeats=1, turns=turns, also=also),)


def long_dwells(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The usual plan with dwells of 1000 s: a heading is seen by what it turns of the Earth's rate."""
    return (simulate_campaign(truth, seed, dwell_s=LONG_S, draw_stated=False, repeats=1, also=also),)


def moved(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """Twelve positions and the moves between them, at 50 Hz: a hand's moves are too brisk for less."""
    return _moved(truth, seed, also, ())


def moved_and_turned(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The same with six turns, as a guided campaign records them."""
    return _moved(truth, seed, also, turn_steps())


def _moved(truth: Truth, seed: int, also: Planted, turns: Sequence[Turn]) -> Made:
    noise = truth.accel_noise_g * np.sqrt(truth.sample_period_s / MOVED_PERIOD)
    truth = replace(truth, sample_period_s=MOVED_PERIOD, accel_noise_g=float(noise))
    return (simulate_campaign(truth, seed, draw_stated=False, turns=turns, also=also, moves=True),)


def timed(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """With reference time in addition to the counts, true to `JITTER`."""
    ppm = truth.effects.get("clock.rate", {}).get("value", 0.0)
    return tuple(with_reference_time(campaign, ppm, seed, JITTER) for campaign in plain(truth, seed, also))


def clock_sigma(campaign: Campaign) -> float:
    """Return 1 sigma [ppm] of a line through all reference times, by the textbook."""
    t = np.concatenate([d.series.t[np.isfinite(d.series.extra["utc_s"])] for d in campaign.dwells])
    return float(1e6 * JITTER / np.sqrt(np.sum((t - t.mean()) ** 2)))


def with_auxiliary(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """With an auxiliary channel in addition to the counts."""
    return tuple(_auxiliary(campaign) for campaign in plain(truth, seed, also))


def _auxiliary(campaign: Campaign) -> Campaign:
    def add(record):  # type: ignore[no-untyped-def]
        series = record.series
        return replace(record, series=replace(series, extra={"aux_pump": auxiliary(series.t)}))

    return replace(
        campaign, dwells=tuple(add(d) for d in campaign.dwells), turns=tuple(add(t) for t in campaign.turns)
    )


def two_sites(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The same unit at two sites; what is planted of the site is at the second."""
    home = replace(truth, effects={k: v for k, v in truth.effects.items() if k != "site.gravity"})
    first = simulate_campaign(home, seed, draw_stated=False, also=also)
    away = replace(truth, latitude_deg=48.0, gravity_m_s2=9.8081)
    second = simulate_campaign(away, seed + 1_000_000, draw_stated=False, also=also)
    same = [replace(c, fixture=replace(c.fixture, id="CUBE")) for c in (first, second)]
    return tuple(same)


def two_temperatures(truth: Truth, seed: int, also: Planted = ()) -> Made:
    """The same unit twice, the second time 20 K warmer."""
    first = simulate_campaign(truth, seed, draw_stated=False, also=also)
    warm = replace(truth, temperature_start_c=truth.temperature_start_c + 20.0)
    second = simulate_campaign(warm, seed + 1_000_000, draw_stated=False, also=also)
    return tuple(replace(c, fixture=replace(c.fixture, id="CUBE")) for c in (first, second))


WARM = {
    "temperature_rise_k": 6.0,
    "temperature_tau_s": 900.0,
    "temperature_swing_k": 2.0,
    "temperature_swing_period_s": 1300.0,
}
DESIGNS: dict[str, Design] = {
    "plain": Design(plain, {}),
    "repeated": Design(repeated, {}),
    "turned thrice": Design(turned_thrice, {}),
    "long dwells": Design(long_dwells, {}),
    "certified": Design(stated, {}),
    "free": Design(with_free, {}),
    "certified free": Design(certified_free, {}),
    "warm": Design(plain, WARM),
    "certified warm": Design(stated, WARM),
    "two speeds": Design(two_speeds, {}),
    "timed": Design(timed, {}),
    "auxiliary": Design(with_auxiliary, {}),
    "two sites": Design(two_sites, {}),
    "two temperatures": Design(two_temperatures, {}),
    "moved": Design(moved, {}),
    "moved and turned": Design(moved_and_turned, {}),
    "moved while warm": Design(moved, WARM),
}
