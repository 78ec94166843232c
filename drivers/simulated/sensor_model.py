"""The triads: each channel an integrate-and-fire counter driven by ``N = k (E u + D + effects + noise)``.

Increments are differences of the floor of the accumulated output: the remainder is carried.
"""

from collections.abc import Sequence

import numpy as np

from drivers.simulated.cube_motion import Segment
from drivers.simulated.effects import Planted, Stimulus, TriadInput
from drivers.simulated.sensor_noise import SensorNoise
from drivers.simulated.truth import Truth, World
from procedures.arrays import FloatArray, IntArray


class CountingTriads:
    """Six counters of one unit, sampled forward in time.

    Parameters
    ----------
    truth, world, planted
        The unit, the bench as it truly stands, the effects.
    seed
        Entropy of the noise, as for `numpy.random.SeedSequence`; None: no noise at all.
    """

    def __init__(self, truth: Truth, world: World, planted: Planted, seed: Sequence[int] | None) -> None:
        self._truth, self._world = truth, world
        self._accel = [(e.accel, sizes) for e, sizes in planted if e.accel is not None]
        self._gyro = [(e.gyro, sizes) for e, sizes in planted if e.gyro is not None]
        self.period = truth.sample_period_s / (1 + 1e-6 * world.clock_ppm)
        white, drift, phase = np.random.SeedSequence(seed or 0).spawn(3)
        self._noise = None if seed is None else SensorNoise(truth, white, drift)
        self._phase = np.random.default_rng(phase)
        self._k = np.concatenate((truth.accel_k, truth.gyro_k))
        self._sum = np.zeros(6)
        self._heats = list[tuple[float, float, float]]()  # from when [s], by how much [K], constant [s]

    def heat(self, t: float, kelvin: float, tau_s: float) -> None:
        """Have the temperature rise by ``kelvin`` from ``t`` [s] on, exponentially in ``tau_s`` [s]."""
        self._heats.append((t, kelvin, tau_s))

    def temperature(self, t: FloatArray) -> FloatArray:
        """Return the temperature (n,) [degC] at times ``t`` (n,) [s]."""
        truth = self._truth
        warm = truth.temperature_rise_k * -np.expm1(-t / truth.temperature_tau_s)
        swing = truth.temperature_swing_k * np.sin(2 * np.pi * t / truth.temperature_swing_period_s)
        heated = [k * -np.expm1(-np.maximum(t - since, 0.0) / tau) for since, k, tau in self._heats]
        return truth.temperature_start_c + warm + swing + sum(heated)

    def temperature_rate(self, t: FloatArray) -> FloatArray:
        """Return the rate of temperature (n,) [K/min] at times ``t`` (n,) [s]."""
        truth = self._truth
        warm = truth.temperature_rise_k / truth.temperature_tau_s * np.exp(-t / truth.temperature_tau_s)
        omega = 2 * np.pi / truth.temperature_swing_period_s
        heated = [k / tau * np.exp(-np.maximum(t - s, 0) / tau) * (t >= s) for s, k, tau in self._heats]
        return 60 * (warm + truth.temperature_swing_k * omega * np.cos(omega * t) + sum(heated))

    def output(self, segment: Segment, index: int, first: int, last: int) -> FloatArray:
        """Return the noise-free output (n, 6) or (1, 6): accelerometers [g], gyros [deg/s].

        ``first`` .. ``last`` are samples of the segment, ``index`` the sample since power-on of ``first``.
        """
        truth, (f, omega) = self._truth, self._felt(segment, first, last)
        accel = TriadInput(np.einsum("qp,np->nq", truth.accel_e, f), truth.accel_d_g)
        gyro = TriadInput(np.einsum("qp,np->nq", truth.gyro_e, omega), truth.gyro_d_deg_s)
        accel_u, gyro_u = accel.raw + accel.bias, gyro.raw + gyro.bias
        if self._accel or self._gyro:
            seen = self._stimulus(segment, index, first, last, f, omega)
            for add, sizes in self._accel:
                accel_u = accel_u + add(seen, accel, sizes)
            for add, sizes in self._gyro:
                gyro_u = gyro_u + add(seen, gyro, sizes)
        rows = max(len(accel_u), len(gyro_u))
        six = np.empty((rows, 6))
        six[:, :3], six[:, 3:] = accel_u, gyro_u
        return six

    def counts(self, segment: Segment, index: int, first: int, last: int) -> tuple[IntArray, IntArray]:
        """Return the increments (n, 3) of gyros and accelerometers; arguments as in `output`."""
        total = np.empty((last - first + 1, 6))
        total[0] = self._sum
        np.multiply(self._noisy(segment, index, first, last), self._k * self.period, out=total[1:])
        np.cumsum(total, axis=0, out=total)
        self._sum = total[-1].copy()
        floors = np.floor(total, out=total).astype(np.int64)
        increments: IntArray = floors[1:] - floors[:-1]
        return increments[:, 3:], increments[:, :3]

    def rates(self, segment: Segment, index: int, first: int, last: int) -> tuple[FloatArray, FloatArray]:
        """Return the output (n, 3) of gyros and accelerometers [count/s]; arguments as in `output`."""
        rates = np.empty((last - first, 6))
        np.multiply(self._noisy(segment, index, first, last), self._k, out=rates)
        return rates[:, 3:], rates[:, :3]

    def _noisy(self, segment: Segment, index: int, first: int, last: int) -> FloatArray:
        u = self.output(segment, index, first, last)
        return u if self._noise is None else self._noise.added_to(u, self._middle(index, last - first))

    def skip(self) -> None:
        """Forget the remainders for random ones: counts passed unobserved."""
        if self._noise is not None:
            self._sum = self._phase.random(6)

    def _middle(self, index: int, n: int) -> FloatArray:
        middle: FloatArray = self.period * (np.arange(index, index + n, dtype=np.float64) + 0.5)
        return middle

    def _felt(self, segment: Segment, first: int, last: int) -> tuple[FloatArray, FloatArray]:
        """Return specific force [g] and rate [deg/s], (n, 3) or (1, 3), in the IMU's axes."""
        world, C_sb = self._world, self._world.C_sb
        f_n = world.f_n if segment.accel_n is None else world.f_n + segment.accel_n
        turning = np.degrees(segment.rate_b(first, last, self.period))
        omega = segment.seen(world.omega_ie_n, first, last) + turning
        return np.einsum("sb,nb->ns", C_sb, segment.seen(f_n, first, last)), np.einsum("sb,nb->ns", C_sb, omega)

    def _stimulus(
        self, segment: Segment, index: int, first: int, last: int, f: FloatArray, omega: FloatArray
    ) -> Stimulus:
        t = self._middle(index, last - first)[:, None]
        rested = np.full_like(t, np.inf)
        if segment.rested is not None:
            rested = self._middle(first + segment.rested, last - first)[:, None]
        return Stimulus(
            f=f, omega=omega, t=t, rest_s=rested, position=segment.position, temperature_at=self.temperature,
            magnetic=np.einsum("sb,nb->ns", self._world.C_sb, segment.seen(self._world.magnetic_n, first, last)),
            temperature=self.temperature(t), temperature_rate=self.temperature_rate(t),
        )  # fmt: skip
