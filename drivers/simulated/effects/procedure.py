"""Procedure effects: how the campaign was carried out, the clock, the disturbances, auxiliary influences."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_truth import World
from drivers.simulated.effects.planted_effect import VECTOR_KEYS, PlantedEffect, Stimulus, TriadInput, vector
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S

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
    PlantedEffect("auxiliary.channel", "ax..az: g/unit, gx..gz: deg/h/unit", ("ax", "ay", "az", "gx", "gy", "gz"),
                  {"period_s": AUXILIARY_PERIOD_S},
                  accel=lambda seen, triad, sizes: vector(sizes, "a") * auxiliary(seen.t, sizes["period_s"]),
                  gyro=lambda seen, triad, sizes: (
                      vector(sizes, "g") / DEG_H_PER_DEG_S * auxiliary(seen.t, sizes["period_s"]))),
)  # fmt: skip
