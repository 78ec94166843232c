"""Six faces of one heading leave the slab's tilt open: what it moves in second order is in the sigma of k."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, report
from procedures.calibration.triad_calibration import scale_misalignment_bias, second_order
from procedures.twelve_positions.accelerometer_fit import specific_force
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import SECOND_ORDER

SIX_FACES = (1, 3, 5, 7, 9, 11)


@pytest.mark.proof
def test_an_open_slab_tilt_is_in_the_sigma_of_k_in_second_order() -> None:
    off = list[float]()
    for seed in range(12):
        truth = replace(Truth.example(seed), slab_tilt_rad=np.random.default_rng(seed).normal(0.0, 3.5e-3, 2))
        found = report(fit([simulate_campaign(truth, seed, dwell_s=20.0, positions=SIX_FACES, turns=())]))
        assert found.accelerometer is not None
        k = found.accelerometer.scale_factor
        off += ((k.value - truth.accel_k) / k.std).tolist()
    assert np.abs(off).max() < 4


def test_pairs_of_headings_leave_nothing_open() -> None:
    fits = fit([simulate_campaign(Truth.example(3), 3, dwell_s=20.0)])
    assert not any(part.source == SECOND_ORDER for one in budget(fits) for part in one.contributions)


def test_it_is_the_second_moment_of_what_tilts_drawn_at_random_move_beyond_first_order() -> None:
    """k, E and D solved anew for 600 tilts as open as the fit leaves them, less their half of odd order."""
    joint = fit(
        [simulate_campaign(Truth.example(3), 3, dwell_s=20.0, positions=SIX_FACES, turns=())]
    ).accelerometer
    assert joint is not None
    size, rng = joint.bench.shared, np.random.default_rng(5)
    C = joint.fit.covariance[12 : 12 + size, 12 : 12 + size]

    def value(x: np.ndarray) -> np.ndarray:
        return scale_misalignment_bias(x[:9].reshape(3, 3), x[9:12], 1.0)[0]

    def at(tilt: np.ndarray) -> np.ndarray:
        force = specific_force(joint.bench, joint.fit.x[12 : 12 + joint.bench.size] + tilt)
        A = np.column_stack((force, np.ones(len(force))))
        rows = [
            np.linalg.lstsq(A / sigma[:, None], rate / sigma, rcond=None)[0]
            for sigma, rate in zip(joint.sigma.T, joint.seen.rate.T, strict=True)
        ]
        return value(np.concatenate([*(row[:3] for row in rows), [row[3] for row in rows]]))

    rest = np.zeros(joint.bench.size - size)
    tilts = [np.concatenate((each, rest)) for each in rng.multivariate_normal(np.zeros(size), C, 600)]
    level = at(np.zeros(joint.bench.size))
    even = np.array([(at(each) + at(-each)) / 2 - level for each in tilts])
    found = np.diag(second_order(joint, value))
    assert np.sqrt(found) == pytest.approx(np.sqrt(np.mean(even**2, axis=0)), rel=0.25, abs=1e-9)
    assert (np.sqrt(found[:3]) / joint.k > 1e-6).all()
