"""Motions with everything known: a flight on a bent eight, its GNSS, an odometry that drifts as it says."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries, Trajectory
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.odometry import OdometryDrift, RecordedOdometry
from procedures.geodesy import earth_rate_n
from procedures.units import RAD_S_PER_DEG_H
from tests.drivers.simulated.camera_tracks import View, simulate_tracks

RATE = 20.0  # Hz
SETTING_OFF = 2.0  # s
NO_LEVER = np.zeros(3)
GRAVITY = 9.81
EARTH = earth_rate_n(np.radians(55.0))
NOISE = ImuNoise(gyro=3e-4, gyro_walk=4e-5, accel=8e-3, accel_walk=3e-3)
GYRO_BIAS = np.array([-0.01, 0.02, 0.07])
ACCEL_BIAS = np.array([0.05, -0.1, 0.08])


@dataclass(frozen=True)
class Eight:
    """A flight of ``seconds``: an eight of some metres, 2 m/s, rocking and turning about x (up)."""

    seconds: float = 60.0
    still: float = 0.0  # s at its beginning

    def _moving(self, t: FloatArray) -> FloatArray:
        """Return the time that has been flown; out of rest it sets off within `SETTING_OFF`, not at once."""
        if not self.still:
            return t
        since = np.maximum(t - self.still, 0.0)
        flown: FloatArray = np.where(since < SETTING_OFF, since**2 / 2 / SETTING_OFF, since - SETTING_OFF / 2)
        return flown

    def p(self, t: FloatArray) -> FloatArray:
        """Return positions (n, 3) [m]."""
        s = self._moving(t)
        return np.stack([5 * np.sin(0.4 * s), 3 * np.sin(0.8 * s), 0.5 * np.sin(0.3 * s) + 1.0], axis=-1)

    def v(self, t: FloatArray) -> FloatArray:
        """Return velocities (n, 3) [m/s]."""
        return (self.p(t + 1e-3) - self.p(t - 1e-3)) / 2e-3

    def attitude(self, t: FloatArray) -> Rotation:
        """Return the attitudes C_nb; the IMU's x axis points up, as in EuRoC."""
        s = self._moving(t)
        rocking = np.stack([0.2 * np.sin(s), 0.2 * np.cos(0.7 * s) - 0.2, 0.8 * np.sin(0.3 * s)], axis=-1)
        return Rotation.from_rotvec(rocking) * Rotation.from_rotvec([0.0, -np.pi / 2, 0.0])

    def imu(self, rng: np.random.Generator, earth_n: FloatArray, rate: float = 200.0) -> ImuSeries:
        """Return samples with constant biases and the white noise of `NOISE`."""
        t, h = np.arange(0.0, self.seconds, 1 / rate), 1e-3
        C = self.attitude(t)
        omega = (self.attitude(t - h).inv() * self.attitude(t + h)).as_rotvec() / (2 * h)
        a = (self.p(t + h) - 2 * self.p(t) + self.p(t - h)) / h**2
        f = (
            C.inv().apply(a + np.array([0.0, 0.0, GRAVITY]))
            + ACCEL_BIAS
            + rng.normal(size=a.shape) * NOISE.accel * rate**0.5
        )
        omega = omega + C.inv().apply(np.tile(earth_n, (len(t), 1))) + GYRO_BIAS
        return ImuSeries(t, omega + rng.normal(size=a.shape) * NOISE.gyro * rate**0.5, f)

    def fixes(
        self, rng: np.random.Generator, lever: FloatArray = NO_LEVER, late: float = 0.0, std: float = 0.2
    ) -> GnssFixes:
        """Return fixes of an antenna at ``lever`` [m] in b, stamped ``late`` [s] after they were true."""
        stamp = np.arange(0.5, self.seconds, 1 / RATE)
        t = stamp - late
        p = self.p(t) + self.attitude(t).apply(lever) + rng.normal(0, std, (len(t), 3))
        omega = (self.attitude(t - 1e-3).inv() * self.attitude(t + 1e-3)).as_rotvec() / 2e-3
        v = self.v(t) + self.attitude(t).apply(np.cross(omega, lever)) + rng.normal(0, 0.05, (len(t), 3))
        return GnssFixes(stamp, p, v, np.full(len(t), np.nan), np.full(len(t), std), np.full(len(t), 0.05))

    def odometry(self, rng: np.random.Generator, drift: OdometryDrift, yaw: float = 0.7) -> RecordedOdometry:
        """Return an odometry in a frame turned by ``yaw`` [rad], whose drift is as it says."""
        t = np.arange(0.0, self.seconds, 1 / RATE)
        dt = 1 / RATE
        turn = yaw + drift.yaw_per_root_s * np.sqrt(dt) * np.cumsum(rng.normal(size=len(t)))
        back = Rotation.from_rotvec(np.outer(-turn, [0, 0, 1]))
        step = np.diff(self.p(t), axis=0)
        std = np.sqrt(drift.per_root_s**2 * dt + drift.per_root_m**2 * np.linalg.norm(step, axis=1))
        moved = back[:-1].apply(step) + rng.normal(size=step.shape) * std[:, None]
        p = np.vstack((np.zeros(3), np.cumsum(moved, axis=0)))
        return RecordedOdometry(Trajectory(t, p, (back * self.attitude(t)).as_quat()), drift)


