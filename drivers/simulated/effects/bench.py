"""Bench effects: the slab, the cube and the site are not what the campaign states."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_truth import World
from drivers.simulated.effects.effect import AXES, VECTOR_KEYS, Effect
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
    Effect("slab.tilt", "rad", "added to the East, North components of the up vector seen from the slab",
           ("east", "north"), world=_slab_tilt),
    Effect("fixture.face_tilt", "rad", "added to a face's up tilt; key x_up.y: face x_up, component along y",
           _FACE_KEYS, world=_face_tilt),
    Effect("fixture.parallelism", "rad", "added to the sum of a face pair's up tilts, half to each; key x.y",
           _PAIR_KEYS, world=_parallelism),
    Effect("site.azimuth", "rad", "the slab's North mark points this far east of true north", ("value",),
           world=_azimuth),
    Effect("site.gravity", "m/s^2", "true gravity exceeds the stated one", ("value",), world=_gravity),
)  # fmt: skip
