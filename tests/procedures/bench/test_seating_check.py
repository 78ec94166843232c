"""The seat of the cube; up vectors are written a second time, by components, in `tests.procedures.independent`."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench, world_with_effects
from drivers.simulated.truth import Truth, imu_from_cube
from procedures.arrays import FloatArray
from procedures.bench.seating_check import PositionRates, Seating, judge, seating
from procedures.campaign.campaign import FaceCertificate, Fixture
from procedures.campaign.plan_steps import Dwell
from procedures.counts.count_rate import estimate_counts
from procedures.counts.sample_records import CountSeries
from procedures.positions import FACES, cross_axes, face_normal, face_of
from procedures.units import RAD_PER_ARCSEC
from tests.procedures.independent import specific_force

HEADING_STD = float(np.radians(0.05))
K = np.array([1020.0, 985.0, 1010.0])  # count/(g s)
PLAIN = Fixture()


class Unit:
    """A random unit on a random bench: rates without counting, with white noise of ``noise`` [g]."""

    def __init__(self, seed: int, noise: float, C_sb: FloatArray | None = None, k: FloatArray = K) -> None:
        self.rng = np.random.default_rng(seed)
        self.faces, self.slab = 3e-5 * self.rng.standard_normal((6, 2)), 3e-5 * self.rng.standard_normal(2)
        self.E = np.eye(3) + 2e-3 * self.rng.standard_normal((3, 3))
        self.D = 2e-3 * self.rng.standard_normal(3)
        self.C_sb, self.k, self.noise = np.eye(3) if C_sb is None else C_sb, k, noise

    def rests(self, position: int, tilt: tuple[float, float] = (0.0, 0.0)) -> PositionRates:
        """A dwell, the cube tilted by ``tilt`` (2,) [rad] in addition to its face's own."""
        faces = self.faces.copy()
        faces[FACES.index(face_of(position))] += tilt
        heading = HEADING_STD * self.rng.standard_normal(1)
        u = specific_force(faces, self.slab, heading, [position])[0]
        std = self.noise * np.abs(self.k)
        rate = self.k * (self.E @ self.C_sb @ u + self.D) + std * self.rng.standard_normal(3)
        return position, rate, std


def seen(accepted: list[PositionRates], now: PositionRates, fixture: Fixture = PLAIN) -> Seating:
    found = seating(accepted, now, fixture, HEADING_STD)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("axes", "k"),
    [
        (("+x", "+y", "+z"), K),
        (("-y", "+x", "+z"), K),
        (("+z", "+x", "+y"), K * np.array([1, -1, 1])),  # a sensor that counts backwards
    ],
)
def test_a_tilt_of_the_cube_is_measured_along_its_own_axes(axes: tuple[str, str, str], k: FloatArray) -> None:
    C_sb = imu_from_cube(axes)
    unit, tilt = Unit(1, 1e-9, C_sb, k), (60 * RAD_PER_ARCSEC, -25 * RAD_PER_ARCSEC)
    accepted = [unit.rests(p) for p in (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11)]
    found = seen(accepted, unit.rests(12, tilt), Fixture(C_sb=C_sb))
    assert np.abs(found.off - tilt).max() < 0.3 * RAD_PER_ARCSEC
    assert found.std.max() < 0.3 * RAD_PER_ARCSEC
    assert found.axes == "xy"


@pytest.mark.parametrize("order", [(1, 2, 3, 4), (9, 10, 5, 6), (1, 2, 3, 4, 5, 6, 7, 8)])
def test_what_is_off_by_chance_has_the_sigma_that_is_reported(order: tuple[int, ...]) -> None:
    z = []
    for seed in range(40):
        unit = Unit(100 + seed, 2e-6)
        unit.slab *= 10
        found = seen([unit.rests(p) for p in order[:-1]], unit.rests(order[-1]))
        z.append(found.off / found.std)
    rms = np.sqrt(np.mean(np.square(z)))
    assert 0.2 < rms < 1.25  # scale factors of one batch differ by less than the 10 % that are allowed for
    assert np.abs(z).max() < 5


