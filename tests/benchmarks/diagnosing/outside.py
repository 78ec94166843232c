"""Effects of no catalogue: periodic in heading, a dead zone, a term in temperature rate times temperature."""

import numpy as np

from drivers.simulated.effects import Planted, PlantedEffect, Stimulus, TriadInput
from drivers.simulated.truth import Sizes


def heading(stimulus: Stimulus) -> np.ndarray:
    """Return (n, 1) the angle from magnetic north of the IMU axis that is most level to the east, [rad]."""
    up = stimulus.f / np.linalg.norm(stimulus.f, axis=1, keepdims=True)
    north = stimulus.magnetic - np.sum(stimulus.magnetic * up, axis=1, keepdims=True) * up
    north /= np.linalg.norm(north, axis=1, keepdims=True)
    axis = np.eye(3)[np.argsort(np.abs(up), axis=1, kind="stable")[:, 0]]
    level = axis - np.sum(axis * up, axis=1, keepdims=True) * up
    return np.arctan2(np.sum(np.cross(north, level) * up, axis=1), np.sum(north * level, axis=1))[:, None]


def _accel_heading(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> np.ndarray:
    return sizes["accel"] * np.sin(heading(stimulus) + np.array([0.3, 1.7, 4.0]))


def _gyro_heading(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> np.ndarray:
    return sizes["gyro"] / 3600 * np.sin(heading(stimulus) + np.array([2.3, 0.7, 5.0]))


def _dead_zone(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> np.ndarray:
    width = sizes["gyro"] / 3600
    total = triad.raw + triad.bias
    return -np.clip(total, -width, width)


def _rate_temperature(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> np.ndarray:
    return sizes["gyro"] / 3600 * stimulus.temperature_rate * (stimulus.temperature - 25)


def outside(name: str, size: float) -> Planted:
    """Return an effect of no catalogue of a given size (g, deg/h)."""
    kinds = {
        "heading, accelerometers": PlantedEffect(name, "g", (), accel=_accel_heading),
        "heading, all": PlantedEffect(name, "g", (), accel=_accel_heading, gyro=_gyro_heading),
        "dead zone": PlantedEffect(name, "deg/h", (), gyro=_dead_zone),
        "temperature rate times temperature": PlantedEffect(name, "deg/h", (), gyro=_rate_temperature),
    }
    return ((kinds[name], {"accel": size, "gyro": size * 3e5}),)
