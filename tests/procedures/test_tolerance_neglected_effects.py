"""What Yao 2018 sets aside: the analysis' sigmas against campaigns drawn at random.

The campaigns share no code with the analysis: rotations are scipy's, positions the paper's letters, the estimators
its equations written down again, turns sums over small steps.
"""

from collections.abc import Mapping

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import triad_vector
from procedures.tolerance.drawing_items import ITEMS
from procedures.tolerance.neglected_effects import (
    QUANTITIES,
    SET_ASIDE,
    SetAsideCase,
    combined,
    set_aside_errors,
)
from procedures.twelve_positions.accelerometer_fit import solve_accelerometer
from tests.procedures.independent import TABLE_4_D, TABLE_4_E, body_from_level, campaign, dwells
from tests.refusals import refused

N = 3000
E = TABLE_4_E / np.linalg.norm(TABLE_4_E, axis=1)[:, None]
LATITUDE, OMEGA, TURN_S = 0.55, 7.292115e-5, 40.0
EARTH_N = OMEGA * np.array([0, np.cos(LATITUDE), np.sin(LATITUDE)])
SIZES = {name: item.size for name, item in SET_ASIDE.items()} | {"slab-level": 1.0}  # else too small to see
SIDE, SEAT, TOLERANCE = 400.0, 200.0, 0.04
CASE = SetAsideCase(E, SIDE, SEAT, LATITUDE, TURN_S, np.full(len(ITEMS), TOLERANCE / SIDE))
NOMINAL = np.array([body_from_level(p) for p in range(1, 13)])
ON_THE_WAY = (["t3"], ["t7", "t3", "t10"], ["t1", "t4", "t3"], ["t5", "t8", "t1", "t4", "t3"],
              ["t2", "t42", "t3"], ["t6", "t9", "t2", "t42", "t3"])  # fmt: skip


def compass(rng: np.random.Generator, size: float, shape: tuple[int, ...]) -> FloatArray:
    """Two components of a tilt of any direction, uniform within plus and minus ``size``."""
    length, azimuth = rng.uniform(-size, size, shape), rng.uniform(0, 2 * np.pi, shape)
    return np.stack((length * np.cos(azimuth), length * np.sin(azimuth)), axis=-1)


def turned(vectors: FloatArray) -> FloatArray:
    matrices: FloatArray = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix()
    return matrices.reshape(*vectors.shape[:-1], 3, 3)


