import numpy as np

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_gains import Gains
from procedures.attitude.gain_tuning import FOLDS, grid_of_taus, tune
from procedures.error_codes import ErrorCode
from procedures.errors import NotObservable
from tests.drivers.simulated.flight import paper_bench
from tests.refusals import refused


def shaken(size: float) -> AttitudeLog:
    """A rest whose gyros are noisy and whose accelerometers are shaken by white noise of ``size`` [m/s2]."""
    log, rng = paper_bench(4, 9, seconds=300.0), np.random.default_rng(1)
    force = log.f_b + size * rng.standard_normal(log.f_b.shape)
    rate = log.omega_b + 0.02 * rng.standard_normal(log.omega_b.shape)
    return AttitudeLog(log.t, rate, force, roll=log.roll, pitch=log.pitch, scored=log.scored)


def test_more_shaking_asks_for_a_longer_time_constant() -> None:
    grid = grid_of_taus(tuple(np.geomspace(0.5, 100, 9)))
    calm, rough = (tune(shaken(size), "none", grid) for size in (0.02, 5.0))
    assert grid[rough.best].k1 < 0.5 * grid[calm.best].k1
    assert not rough.at_edge
    assert rough.by_fold.shape == (9, FOLDS)


def test_the_held_out_error_is_no_smaller_than_the_best_could_be() -> None:
    found = tune(shaken(2.0), "none", grid_of_taus())
    assert found.held_out >= np.sqrt(np.mean(found.by_fold.min(axis=0) ** 2)) - 1e-12
    assert found.held_out >= found.rms[found.best] - 1e-12


def test_without_truth_nothing_is_chosen() -> None:
    log = paper_bench(1, 1, seconds=5.0)
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE, "roll_rad"):
        tune(AttitudeLog(log.t, log.omega_b, log.f_b), "none", [Gains(0.1, 0.1)])
