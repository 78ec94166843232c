"""Units in a cube, re-mounted or not, made without `procedures`' model of the bench: for tests."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, Fixture, RestRecord
from procedures.counts.sample_records import RateSeries
from procedures.frames import rotation
from tests.procedures.free_units import Unit, unit, ups
from tests.procedures.independent import campaign, specific_force

MOUNTINGS = {
    "as drawn": np.eye(3),
    "about z": np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
    "about x": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
}
QUADRATIC = 5e-5  # g/g^2
NOISE = 1e-6  # g, of a sample
SAMPLES = 100
POSITIONS = range(1, 13)


def values(faces: FloatArray) -> dict[str, float]:
    """Parallelism and skew by name of up tilts (6, 2)."""
    up, down = faces[0::2], faces[1::2]
    p, q = up + down, (up - down) / 2
    found = {
        f"parallelism.{a}.{c}": p[i, k] for i, a in enumerate("xyz") for k, c in enumerate("xyz".replace(a, ""))
    }
    return found | {
        "skew.x.y": q[0, 0] + q[1, 0],
        "skew.x.z": q[0, 1] + q[2, 0],
        "skew.y.z": q[1, 1] + q[2, 1],
    }


def some_unit(rng: np.random.Generator, quadratic: float = QUADRATIC) -> Unit:
    """A unit whose K2 is drawn from the range."""
    return unit(rng, 1000.0, 2e-3, quadratic=quadratic)


def calibrated(
    rng: np.random.Generator,
    it: Unit,
    faces: FloatArray,
    mounting: str = "as drawn",
    serial: str = "S",
    free: int = 0,
) -> Campaign:
    """One campaign: another turn-on, another slab, the IMU seated anew within 0.3 mrad; ``free`` rests besides."""
    C, seat = MOUNTINGS[mounting], rotation(3e-4 * rng.standard_normal(3))
    slab, headings = 3e-5 * rng.standard_normal(2), 1e-3 * rng.standard_normal(12)
    turn_on = replace(it, k=it.k * (1 + 1e-5 * rng.standard_normal(3)), D=it.D + 2e-5 * rng.standard_normal(3))
    u = specific_force(faces, slab, headings, POSITIONS) @ C.T @ seat.T
    series = [_series(rng, turn_on, row) for row in u]
    dwells = tuple(DwellRecord(f"dwell_{p:02d}", p, each) for p, each in zip(POSITIONS, series, strict=True))
    rests = tuple(RestRecord(f"rest_{i}", None, _series(rng, turn_on, up)) for i, up in enumerate(ups(rng, free)))
    empty = campaign(fixture=Fixture(C_sb=C, id="A"))
    return replace(empty, serial=serial, counts=False, dwells=dwells, rests=rests)


def _series(rng: np.random.Generator, it: Unit, u: FloatArray) -> RateSeries:
    accel = it.output(u[None]) + it.k * NOISE * rng.standard_normal((SAMPLES, 3))
    t = 0.01 * np.arange(1, SAMPLES + 1)
    return RateSeries(t, None, accel, np.full(SAMPLES, np.nan), 0.01)


def campaigns(
    rng: np.random.Generator,
    faces: FloatArray,
    units: int = 1,
    mountings: Sequence[str] = ("as drawn",),
    free: int = 0,
) -> list[Campaign]:
    """Every unit once in every mounting."""
    found = list[Campaign]()
    for n in range(units):
        it = some_unit(rng)
        found += [calibrated(rng, it, faces, mounting, f"S{n}", free) for mounting in mountings]
    return found
