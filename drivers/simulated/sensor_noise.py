"""The noise of a simulated unit: white noise and bias instability of six channels, drawn sample by sample."""

import numpy as np

from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S

NODE_S = 1.0  # grid of the bias instability, linear in between


class BiasInstability:
    """First-order Gauss-Markov bias of six channels: exact on a grid of `NODE_S`, linear between nodes."""

    def __init__(self, sigma: FloatArray, tau_s: float, rng: np.random.Generator) -> None:
        self._sigma, self._rng = sigma, rng
        self._keep = float(np.exp(-NODE_S / tau_s)) if tau_s > 0 else 0.0
        self._nodes: FloatArray = sigma * rng.standard_normal((1, len(sigma)))

    def at(self, t: FloatArray) -> FloatArray:
        """Return the bias (n, 6) at times ``t`` (n,) [s], or (1, 6) zeros where there is none."""
        if not np.any(self._sigma):
            return np.zeros((1, len(self._sigma)))
        index = (t / NODE_S).astype(np.int64)
        self._extend(int(index[-1]) + 2)
        part = (t / NODE_S - index)[:, None]
        low = self._nodes[index]
        drift: FloatArray = low + part * (self._nodes[index + 1] - low)
        return drift

    def _extend(self, count: int) -> None:
        missing = count - len(self._nodes)
        if missing > 0:
            draws = self._rng.standard_normal((missing, len(self._sigma)))
            grown = [self._nodes[-1]]
            for step in np.sqrt(1 - self._keep**2) * self._sigma * draws:
                grown.append(self._keep * grown[-1] + step)
            self._nodes = np.concatenate((self._nodes, grown[1:]))


class SensorNoise:
    """The noise of accelerometers [g] and gyroscopes [deg/s], in this order; each part has its own seed."""

    def __init__(self, truth: Truth, white: np.random.SeedSequence, drift: np.random.SeedSequence) -> None:
        self._white = np.random.Generator(np.random.SFC64(white))
        arw = truth.gyro_arw_deg_rt_s / np.sqrt(truth.sample_period_s)
        self._std = np.repeat([truth.accel_noise_g, arw], 3)
        sigma = np.repeat([truth.accel_instability_g, truth.gyro_instability_dph / DEG_H_PER_DEG_S], 3)
        self._drift = BiasInstability(sigma, truth.instability_tau_s, np.random.default_rng(drift))

    def added_to(self, u: FloatArray, t: FloatArray) -> FloatArray:
        """Return outputs ``u`` (n, 6) or (1, 6) with the noise of the samples at ``t`` (n,) [s]."""
        noise = self._white.standard_normal((len(t), 6))
        noise *= self._std
        return np.add(noise, u + self._drift.at(t), out=noise)