class Drawn:
    """N campaigns with items of the given sizes, all others nought: attitudes (N, 12, 3, 3), seats, faces."""

    def __init__(self, sizes: Mapping[str, float], seed: int) -> None:
        self.rng, self.sizes = np.random.default_rng(seed), sizes
        slope = np.zeros((N, 12, 3))
        slope[..., :2] = compass(self.rng, self.size("slab-flatness") / SIDE, (N, 12))
        slope[..., :2] += compass(self.rng, self.size("slab-level") / 1000, (N, 1))
        self.faces = self.face_rotations()
        on_face = np.repeat(self.faces, 2, axis=1)
        self.C = on_face @ NOMINAL @ turned(-slope)
        psi = np.zeros((N, 3))
        for part in ("flatness", "parallelism"):
            psi[:, 1:] += compass(self.rng, self.size(f"seat-base-{part}") / SEAT, (N,))
            stop = self.size(f"seat-stop-{part}") / SEAT
            psi[:, 0] += self.rng.uniform(-stop, stop, N)
        self.seat = turned(psi)

    def size(self, name: str) -> float:
        return self.sizes.get(name, 0.0)

    def uniform(self, name: str, *shape: int) -> FloatArray:
        return self.rng.uniform(-self.size(name), self.size(name), shape)

    def face_rotations(self) -> FloatArray:
        item = {name: self.rng.uniform(-1, 1, N) for way in ON_THE_WAY for name in way}
        vectors = np.zeros((N, 6, 3))
        for face, way in enumerate(ON_THE_WAY):
            angle = self.size("faces-in-turns") * TOLERANCE / SIDE * sum(item[name] for name in way)
            azimuth = self.rng.uniform(0, 2 * np.pi, N)
            across = [i for i in range(3) if i != face // 2]
            vectors[:, face, across[0]] = angle * np.cos(azimuth)
            vectors[:, face, across[1]] = angle * np.sin(azimuth)
        return turned(vectors)

    def accelerometer(self) -> FloatArray:
        """Rates over k (N, 12, 3) [g]."""
        u = np.einsum("qa,nab,njb->njq", E, self.seat, self.C[..., 2])
        drift = self.uniform("accelerometer-wander", N, 12, 3) * 1e-6
        return u + self.uniform("quadratic", N, 1, 3) * 1e-6 * u**2 + TABLE_4_D + drift

    def gyroscope(self) -> tuple[FloatArray, FloatArray]:
        """Rates over k of the positions (N, 12, 3) [rad/s], half differences of the turns (N, 3, 3) [rad]."""
        asymmetry, cubic = (1e-6 * self.uniform(name, N, 1, 3) for name in ("asymmetry", "nonlinearity"))
        speed, dph = 6 * np.pi / TURN_S, np.pi / 180 / 3600

        def output(u: FloatArray) -> FloatArray:
            return u + asymmetry * np.abs(u) + cubic * u**3 / speed**2

        def drifts(steps: int) -> FloatArray:
            return self.uniform("gyroscope-wander", N, steps, 3) * dph

        rest = output(np.einsum("nab,njbc,c->nja", self.seat, self.C, EARTH_N)) + drifts(12)
        columns, phase = [], 2 * np.pi * (np.arange(24) + 0.5) / 24
        level = turned(np.stack((0 * phase, 0 * phase, phase), axis=1))
        for axis in range(3):
            attitude = self.faces[:, 2 * axis] @ NOMINAL[4 * axis]
            earth = np.einsum("nab,nbc,scd,d->nsa", self.seat, attitude, level, EARTH_N)
            spin = np.einsum("nab,nb->na", self.seat, attitude[..., 2])[:, None] * speed
            both = [(output(earth + sign * spin).mean(axis=1) + drifts(1)[:, 0]) * TURN_S for sign in (1, -1)]
            columns.append((both[0] - both[1]) / 2)
        return rest, np.stack(columns, axis=2)


def apart(K: FloatArray, true_E: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scale factors (N, 3) less one, and the part of E's error (N, 3) that turns a row."""
    k = np.linalg.norm(K, axis=2)
    off = K / k[..., None] - true_E
    off -= np.sum(off * true_E, axis=2)[..., None] * true_E
    return k - 1, np.linalg.norm(off, axis=2)


def found(sizes: Mapping[str, float], seed: int) -> dict[str, FloatArray]:
    """Errors (N, 3) of Yao 2018 (3)-(11), and of the gyroscopes by positions and turns, of `Drawn`."""
    drawn = Drawn(sizes, seed)
    a = drawn.accelerometer()
    K = np.stack([(a[:, p] + a[:, p + 1] - a[:, p + 2] - a[:, p + 3]) / 4 for p in (0, 4, 8)], axis=2)
    scale, angle = apart(K, E)
    k = 1 + scale
    two = np.stack([a[:, 4 * q : 4 * q + 4, q].mean(axis=1) for q in range(3)], axis=1)
    rest, turns = drawn.gyroscope()
    K_g = turns / (6 * np.pi)
    scale_g, angle_g = apart(K_g, np.eye(3))
    return {
        "accelerometer.bias_12_position": a.mean(axis=1) / k - TABLE_4_D,
        "accelerometer.bias_two_direction": two / k - TABLE_4_D,
        "accelerometer.scale_factor": scale,
        "accelerometer.misalignment": angle,
        "gyroscope.bias": rest.mean(axis=1),
        "gyroscope.scale_factor": scale_g,
        "gyroscope.misalignment": angle_g,
    }


FLOOR = {"g": 3e-9, "1": 1e-8, "rad": 1e-8, "rad/s": 2e-13}  # of the second order that an item may leave


@pytest.mark.parametrize("name", SET_ASIDE)
def test_each_item_by_itself_does_what_is_stated_of_it_and_nothing_else(name: str) -> None:
    drawn = found({name: SIZES[name]}, 1)
    reported = set_aside_errors({name: SIZES[name]}, CASE)[name]
    assert reported.keys() <= QUANTITIES.keys()
    for quantity, error in drawn.items():
        if name == "faces-in-turns" and quantity.startswith("accelerometer"):
            continue  # the drawing in the positions is `estimator_errors`'
        rms = np.sqrt(np.mean(error**2, axis=0))
        sigma = reported.get(quantity, np.zeros(3))
        floor = FLOOR[QUANTITIES[quantity]]
        assert rms == pytest.approx(sigma, rel=0.04, abs=floor), quantity  # 3000 draws: 1.3 % 1 sigma


def test_all_items_together_add_up_as_variances() -> None:
    sizes = SIZES | {"faces-in-turns": 0.0}
    drawn = found(sizes, 2)
    reported = combined(set_aside_errors(sizes, CASE))
    for quantity, error in drawn.items():
        rms = np.sqrt(np.mean(error**2, axis=0))
        assert rms == pytest.approx(reported[quantity], rel=0.04), quantity


@pytest.mark.parametrize(
    ("name", "draws"), [("slab-flatness", 12), ("quadratic", 12), ("accelerometer-wander", 120)]
)
def test_the_joint_bias_of_the_real_solve_is_off_by_what_is_stated(name: str, draws: int) -> None:
    a = Drawn({name: SIZES[name]}, 3).accelerometer()[:draws]
    reported = set_aside_errors({name: SIZES[name]}, CASE)[name].get("accelerometer.bias", np.zeros(3))
    errors = []
    for rates in a:
        joint = solve_accelerometer([campaign()], dwells(1000 * rates, 1e-3))
        assert joint is not None
        errors.append(triad_vector(joint, "accelerometer", joint).value[12:] - TABLE_4_D)
    rms = np.sqrt(np.mean(np.square(errors)))
    expected = np.sqrt(np.mean(reported**2))
    assert rms == pytest.approx(expected, rel=4 / np.sqrt(2 * 3 * draws), abs=2e-9)


def test_unknown_items_and_sizes_that_are_none_are_refused() -> None:
    with refused(ValueError, None, "slab-colour"):
        set_aside_errors({"slab-colour": 1.0}, CASE)
    with refused(ValueError, None, "slab-flatness", "-1.0 mm"):
        set_aside_errors({"slab-flatness": -1.0}, CASE)
