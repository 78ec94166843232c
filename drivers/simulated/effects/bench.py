"""Bench effects: the slab, the cube and the site are not what the campaign states."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivers.simulated.effects.planted_effect import AXES, VECTOR_KEYS, PlantedEffect
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.frames import FACES, cross_axes

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
