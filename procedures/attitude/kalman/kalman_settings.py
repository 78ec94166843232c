"""Settings of the Kalman filter: noise of sensors and measurements, and how long it remembers."""

import math
from typing import NamedTuple

from procedures.units import STANDARD_GRAVITY


class KalmanSettings(NamedTuple):
    """What the Kalman filter assumes; SI and radians. The filter: ``docs/explanation/attitude.md``.

    Densities are 1 sigma per root of a second: of angle for gyros, of velocity for accelerometers; a measurement's
    times the root of the seconds that it is averaged over is its sigma.
    """

    update_s: float = 0.05  # between updates; the attitude is integrated at every sample
    gravity: float = STANDARD_GRAVITY
    gyro_noise: float = 1e-4  # rad/sqrt(s)
    gyro_noise_per_rate: float = 1.5e-3  # of the rate, 1/sqrt(1/s): scale and axes while turning
    gyro_bias_walk: float = 1e-5  # rad/s/sqrt(s)
    gyro_bias_std: float = 0.03  # rad/s, 1.7 deg/s: of a MEMS gyro switched on
    gyro_scale_std: float = 2e-3
    force_noise: float = 0.1  # m/s/sqrt(s): vibration, lever arm, gusts as felt
    force_bias_std: float = 0.05  # m/s2, 5 mg
    force_bias_walk: float = 1e-4  # m/s2/sqrt(s)
    tilt_std: float = math.radians(15.0)  # of the first specific force taken for the vertical
    velocity_std: float = 1.0  # m/s, at the start
    velocity_std_per_speed: float = 0.1
    speed_noise: float = 0.45  # m/s*sqrt(s): no aid; the velocity is about zero
    speed_s: float = 0.32  # no aid: for so long the velocity goes on, once it is known how much there is of it
    airspeed_noise: float = 1.0  # m/s*sqrt(s): gusts along the flight path
    gust_noise: float = 1.0  # m/s*sqrt(s): gusts across it
    climb_noise: float = 10.0  # m/s*sqrt(s): vertical speed is about zero, weakly
    climb_noise_per_speed: float = 0.4
    attack_std: float = math.radians(4.0)
    attack_s: float = 100.0
    slip_std: float = math.radians(1.0)
    slip_s: float = 20.0
    velocity_fix_std: float = 0.1  # m/s: GNSS
    fix_latency: float = 0.0  # s by which a fix is older than the row that it stands at
    heading_std: float = math.radians(2.0)  # of a heading given
    course_std: float = math.radians(15.0)  # of the first course taken for the heading
    course_speed: float = 3.0  # m/s, above which a course says something
    rest_rate: float = math.radians(1.0)  # rad/s: rates that vary by less may be rest
    rest_force: float = 0.3  # m/s2
    rest_speed: float = 1.0  # m/s, above which an aid denies rest
    rest_s: float = 1.5  # for so long
    cruise_std: float = 0.0  # m/s: above zero, rest may be a steady cruise; the velocity then restarts at it
    rest_velocity_noise: float = 0.01  # m/s*sqrt(s)
    rest_force_noise: float = 0.03  # m/s/sqrt(s), of accelerometers that nothing shakes
    rest_bias_walk: float = 1e-4  # rad/s/sqrt(s), of gyros that nothing moves
    rest_gyro_noise: float = math.inf  # rad/sqrt(s): their own noise, if it is less
    unseen_rate: float = 0.0  # rad/s, part of the biases that turns as the unit does: the Earth's
    rest_rate_noise: float = 2.5e-4  # rad/s*sqrt(s); a minute of it is half the Earth rate
    rate_limit: float = math.inf  # rad/s: the gyros' range; at it they are saturated
    force_limit: float = math.inf  # m/s2
    nominal_s: float = 0.01  # the usual interval between samples
    earth_north: float = 0.0  # rad/s, of the Earth's rate
    earth_down: float = 0.0
    believed_sigma: float = 3.0  # a measurement further off counts as if it stood there


AIDED_SETTINGS = KalmanSettings()


# Without aid the tilt is what the last seconds of specific force say: a bias may drift, as MEMS ones do in
# motion, at no cost, and the scale factor's share of fast motion counts more than anything slow. All noises by one
# factor leave the attitude as it is: that factor makes sigma what the error is.
UNAIDED_SETTINGS = KalmanSettings(
    gyro_noise=5e-5, gyro_noise_per_rate=7.5e-4, gyro_bias_walk=2.5e-4, gyro_scale_std=2.5e-3, force_noise=0.025,
    force_bias_std=0.02, force_bias_walk=2e-5, velocity_std=0.5, speed_noise=0.22, rest_velocity_noise=3e-3,
)  # fmt: skip
