"""Error terms of the bench and of how a campaign was carried out, and vibration.

Of the bench: the slab, the cube and the site are not what the campaign states. Of the procedure: the clock,
disturbances, auxiliary influences. Vibration: a bench that shakes in every other position, and sensors whose mean
follows the variance.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivers.simulated.effects.planted_effect import AXES, VECTOR_KEYS, PlantedEffect, Stimulus, TriadInput, vector
from drivers.simulated.truth import Sizes, World
from procedures.arrays import FloatArray
from procedures.positions import FACES, cross_axes
from procedures.units import DEG_H_PER_DEG_S

_SLAB_KEYS = ("east", "north")
_FACE_KEYS = tuple(f"{face}.{AXES[i]}" for face in FACES for i in cross_axes(face))
_PAIR_KEYS = tuple(f"{axis}.{AXES[i]}" for axis in VECTOR_KEYS for i in cross_axes(f"{axis}_up"))


def _listed(sizes: Sizes, keys: Sequence[str]) -> FloatArray:
    return np.array([sizes.get(key, 0.0) for key in keys])


def _halves(sizes: Sizes) -> FloatArray:
    """Return half of each pair's parallelism for either of its faces (6, 2) [rad]."""
    return np.repeat(_listed(sizes, _PAIR_KEYS).reshape(3, 2) / 2, 2, axis=0)


BENCH = (
    PlantedEffect("slab.tilt", "rad", _SLAB_KEYS,
                  world=lambda w, sizes: replace(w, slab_tilt=w.slab_tilt + _listed(sizes, _SLAB_KEYS))),
    PlantedEffect("fixture.face_tilt", "rad", _FACE_KEYS,
                  world=lambda w, sizes: replace(w, faces=w.faces + _listed(sizes, _FACE_KEYS).reshape(6, 2))),
    PlantedEffect("fixture.parallelism", "rad", _PAIR_KEYS,
                  world=lambda w, sizes: replace(w, faces=w.faces + _halves(sizes))),
    PlantedEffect("site.azimuth", "rad", ("value",),
                  world=lambda w, sizes: replace(w, azimuth=w.azimuth + sizes.get("value", 0.0))),
    PlantedEffect("site.latitude", "rad", ("value",),
                  world=lambda w, sizes: replace(w, latitude=w.latitude + sizes.get("value", 0.0))),
    PlantedEffect("site.gravity", "m/s^2", ("value",),
                  world=lambda w, sizes: replace(w, gravity=w.gravity + sizes.get("value", 0.0))),
)  # fmt: skip


OPTIONS = {"rms_g": 0.02, "hz": 2.3}
AXES_SHAKEN = 3


def _wave(seen: Stimulus, sizes: Sizes) -> FloatArray:
    """Return the vibration (n, 1) [g], the same along every axis, in odd positions."""
    amplitude = np.sqrt(2.0) * sizes["rms_g"] * (seen.position % 2)
    found: FloatArray = amplitude * np.sin(2 * np.pi * sizes["hz"] * np.reshape(seen.t, (-1, 1)))
    return found


def _accelerometers(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    wave = _wave(seen, sizes)
    return wave + vector(sizes) * wave**2


def _gyroscopes(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * AXES_SHAKEN * _wave(seen, sizes) ** 2


VIBRATION = (
    PlantedEffect("accelerometer.vibration_rectification", "g/g^2", VECTOR_KEYS, OPTIONS,
                  accel=_accelerometers),
    PlantedEffect("gyroscope.vibration_rectification", "deg/h/g^2", VECTOR_KEYS, OPTIONS,
                  accel=lambda seen, triad, sizes: _wave(seen, sizes) + np.zeros(3), gyro=_gyroscopes),
)  # fmt: skip


AUXILIARY_PERIOD_S = 600.0


def auxiliary(t: FloatArray, period_s: float = AUXILIARY_PERIOD_S) -> FloatArray:
    """Return the auxiliary channel (n,), in its own unit, at time ``t`` (n,) [s]: ``sin(2 pi t / period_s)``."""
    value: FloatArray = np.sin(2 * np.pi * t / period_s)
    return value


def _placement(world: World, sizes: Sizes) -> World:
    if not np.any(vector(sizes)):
        return world
    return replace(world, seatings={**world.seatings, int(sizes["position"]): vector(sizes)})


def _label(world: World, sizes: Sizes) -> World:
    actual = int(sizes.get("actual", 0.0))
    return replace(world, labels={**world.labels, int(sizes["position"]): actual}) if actual else world


def _disturbance(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    since = stimulus.rest_s - sizes["at_s"]
    acts = (since >= 0) & (since < sizes["duration_s"]) & (stimulus.position == int(sizes["position"]))
    return vector(sizes) * np.sin(2 * np.pi * sizes["hz"] * np.where(acts, since, 0.0))


def _pressed(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    acts = (stimulus.t >= sizes["from_s"]) & (stimulus.t < sizes["to_s"])
    added: FloatArray = sizes.get("value", 0.0) * stimulus.f / np.linalg.norm(stimulus.f, axis=1, keepdims=True)
    return added * acts


def _tilt(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    turned: FloatArray = np.cross(stimulus.f, vector(sizes)) * (stimulus.t > sizes["after_s"])
    return turned


PROCEDURE = (
    PlantedEffect("placement.dwell", "rad", VECTOR_KEYS, {"position": 7.0}, world=_placement),
    PlantedEffect("placement.label", "position", ("actual",), {"position": 3.0}, world=_label),
    PlantedEffect("placement.scatter", "rad", ("value",),
                  world=lambda w, sizes: replace(w, seat_std=sizes.get("value", 0.0))),
    PlantedEffect("placement.tilt", "rad", VECTOR_KEYS, {"after_s": 600.0}, accel=_tilt),
    PlantedEffect("procedure.closure", "deg", ("value",),
                  world=lambda w, sizes: replace(w, closure_std=float(np.radians(sizes.get("value", 0.0))))),
    PlantedEffect("procedure.heading", "deg", ("value",),
                  world=lambda w, sizes: replace(w, heading_std=float(np.radians(sizes.get("value", 0.0))))),
    # drawn with the power-on (`Truth.powered_on`): nothing to add later
    PlantedEffect("accelerometer.turn_on_bias", "g", ("value",)),
    PlantedEffect("gyroscope.turn_on_bias", "deg/h", ("value",)),
    PlantedEffect("clock.rate", "ppm", ("value",),
                  world=lambda w, sizes: replace(w, clock_ppm=w.clock_ppm + sizes.get("value", 0.0))),
    PlantedEffect("disturbance.dwell", "g", VECTOR_KEYS,
                  {"position": 7.0, "at_s": 40.0, "duration_s": 10.0, "hz": 7.3}, accel=_disturbance),
    PlantedEffect("disturbance.rest", "g", ("value",), {"from_s": 400.0, "to_s": 420.0}, accel=_pressed),
    PlantedEffect("auxiliary.channel", "ax..az: g/unit, gx..gz: deg/h/unit", ("ax", "ay", "az", "gx", "gy", "gz"),
                  {"period_s": AUXILIARY_PERIOD_S},
                  accel=lambda seen, triad, sizes: vector(sizes, "a") * auxiliary(seen.t, sizes["period_s"]),
                  gyro=lambda seen, triad, sizes: (
                      vector(sizes, "g") / DEG_H_PER_DEG_S * auxiliary(seen.t, sizes["period_s"]))),
)  # fmt: skip
