"""Bench effects: the slab, the cube and the site are not what the campaign states."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_truth import World
from drivers.simulated.effects.planted_effect import AXES, VECTOR_KEYS, PlantedEffect
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.frames import FACES, cross_axes

_FACE_KEYS = tuple(f"{face}.{AXES[i]}" for face in FACES for i in cross_axes(face))
_PAIR_KEYS = tuple(f"{axis}.{AXES[i]}" for axis in VECTOR_KEYS for i in cross_axes(f"{axis}_up"))


def _face_tilts(sizes: Sizes) -> FloatArray:
    return np.array([sizes.get(key, 0.0) for key in _FACE_KEYS]).reshape(6, 2)


def _slab_tilt(world: World, sizes: Sizes) -> World:
    added = np.array([sizes.get("east", 0.0), sizes.get("north", 0.0)])
    return replace(world, slab_tilt=world.slab_tilt + added)


def _face_tilt(world: World, sizes: Sizes) -> World:
    return replace(world, faces=world.faces + _face_tilts(sizes))


def _parallelism(world: World, sizes: Sizes) -> World:
    pairs = np.array([sizes.get(key, 0.0) for key in _PAIR_KEYS]).reshape(3, 2)
    return replace(world, faces=world.faces + np.repeat(pairs / 2, 2, axis=0))


def _azimuth(world: World, sizes: Sizes) -> World:
    return replace(world, azimuth=world.azimuth + sizes.get("value", 0.0))


def _gravity(world: World, sizes: Sizes) -> World:
    return replace(world, gravity=world.gravity + sizes.get("value", 0.0))


BENCH = (
    PlantedEffect("slab.tilt", "rad", ("east", "north"), world=_slab_tilt),
    PlantedEffect("fixture.face_tilt", "rad", _FACE_KEYS, world=_face_tilt),
    PlantedEffect("fixture.parallelism", "rad", _PAIR_KEYS, world=_parallelism),
    PlantedEffect("site.azimuth", "rad", ("value",), world=_azimuth),
    PlantedEffect("site.gravity", "m/s^2", ("value",), world=_gravity),
)
