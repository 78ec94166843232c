"""A cube carried by hand from placing to placing: made by scipy's rotations, without `procedures.frames`.

The hand trembles by 20 to 60 deg/s at 2 to 8 Hz. The gyroscopes integrate fine steps of the attitude relative to
inertial space and count; nothing here is shared with the solve.
"""

import itertools
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, Fixture, MoveRecord, ProcedureSigma, Site
from procedures.campaign.observations import TriadDwells
from procedures.counts.sample_records import CountSeries
from procedures.frames import ATTITUDES
from tests.procedures.independent import COMPASS, NO_SERIES, dwells

LATITUDE, ARW, DWELL_S = 0.55, 1e-4, 100.0  # rad, deg/sqrt(s), s
EARTH = 7.292115e-5 * np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
WANDER_DEG_S, SEAT, HEADING = 0.01 / 3600, 5e-6, float(np.radians(0.05))
FACE, SLAB, ACCEL_STD_G = 3e-5, 3e-5, 1e-7


@dataclass(frozen=True, eq=False)
class Carried:
    """A campaign with its reduced dwells and the true k (3), E of the mean cube (9), D [deg/h] (3), skews (3)."""

    campaign: Campaign
    accelerometer: TriadDwells
    gyroscope: TriadDwells
    truth: FloatArray
    skew: FloatArray


def attitude(letters: str, faces: FloatArray, slab: FloatArray, heading: float, seat: FloatArray) -> Rotation:
    """East-North-Up to the cube that stands with x, y, z along ``letters``."""
    C = np.array([COMPASS[letter] for letter in letters], dtype=float)
    up = C[:, 2]
    vertical = int(np.argmax(np.abs(up)))
    tilt = np.zeros(3)
    tilt[[i for i in range(3) if i != vertical]] = faces[2 * vertical + (0 if up[vertical] > 0 else 1)] + seat
    on_slab = Rotation.from_rotvec([0, 0, -heading]) * Rotation.from_rotvec([-slab[1], slab[0], 0])
    return Rotation.from_rotvec(np.cross(up, tilt)) * Rotation.from_matrix(C) * on_slab


def carried(
    begin: Rotation,
    end: Rotation,
    seconds: float,
    hz: float,
    rng: np.random.Generator,
    fine: int = 2400,
    *,
    per_sample: bool = True,
) -> FloatArray:
    """Return what the cube turns in every sample (n, 3) [rad], relative to inertial space.

    Not ``per_sample``: in every one of ``fine`` steps a second.
    """
    parts = round(fine / hz)
    t = np.arange(round(seconds * hz) * parts + 1) / (hz * parts)
    u = np.clip((t / seconds - 0.1) / 0.8, 0, 1)
    way = (end * begin.inv()).as_rotvec()
    if np.linalg.norm(way) > np.pi - 0.02 and rng.random() < 0.5:  # the other way round
        way *= 1 - 2 * np.pi / np.linalg.norm(way)
    tremor = np.zeros((len(t), 3))
    for axis in range(3):
        for hz_of in rng.uniform(2, 8, 3):
            size = np.radians(rng.uniform(20, 60)) / 3 / (2 * np.pi * hz_of)
            tremor[:, axis] += size * np.sin(2 * np.pi * hz_of * t + rng.uniform(0, 2 * np.pi))
    held = np.sin(np.pi * u) ** 2
    smooth = u**3 * (10 - 15 * u + 6 * u * u)
    C_bn = Rotation.from_rotvec(tremor * held[:, None]) * Rotation.from_rotvec(smooth[:, None] * way) * begin
    C_bi = C_bn * Rotation.from_rotvec(-EARTH * t[:, None])
    steps: FloatArray = -(C_bi[1:] * C_bi[:-1].inv()).as_rotvec()
    return steps.reshape(-1, parts, 3).sum(axis=1) if per_sample else steps


def campaign(seed: int, order: tuple[str, ...], seconds: float = 25.0, hz: float = 50.0) -> Carried:
    """Draw a unit, a cube, placings in ``order`` and the moves between them."""
    rng = np.random.default_rng(seed)
    k = 36000 + 500 * rng.standard_normal(3)
    E = np.eye(3) + 7e-4 * rng.standard_normal((3, 3)) * (1 - np.eye(3))
    E /= np.linalg.norm(E, axis=1)[:, None]
    D, K = 2e-4 * rng.standard_normal(3), k[:, None] * E
    faces, slab = FACE * rng.standard_normal((6, 2)), SLAB * rng.standard_normal(2)
    stands = [
        attitude(each, faces, slab, HEADING * rng.standard_normal(), SEAT * rng.standard_normal(2))
        for each in order
    ]
    names = [f"dwell_{i:02d}" for i in range(len(order))]
    moves, period = list[MoveRecord](), 1 / hz
    for i, (begin, end) in enumerate(itertools.pairwise(stands)):
        angle = np.degrees(carried(begin, end, seconds, hz, rng))
        bias = k * (D + WANDER_DEG_S * rng.standard_normal(3)) * period
        output = angle @ K.T + bias + k * ARW * np.sqrt(period) * rng.standard_normal(angle.shape)
        counts = np.diff(np.floor(np.vstack((np.zeros(3), output.cumsum(axis=0))) + rng.random(3)), axis=0)
        t = period * np.arange(1.0, len(counts) + 1)
        series = CountSeries(t, counts.astype(np.int64), None, np.full(len(t), np.nan), period)
        moves.append(MoveRecord(f"move_{i:02d}", names[i], names[i + 1], series))
    white = ARW / np.sqrt(DWELL_S)
    noise = np.hypot(white, WANDER_DEG_S) * rng.standard_normal((len(order), 3))
    rates = np.array([K @ np.degrees(C.apply(EARTH)) for C in stands]) + k * (D + noise)
    forces = 1000 * np.array([C.apply([0, 0, 1.0]) for C in stands]) + 1000 * ACCEL_STD_G * rng.standard_normal(
        (len(order), 3)
    )
    steps = tuple(DwellRecord(n, ATTITUDES.index(a) + 1, NO_SERIES) for n, a in zip(names, order, strict=True))
    procedure = ProcedureSigma(HEADING, seat=SEAT)
    site = Site(LATITUDE, 9.80665, 1e-9)
    told = Campaign("M", "S", True, site, steps, (), procedure, Fixture(), moves=tuple(moves))
    normals = np.eye(3)
    q = (faces[::2] - faces[1::2]) / 2
    for pair in range(3):
        normals[[i for i in range(3) if i != pair], pair] = q[pair]
    K_mean = K @ (normals / np.linalg.norm(normals, axis=0))
    E_mean = K_mean / np.linalg.norm(K_mean, axis=1)[:, None]
    skew = np.array([q[0, 0] + q[1, 0], q[0, 1] + q[2, 0], q[1, 1] + q[2, 1]])
    truth = np.concatenate((k, E_mean.ravel(), D * 3600))
    return Carried(told, _seen(forces, 1000 * ACCEL_STD_G, steps), _seen(rates, 36000 * white, steps), truth, skew)


def _seen(rate: FloatArray, std: float, steps: tuple[DwellRecord, ...]) -> TriadDwells:
    seen = dwells(rate, std, [step.position for step in steps])
    return replace(seen, dwells=tuple((0, step) for step in steps), noise=np.full(3, 36000 * ARW))