def test_a_certificate_of_the_faces_is_used() -> None:
    unit = Unit(6, 1e-8)
    certified = {f: FaceCertificate(unit.faces[i], 1e-12 * np.eye(2)) for i, f in enumerate(FACES)}
    accepted, now = [unit.rests(p) for p in (1, 3, 5, 7, 9, 11)], unit.rests(2)
    assert np.all(seen(accepted, now, Fixture(certified)).predicted_std < seen(accepted, now).predicted_std)


@pytest.mark.parametrize(
    ("off", "std", "is_off"),
    [
        (2.9, 0.01, False), (3.1, 0.01, True),  # the floor
        (9.0, 2.0, False), (11.0, 2.0, True),  # five sigma
        (59.0, 14.0, False), (61.0, 14.0, True), (61.0, 16.0, False), (81.0, 16.0, True),  # gross
    ],
)  # fmt: skip
def test_off_is_five_sigma_or_grossly_tilted(off: float, std: float, is_off: bool) -> None:
    for axis, sign in ((0, 1), (1, -1)):
        tilt = np.zeros(2)
        tilt[axis] = sign * off * RAD_PER_ARCSEC
        words = judge(
            Seating(tilt, np.full(2, 0.8 * std * RAD_PER_ARCSEC), np.full(2, 0.6 * std * RAD_PER_ARCSEC), "xz")
        )
        assert bool(words) == is_off
        assert not words or f"along {'+' if sign > 0 else '-'}{'xz'[axis]}" in words


def recorded(position: int, series: CountSeries, seconds: float) -> PositionRates:
    assert series.accel is not None
    n = round(seconds / series.period)
    found = [estimate_counts([series.accel[:n, i]], series.period)[0] for i in range(3)]
    return position, np.array([each.rate for each in found]), np.array([each.std for each in found])


@pytest.mark.parametrize("k", [1e3, 1e5])
def test_debris_is_caught_in_seconds_and_a_clean_cube_is_left_alone(k: float) -> None:
    truth = Truth.example(11)
    truth = replace(truth, accel_k=truth.accel_k * k / 1e3)
    bench, accepted = SimulatedBench(truth, 11), list[PositionRates]()
    for position in (1, 2, 5, 6, 9):
        series = bench.perform(Dwell(position, 30.0))
        for seconds in (3.0, 6.0, 30.0) if position in {2, 6} else ():
            assert judge(seen(accepted, recorded(position, series, seconds))) == ""
        accepted.append(recorded(position, series, 30.0))
    tilt = np.zeros(3)
    tilt[cross_axes("z_up")[1]] = 100 * RAD_PER_ARCSEC
    debris = replace(world_with_effects(truth), seatings={10: np.cross(face_normal("z_up"), tilt)})
    series = SimulatedBench(truth, 12, world=debris).perform(Dwell(10, 10.0))
    assert "along +y" in judge(seen(accepted, recorded(10, series, 6.0)))


@pytest.mark.parametrize("bad", [1, 4])
@pytest.mark.parametrize(("tilt_deg", "noise"), [(0.3, 1e-5), (0.3, 1e-7), (2.5, 1e-7)])
def test_a_bad_seat_among_the_dwells_before_never_condemns_a_good_one(
    bad: int, tilt_deg: float, noise: float
) -> None:
    """A bad first pair shows in the seat after it, and no later; nothing is off by what no upright face is."""
    for seed in (2, 3):
        unit, accepted, judged = Unit(seed, noise), list[PositionRates](), []
        for position in range(1, 13):
            now = unit.rests(position, (float(np.radians(tilt_deg)), 0.0) if position == bad else (0.0, 0.0))
            found = seating(accepted, now, PLAIN, HEADING_STD)
            if found is not None:
                assert np.abs(found.off).max() < 0.1
                judged += [position] if judge(found) else []
            accepted.append(now)
        assert len(judged) <= 1
        assert judged == [] or judged[0] in (bad, bad + 1, 4)
