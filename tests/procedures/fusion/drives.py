"""A car's drive with everything known: streets, lights, a wheel that slips, GNSS that goes away.

The car is its rear axle: that point goes where the car points, at the speed of its profile. Body and IMU ride on
it, with a little pitch and roll. All is integrated at 1 kHz and sampled; nothing here is of `procedures.fusion`
but the records, and the IMU is had by differences of the path.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries, Trajectory, WheelMount, WheelSpeeds
from procedures.geodesy import earth_rate_n

GRAVITY = 9.81
LATITUDE = np.radians(48.0)
FINE = 1e-3  # s
ACCELERATION = 2.0  # m/s2 with which it sets off and brakes
SCALE = 1.015  # the wheel tells 1.5 % too little
QUANTUM = 0.01  # m/s
UNFELT = 0.3  # m/s below which the wheel tells nought
AXLE = np.array([-1.4, 0.2, -0.6])  # m from the IMU, forward-left-up
MEMS = ImuNoise(4.4e-5, 1e-6, 1e-3, 1e-4, 2e-3, 0.05)
FOG = ImuNoise(3e-6, 1e-9, 5e-4, 1e-6, 5e-6, 0.01)
WHEEL_STD = 0.03  # m/s

# seconds at which it heads for another speed [m/s], and for another curvature [1/m]
SPEEDS = (
    (5, 12), (55, 0), (75, 14), (110, 8), (125, 15), (150, 0), (165, 10), (200, 16), (235, 9), (262, 0), (274, 13),
    (320, 0), (335, 12), (380, 6),
)  # fmt: skip
BENDS = (
    (15, 0.02), (22, 0), (40, -0.03), (46, 0), (90, 0.015), (98, 0), (115, -0.04), (121, 0), (175, 0.03), (180, 0),
    (205, -0.01), (215, 0), (240, 0.03), (246, 0), (280, -0.025), (286, 0), (345, 0.04), (350, 0),
)  # fmt: skip
# from, to [s], and by how much of its speed the wheel is fast: it spins, it locks
SLIPS = (
    (7.0, 8.2, 0.4), (51.0, 52.0, -0.3), (77.0, 78.5, 0.25), (127.0, 127.4, 0.15), (156.0, 157.0, -1.0),
    (203.0, 205.0, 0.12), (276.0, 277.5, 0.3), (290.0, 291.0, -0.2), (337.0, 338.0, 0.5),
)  # fmt: skip
OUTAGE = (250.0, 310.0)  # s


@dataclass(frozen=True)
class Drive:
    """400 s through a town; ``slips`` as `SLIPS` are, ``outage`` (from, to) [s]."""

    seconds: float = 400.0
    noise: ImuNoise = MEMS
    slips: tuple[tuple[float, float, float], ...] = SLIPS
    outage: tuple[float, float] | None = OUTAGE
    scale: float = SCALE
    _path: dict[str, FloatArray] = field(default_factory=dict, compare=False, repr=False)

    def _integrated(self) -> dict[str, FloatArray]:
        if not self._path:
            t = np.arange(-0.5, self.seconds + 0.5, FINE)
            wanted = np.zeros(len(t))
            for at, speed in SPEEDS:
                wanted[t >= at] = speed
            speed = _smooth(_chased(wanted, ACCELERATION * FINE), 0.5)
            bend = np.zeros(len(t))
            for at, curvature in BENDS:
                bend[t >= at] = curvature
            yaw = 0.6 + np.cumsum(_smooth(bend, 1.5) * speed) * FINE
            gas = np.gradient(speed, FINE)
            pitch = -0.004 * gas + 0.004 * np.sin(0.05 * np.cumsum(speed) * FINE)
            roll = 0.004 * np.gradient(yaw, FINE) * speed + 0.003 * np.sin(0.08 * np.cumsum(speed) * FINE)
            level = np.stack((np.cos(yaw), np.sin(yaw), np.zeros(len(t))), axis=1)
            axle = np.cumsum(level * speed[:, None], axis=0) * FINE
            C = Rotation.from_euler("ZYX", np.stack((yaw, pitch, roll), axis=1))
            self._path.update(t=t, speed=speed, q=C.as_quat(), p=axle - C.apply(AXLE))
        return self._path

    def at(self, t: FloatArray) -> tuple[FloatArray, FloatArray, Rotation]:
        """Return places (n, 3) [m], velocities (n, 3) [m/s] and attitudes of the IMU at times (n,) [s]."""
        path = self._integrated()
        k = np.rint((t - path["t"][0]) / FINE).astype(int)
        return path["p"][k], (path["p"][k + 1] - path["p"][k - 1]) / (2 * FINE), Rotation.from_quat(path["q"][k])

    def imu(self, rng: np.random.Generator, rate: float = 100.0) -> ImuSeries:
        """Return samples: biases drawn, their walks, white noise; each a mean over its interval."""
        n, path = self.noise, self._integrated()
        t = np.arange(1 / rate, self.seconds, 1 / rate)
        k = np.rint((t - path["t"][0]) / FINE).astype(int)
        half = int(1 / rate / FINE) // 2
        q = Rotation.from_quat(path["q"])
        earth = earth_rate_n(LATITUDE)
        omega = (q[k - half].inv() * q[k + half]).as_rotvec() * rate + q[k].inv().apply(
            np.tile(earth, (len(t), 1))
        )
        v = np.gradient(path["p"], FINE, axis=0)
        a = (v[k + half] - v[k - half]) * rate + 2 * np.cross(earth, v[k])
        f = q[k].inv().apply(a + np.array([0.0, 0.0, GRAVITY]))
        for values, white, walk, bias in (
            (omega, n.gyro, n.gyro_walk, n.gyro_bias),
            (f, n.accel, n.accel_walk, n.accel_bias),
        ):
            values += rng.normal(0, bias / 3, 3) + rng.normal(0, white * rate**0.5, f.shape)
            values += np.cumsum(rng.normal(0, walk / rate**0.5, f.shape), axis=0)
        return ImuSeries(t, omega, f)

    def fixes(self, rng: np.random.Generator, rate: float = 5.0, std: float = 0.5) -> GnssFixes:
        """Return fixes of an antenna at the IMU; none within the outage."""
        t = np.arange(0.2, self.seconds, 1 / rate)
        if self.outage is not None:
            t = t[(t < self.outage[0]) | (t > self.outage[1])]
        p, v, _ = self.at(t)
        nan = np.full(len(t), np.nan)
        p, v = p + rng.normal(0, std, p.shape), v + rng.normal(0, 0.05, v.shape)
        return GnssFixes(t, p, v, nan, np.full(len(t), std), np.full(len(t), 0.05))

    def wheel(self, rng: np.random.Generator, rate: float = 50.0) -> WheelSpeeds:
        """Return what the wheel tells: without sign, in steps, nought where it is slow, and wrong in a slip."""
        t = np.arange(0.1, self.seconds, 1 / rate)
        path = self._integrated()
        true = np.abs(np.interp(t, path["t"], path["speed"]))
        measured = true / self.scale + rng.normal(0, WHEEL_STD, len(t)) * (true > 0.01)
        for begin, end, share in self.slips:
            during = (t > begin) & (t < end)
            measured[during] *= 1 + share * np.sin(np.pi * (t[during] - begin) / (end - begin))
        measured = np.rint(np.maximum(measured, 0.0) / QUANTUM) * QUANTUM
        return WheelSpeeds(t, np.where(true < UNFELT, 0.0, measured))

    def truth(self, spacing: float = 0.05) -> Trajectory:
        """Return where the IMU is, truly."""
        t = np.arange(0.0, self.seconds, spacing)
        p, _, C = self.at(t)
        return Trajectory(t, p, C.as_quat())


MOUNT = WheelMount(np.array([1.0, 0.0, 0.0]), AXLE, WHEEL_STD, 0.05)


def _chased(wanted: FloatArray, step: float) -> FloatArray:
    """Return what follows ``wanted`` by no more than a ``step`` each time."""
    found, now = np.empty(len(wanted)), 0.0
    for i, aim in enumerate(wanted.tolist()):
        now += min(max(aim - now, -step), step)
        found[i] = now
    return found


def _smooth(values: FloatArray, seconds: float) -> FloatArray:
    """Return means over so long."""
    n = int(seconds / FINE) | 1
    padded = np.pad(values, n // 2, mode="edge")
    sums = np.cumsum(np.r_[0.0, padded])
    return np.asarray((sums[n:] - sums[:-n]) / n, np.float64)
