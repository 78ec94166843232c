"""Kinds of error of the literature show in the counts, plant nothing at size zero, and follow their equations."""

from types import SimpleNamespace

import numpy as np
import pytest

from procedures.effects import EFFECTS
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.literature import LITERATURE, Drawn, floor_tilts, lagged, played, unit_slips
from tests.drivers.signal_to_noise import shown

FORM_OF_A_RESIDUAL = "accelerometer.bias_walk"  # found by a diagnosis, in no catalogue


@pytest.mark.parametrize("name", LITERATURE)
def test_a_kind_stands_out_of_the_noise_with_what_a_calibration_absorbs(name: str) -> None:
    found = shown(LITERATURE[name], 1)
    assert found.best > 3
    assert found.left > 5


@pytest.mark.parametrize("name", LITERATURE)
def test_a_kind_of_size_zero_changes_no_count(name: str) -> None:
    kind = LITERATURE[name]
    truth = truth_of(kind.design, 1)
    bare = campaigns_of(truth, kind.design, 1)
    none = campaigns_of(truth, kind.design, 1, kind.planted(1, truth, 0.0))
    for (step, ours), (same, theirs) in zip(none.steps, bare.steps, strict=True):
        assert step == same
        np.testing.assert_array_equal(ours.gyro, theirs.gyro)
        np.testing.assert_array_equal(ours.accel, theirs.accel)


def test_names_are_of_the_catalogue_and_half_of_the_kinds_have_none() -> None:
    names = {effect.name for effect in EFFECTS} | {FORM_OF_A_RESIDUAL}
    assert all(kind.acceptable <= names for kind in LITERATURE.values())
    assert [len(LITERATURE), sum(not kind.truth for kind in LITERATURE.values())] == [15, 7]


def _seen(t, **more):
    t = np.reshape(np.asarray(t, float), (-1, 1))
    return SimpleNamespace(t=t, **more)


def test_a_temperature_that_lags_a_ramp_is_late_by_its_time_constant() -> None:
    t = np.linspace(0, 2000, 41)
    T, rate = lagged(_seen(t, temperature_at=lambda t: 20 + 0.01 * t), 150.0)
    grown = -np.expm1(-t / 150.0)
    np.testing.assert_allclose(T[:, 0], 20 + 0.01 * (t - 150.0 * grown), atol=1e-4)
    np.testing.assert_allclose(rate[:, 0], 0.6 * grown, atol=1e-4)


def test_a_backlash_is_taken_up_after_twice_its_width() -> None:
    def temperature(t):
        return 20 + 0.01 * np.minimum(t, 2000 - t)  # up by 10 K, and down again

    found = played(_seen([50, 100, 900, 1000, 1100, 1200, 1300, 1900], temperature_at=temperature), 1.0)[:, 0]
    np.testing.assert_allclose(found, [0.5, 1, 1, 1, 0, -1, -1, -1], atol=1e-6)


def test_a_floor_that_is_tilted_moves_gravity_level_and_a_slip_turns_it() -> None:
    truth = truth_of("plain", 1)
    up = np.array([[0.6, 0.0, 0.8]])
    seen = _seen([2000.0], f=up, omega=up, magnetic=np.array([[10.0, 30.0, -20.0]]))
    drawn = Drawn(np.random.default_rng(1), truth, 100.0, np.ones(3))
    for made in (floor_tilts, unit_slips):
        added = np.linalg.solve(truth.accel_e, made(drawn)["accel"](seen, None)[0])
        assert 1e-6 < np.linalg.norm(added) < 1.1e-4
        assert abs(added @ up[0]) < 1e-12