def fog(rng: np.random.Generator, seconds: float, bias: FloatArray) -> tuple[ImuSeries, FloatArray, ImuNoise]:
    """Return a FOG IMU on a bench: 0.003 deg/rt-h, ``bias`` [rad/s], and its attitude."""
    noise = ImuNoise(0.003 * np.pi / 180 / 60, 1e-10, 5e-5, 1e-7, 0.05 * RAD_S_PER_DEG_H, 5e-5)
    t, C_nb = np.arange(0.0, seconds, 0.1), rotation(np.array([0.02, -0.03, 2.0]))
    omega = C_nb.T @ EARTH + bias + rng.normal(size=(len(t), 3)) * noise.gyro * 10**0.5
    f = C_nb.T @ [0, 0, GRAVITY] + rng.normal(size=(len(t), 3)) * noise.accel * 10**0.5
    return ImuSeries(t, omega, f), C_nb, noise


def only(fixes: GnssFixes, keep: FloatArray) -> GnssFixes:
    """Return some of the fixes."""
    parts = (fixes.t, fixes.p_n, fixes.v_n, fixes.course, fixes.position_std, fixes.velocity_std)
    return GnssFixes(*(part[keep] for part in parts))


# the flight's x axis points up: the camera looks along body z, its right is body -y
CAMERA = PinholeCamera(
    458.0, 457.0, 367.0, 248.0, 1.0, np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    np.array([-0.02, -0.06, 0.01]),
)  # fmt: skip
SITE = Site(GRAVITY, EARTH, NOISE)


def path_of(flight: Eight) -> Trajectory:
    """Return the flight at 20 Hz."""
    t = np.arange(0.0, flight.seconds, 0.05)
    return Trajectory(t, flight.p(t), flight.attitude(t).as_quat())


def tracks_of(flight: Eight, seed: int, camera: PinholeCamera = CAMERA, view: View | None = None) -> FeatureTracks:
    """Return what the camera leaves."""
    return simulate_tracks(path_of(flight), camera, view or View(), seed)


def turned(camera: PinholeCamera, turn_deg: float, shift_m: float) -> PinholeCamera:
    """Return a camera whose place is told wrong by so much about and along each axis."""
    wrong = Rotation.from_rotvec(np.radians(turn_deg) * np.ones(3)).as_matrix()
    return PinholeCamera(
        camera.fx, camera.fy, camera.cx, camera.cy, camera.std, camera.C_bc @ wrong, camera.t_bc + shift_m
    )
