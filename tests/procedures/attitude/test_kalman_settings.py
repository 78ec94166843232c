"""The settings are those of `docs/attitude.md`, whose figures were measured with them."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from procedures.attitude.kalman_state import (
    AIDED_SETTINGS,
    MEMORY,
    SINCE_UPDATE,
    UNAIDED_SETTINGS,
    KalmanSettings,
    new_state,
)
from tests.paths import ROOT

PAGE = " ".join((ROOT / "docs/attitude.md").read_text(encoding="utf-8").split())


@dataclass
class Said:
    """A sentence of the page, and the settings that it states, with an aid and without."""

    text: str
    aided: dict[str, float] = field(default_factory=dict)
    unaided: dict[str, float] = field(default_factory=dict)


SENTENCES = [
    Said("every 50 ms, attitude and velocity are integrated", {"update_s": 0.05}),
    Said("1e-4 rad/sqrt(s) and 0.0015 of the rate", {"gyro_noise": 1e-4, "gyro_noise_per_rate": 0.0015}),
    Said("while turning; half without aid", {}, {"gyro_noise": 5e-5, "gyro_noise_per_rate": 7.5e-4}),
    Said(
        "0.03 rad/s at the start, walking 1e-5 rad/s/sqrt(s)", {"gyro_bias_std": 0.03, "gyro_bias_walk": 1e-5},
        {"gyro_bias_std": 0.03},
    ),
    Said("without aid: bias walk 2.5e-4, scale 0.25 %", {}, {"gyro_bias_walk": 2.5e-4, "gyro_scale_std": 0.0025}),
    Said("gyro scale with aid | 0.2 %", {"gyro_scale_std": 0.002}),
    Said(
        "0.1 m/s/sqrt(s), at rest 0.03; without aid 0.025", {"force_noise": 0.1, "rest_force_noise": 0.03},
        {"force_noise": 0.025},
    ),
    Said("5 mg (2 mg without aid)", {"force_bias_std": 0.05}, {"force_bias_std": 0.02}),
    Said(
        "4 deg over 100 s, 1 deg over 20 s",
        {"attack_std": math.pi / 45, "attack_s": 100.0, "slip_std": math.pi / 180, "slip_s": 20.0},
    ),
    Said("each 1 m/s over a second (gusts)", {"airspeed_noise": 1.0, "gust_noise": 1.0}),
    Said("the velocity at a fix, 0.1 m/s", {"velocity_fix_std": 0.1}),
    Said("course above 3 m/s (within 15 deg)", {"course_speed": 3.0, "course_std": math.pi / 12}),
    Said("counts as if it stood at 3 sigma", {"believed_sigma": 3.0}, {"believed_sigma": 3.0}),
    Said("specific force that stand still for 1.5 s", {"rest_s": 1.5}, {"rest_s": 1.5}),
    Said("goes on for 0.32 s", {"speed_s": 0.32}),
    Said("A first run with 0.22 tells s", {}, {"speed_noise": 0.22}),
    Said(
        "the vertical within 15 deg, the velocity along body x within 1 m/s + 10 %",
        {"tilt_std": math.pi / 12, "velocity_std": 1.0, "velocity_std_per_speed": 0.1},
    ),
    Said("rest is rates within 1 deg/s and specific force within 0.3 m/s2 of their means, below 1 m/s by the aid",
         {"rest_rate": math.pi / 180, "rest_force": 0.3, "rest_speed": 1.0}),
    Said("A rest is 0.01 m/s of velocity over a second, 0.003 without aid, and 2.5e-4 rad/s of rate",
         {"rest_velocity_noise": 0.01, "rest_rate_noise": 2.5e-4}, {"rest_velocity_noise": 0.003}),
    Said("climbing is 10 m/s over a second and 0.4 of the speed",
         {"climb_noise": 10.0, "climb_noise_per_speed": 0.4}),
    Said("accelerometer's bias walks 1e-4 m/s2/sqrt(s), 2e-5 without aid; a gyro's at rest 1e-4 rad/s/sqrt(s)",
         {"force_bias_walk": 1e-4, "rest_bias_walk": 1e-4}, {"force_bias_walk": 2e-5}),
    Said("heading given is within 2 deg", {"heading_std": math.pi / 90}),
]  # fmt: skip


@pytest.mark.parametrize("said", SENTENCES, ids=lambda said: said.text[:40])
def test_the_page_states_the_settings(said: Said) -> None:
    assert said.text in PAGE
    for settings, stated in ((AIDED_SETTINGS, said.aided), (UNAIDED_SETTINGS, said.unaided)):
        for name, value in stated.items():
            assert getattr(settings, name) == pytest.approx(value, rel=1e-12), name


def test_what_nobody_gives_is_nought_or_without_limit() -> None:
    settings = KalmanSettings()
    assert settings.gravity == 9.80665
    assert settings.fix_latency == settings.cruise_std == settings.unseen_rate == 0.0
    assert settings.earth_north == settings.earth_down == 0.0
    assert {settings.rate_limit, settings.force_limit, settings.rest_gyro_noise} == {math.inf}
    assert settings.nominal_s == 0.01


@pytest.mark.parametrize(("with_air", "n"), [(True, 17), (False, 15)])
def test_a_new_state_is_level_at_rest_and_has_room_for_its_errors(with_air: bool, n: int) -> None:
    s = new_state(with_air)
    shapes = {"P": (n, n), "dx": (n,), "A": (6, n), "AP": (6, n), "PH": (n,), "sums": (3, 6), "past": (64, 5)}
    assert {name: getattr(s, name).shape for name in shapes} == shapes
    np.testing.assert_array_equal(s.C_nb, np.eye(3))
    for name in ("P", "v_n", "sums", "past", "dx", "A", "gained"):
        assert not getattr(s, name).any()
    s.flat[:] = np.arange(s.flat.size)  # the same numbers as the record's
    assert s.memory[0].velocity_gain.tolist() == [0.0, 1.0, 2.0]
    names = list(MEMORY.names or ())
    first_kept = MEMORY.fields["mean_rate"][1] if MEMORY.fields else 0
    assert names[0] == "velocity_gain"
    assert first_kept == 8 * SINCE_UPDATE
