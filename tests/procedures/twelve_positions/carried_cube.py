"""A cube carried by hand from placing to placing: made by scipy's rotations, without `procedures.frames`.

The hand trembles by 20 to 60 deg/s at 2 to 8 Hz. The gyroscopes integrate fine steps of the attitude relative to
inertial space and count; nothing here is shared with the solve. Of a step's rotation vector is subtracted what the
rate's own turning adds to it, a twelfth of the rate across its change: 400 steps a second are then within 0.006
arcsec of 9600 over a move of 25 s.
"""

import itertools
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.campaign.campaign import (
    Campaign,
    DwellRecord,
    Fixture,
    MoveRecord,
    ProcedureSigma,
    Site,
    TurnRecord,
)
from procedures.campaign.observations import TriadDwells
from procedures.counts.sample_records import CountSeries
from procedures.positions import ATTITUDES
from tests.procedures.independent import COMPASS, NO_SERIES, dwells

LATITUDE, ARW, DWELL_S = 0.55, 1e-4, 100.0  # rad, deg/sqrt(s), s
EARTH = 7.292115e-5 * np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
DRIFT_DEG_S, SEAT, HEADING = 0.01 / 3600, 5e-6, float(np.radians(0.05))
FACE, SLAB, ACCEL_STD_G = 3e-5, 3e-5, 1e-7
FINE = 400  # steps a second
TURNS = [
    (axis, sign, letters) for axis, letters in zip("xyz", ("UEN", "SUW", "NWU"), strict=True) for sign in "+-"
]
REVOLUTIONS, TURN_S, TURN_REST_S = 3, 31.0, 5.0


@dataclass(frozen=True, eq=False)
class Carried:
    """A campaign with its reduced dwells and the true k (3), E of the mean cube (9), D [deg/h] (3).

    And the cube's skews (3), the slab's tilt (2) [rad].
    """

    campaign: Campaign
    accelerometer: TriadDwells
    gyroscope: TriadDwells
    truth: FloatArray
    skew: FloatArray
    slab: FloatArray


def attitude(
    letters: str, faces: FloatArray, slab: FloatArray, heading: float | FloatArray, seat: FloatArray
) -> Rotation:
    """East-North-Up to the cube that stands with x, y, z along ``letters``; one of every ``heading`` [rad]."""
    C = np.array([COMPASS[letter] for letter in letters], dtype=float)
    up = C[:, 2]
    vertical = int(np.argmax(np.abs(up)))
    tilt = np.zeros(3)
    tilt[[i for i in range(3) if i != vertical]] = faces[2 * vertical + (0 if up[vertical] > 0 else 1)] + seat
    on_slab = Rotation.from_rotvec(np.multiply.outer(heading, [0, 0, -1.0])) * Rotation.from_rotvec(
        [-slab[1], slab[0], 0]
    )
    return Rotation.from_rotvec(np.cross(up, tilt)) * Rotation.from_matrix(C) * on_slab


