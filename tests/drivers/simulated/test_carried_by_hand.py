"""A cube carried by trembling hands: its rates lead where it stands, its gravity is there, and pauses last."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drivers.simulated.carried_by_hand import carry
from drivers.simulated.device import ByteDevice
from drivers.simulated.truth import Truth
from procedures.frames import C_bn, nominal_C_lb

PERIOD = 0.01
BEGIN, END = nominal_C_lb(1).T, nominal_C_lb(2).T


@pytest.mark.parametrize("seed", range(4))
def test_the_rates_lead_from_one_attitude_to_the_other(seed: int) -> None:
    made = carry(BEGIN, END, 400, PERIOD, np.random.default_rng(seed), 40.0)
    turned = Rotation.identity()
    before = np.zeros(3)
    for rate in made.rate_b(0, 400, PERIOD):
        step = rate * PERIOD
        turned, before = Rotation.from_rotvec(-(step + np.cross(before, step) / 12)) * turned, step
    off = (Rotation.from_matrix(made.end_C_bn() @ BEGIN.T) * turned.inv()).magnitude()
    assert off < np.radians(1 / 60)  # what tremor cones at 100 Hz, drawn through no spline
    assert made.end_C_bn() is END
    assert np.linalg.norm(np.degrees(made.rates), axis=1).max() > 60
    up = made.seen(np.array([0.0, 0.0, 1.0]), 0, 400)
    assert up[0] == pytest.approx(BEGIN[:, 2], abs=1e-2)
    assert up[-1] == pytest.approx(END[:, 2], abs=1e-2)


def test_hands_that_do_not_tremble_turn_about_one_axis_and_stop_in_the_air() -> None:
    made = carry(BEGIN, END, 900, PERIOD, np.random.default_rng(1), 0.0, pause_s=5.0)
    rates = np.linalg.norm(made.rates, axis=1)
    assert rates[250:650].max() < 1e-9
    assert rates[100] > 0.1
    assert np.linalg.matrix_rank(made.rates, tol=1e-6) == 1


def test_the_command_puts_the_cube_where_it_is_to_stand() -> None:
    device = ByteDevice(Truth.example(1), None, "counts")
    assert device.obey("carry 20 4 40 2").startswith("ok time")
    device.imu.read(round(7.0 / device.truth.sample_period_s))
    last = device.imu.read(50).accel.sum(axis=0) / device.truth.accel_k
    up = C_bn(20, np.zeros(2), np.zeros(2))[:, 2]
    assert last / np.linalg.norm(last) == pytest.approx(up, abs=0.01)
    assert device.imu.position == 20


@pytest.mark.parametrize(
    "command", ["carry 25 4 40", "carry 3 0 40", "carry 3 4 1e4", "carry 3 4 40 -1", "carry 3 x 40"]
)
def test_what_no_hand_does_is_refused_in_a_line(command: str) -> None:
    answer = ByteDevice(Truth.example(1), None, "counts").obey(command)
    assert answer.startswith("error")
    assert "\n" not in answer
