import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.diagnosis.candidates import Candidate, Candidates
from procedures.diagnosis.refit import Refit, refit
from procedures.diagnosis.residual_rows import evidence_of
from procedures.effects import EFFECTS
from tests.benchmarks.diagnosing.designs import unit

SIZES = {"accelerometer.quadratic": {"x": 8e-5, "z": -5e-5}, "gyroscope.g_sensitivity": {"xy": 0.8, "zz": -0.5}}
SMALL = 0.1  # sigma: noise is the same draw with the effects in and without


def prepared(effects: dict[str, dict[str, float]]) -> tuple[ReducedSteps, CampaignFits, list[Candidate]]:
    """A unit on a cube whose faces are stated; equal but for the effects, to the last draw."""
    steps = reduce_steps(
        [simulate_campaign(unit(2, effects=effects), 2, certificate_sigma=5e-6, draw_stated=False)]
    )
    base = fit_reduced(steps)
    pool = Candidates(evidence_of(base), base, EFFECTS)
    return steps, base, [pool[name][0] for name in SIZES]


def both(fits: CampaignFits) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """The parameters of each triad and their sigma."""
    assert fits.accelerometer
    assert fits.gyroscope
    joints = (fits.accelerometer, fits.gyroscope.joint)
    return tuple((joint.fit.x, np.sqrt(np.diag(joint.fit.covariance))) for joint in joints)


def solved(effects: dict[str, dict[str, float]]) -> Refit:
    return refit(*prepared(effects))


def test_an_effect_that_was_planted_is_returned_and_the_parameters_are_the_clean_units() -> None:
    found, clean = solved(SIZES), solved({})
    for i, name in enumerate(SIZES):
        value, std = found.values[i] - clean.values[i], np.sqrt(np.diag(found.linear.coefficients(i)[1]))
        keys = "xyz" if len(value) == 3 else [a + b for a in "xyz" for b in "xyz"]
        expected = np.array([SIZES[name].get(key, 0.0) for key in keys])
        assert np.max(np.abs(expected) / std) > 20
        assert np.max(np.abs(value - expected) / std) < 3 * SMALL, name
    for (now, std), (then, _) in zip(both(found.fits), both(clean.fits), strict=True):
        k, b = slice(0, 9), slice(9, 12)
        assert np.max(np.abs(now - then)[k] / std[k]) < 3 * SMALL
        assert np.max(np.abs(now - then)[b] / std[b]) < 3 * SMALL


def test_the_base_fit_alone_is_many_sigma_off() -> None:
    """What the test above would not see is not there to be seen."""
    (_, planted, _), (_, clean, _) = prepared(SIZES), prepared({})
    for (now, std), (then, _) in zip(both(planted), both(clean), strict=True):
        assert np.max(np.abs(now - then)[:12] / std[:12]) > 5


def test_the_parameters_sigma_grows_by_what_the_coefficients_leave_open() -> None:
    steps, base, added = prepared({})
    for (_, wide), (_, narrow) in zip(both(refit(steps, base, added).fits), both(base), strict=True):
        assert np.min(wide / narrow) > 0.95  # a class that is widened in one only
        assert np.max(wide / narrow) > 1.2