def carried(
    begin: Rotation,
    end: Rotation,
    seconds: float,
    hz: float,
    rng: np.random.Generator,
    fine: int = FINE,
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
    steps = integrated(C_bn, t)
    return steps.reshape(-1, parts, 3).sum(axis=1) if per_sample else steps


def integrated(C_bn: Rotation, t: FloatArray) -> FloatArray:
    """Return the integral of the rate relative to inertial space (n, 3) [rad] between times ``t`` (n + 1,) [s]."""
    C_bi = C_bn * Rotation.from_rotvec(-EARTH * t[:, None])
    steps: FloatArray = -(C_bi[1:] * C_bi[:-1].inv()).as_rotvec()
    turning = np.cross(steps[:-1], steps[1:]) / 24  # half of it belongs to each
    steps[1:] -= turning
    steps[:-1] -= turning
    return steps


def campaign(
    seed: int, order: tuple[str, ...], seconds: float = 25.0, hz: float = 50.0, closure: float | None = None
) -> Carried:
    """Draw a unit, a cube, placings in ``order`` and the moves between them.

    With a ``closure`` [rad], 1 sigma, six hand turns follow.
    """
    rng = np.random.default_rng(seed)
    k = 36000 + 500 * rng.standard_normal(3)
    E = np.eye(3) + 7e-4 * rng.standard_normal((3, 3)) * (1 - np.eye(3))
    E /= np.linalg.norm(E, axis=1)[:, None]
    D, K = 2e-4 * rng.standard_normal(3), k[:, None] * E
    faces, slab = FACE * rng.standard_normal((6, 2)), SLAB * rng.standard_normal(2)

    def stood(letters: str) -> Rotation:
        return attitude(letters, faces, slab, HEADING * rng.standard_normal(), SEAT * rng.standard_normal(2))

    def counted(angle: FloatArray) -> CountSeries:
        period = 1 / hz
        bias = k * (D + DRIFT_DEG_S * rng.standard_normal(3)) * period
        output = np.degrees(angle) @ K.T + bias + k * ARW * np.sqrt(period) * rng.standard_normal(angle.shape)
        counts = np.diff(np.floor(np.vstack((np.zeros(3), output.cumsum(axis=0))) + rng.random(3)), axis=0)
        t = period * np.arange(1.0, len(counts) + 1)
        return CountSeries(t, counts.astype(np.int64), None, np.full(len(t), np.nan), period)

    stands = [stood(each) for each in order]
    ends = list(stands)  # of every step
    names = [f"dwell_{i:02d}" for i in range(len(order))]
    turns = list[TurnRecord]()
    for axis, sign, letters in TURNS if closure is not None else []:
        way = (1 if sign == "+" else -1) * 2 * np.pi * REVOLUTIONS + closure * rng.standard_normal()
        heading, seat = HEADING * rng.standard_normal(), SEAT * rng.standard_normal(2)
        t = np.arange(round((TURN_S + 2 * TURN_REST_S) * hz) * 4 + 1) / (4 * hz)
        u = np.clip((t - TURN_REST_S) / TURN_S, 0, 1)
        C_bn = attitude(letters, faces, slab, heading + way * u**3 * (10 - 15 * u + 6 * u * u), seat)
        series = counted(integrated(C_bn, t).reshape(-1, 4, 3).sum(axis=1))
        at = ATTITUDES.index(letters) + 1
        turns.append(TurnRecord(f"turn_{axis}{sign}", axis, sign, REVOLUTIONS, at, series))
        names.append(turns[-1].name)
        stands.append(C_bn[0])
        ends.append(C_bn[-1])
    pairs = itertools.pairwise(zip(stands, ends, names, strict=True))
    moves = tuple(
        MoveRecord(f"move_{i:02d}", name, to, counted(carried(begin, end, seconds, hz, rng)))
        for i, ((_, begin, name), (end, _, to)) in enumerate(pairs)
    )
    white, stands = ARW / np.sqrt(DWELL_S), stands[: len(order)]
    noise = np.hypot(white, DRIFT_DEG_S) * rng.standard_normal((len(order), 3))
    rates = np.array([K @ np.degrees(C.apply(EARTH)) for C in stands]) + k * (D + noise)
    forces = 1000 * np.array([C.apply([0, 0, 1.0]) for C in stands]) + 1000 * ACCEL_STD_G * rng.standard_normal(
        (len(order), 3)
    )
    steps = tuple(DwellRecord(n, ATTITUDES.index(a) + 1, NO_SERIES) for n, a in zip(names, order, strict=False))
    procedure = ProcedureSigma(HEADING, closure or ProcedureSigma(HEADING).closure, seat=SEAT)
    site = Site(LATITUDE, 9.80665, 1e-9)
    specified = Campaign("M", "S", True, site, steps, tuple(turns), procedure, Fixture(), moves=moves)
    normals = np.eye(3)
    q = (faces[::2] - faces[1::2]) / 2
    for pair in range(3):
        normals[[i for i in range(3) if i != pair], pair] = q[pair]
    K_mean = K @ (normals / np.linalg.norm(normals, axis=0))
    E_mean = K_mean / np.linalg.norm(K_mean, axis=1)[:, None]
    skew = np.array([q[0, 0] + q[1, 0], q[0, 1] + q[2, 0], q[1, 1] + q[2, 1]])
    truth = np.concatenate((k, E_mean.ravel(), D * 3600))
    return Carried(
        specified, _seen(forces, 1000 * ACCEL_STD_G, steps), _seen(rates, 36000 * white, steps), truth, skew, slab
    )


def _seen(rate: FloatArray, std: float, steps: tuple[DwellRecord, ...]) -> TriadDwells:
    seen = dwells(rate, std, [step.position for step in steps])
    return replace(seen, dwells=tuple((0, step) for step in steps), noise=np.full(3, 36000 * ARW))
