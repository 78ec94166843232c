"""What walls look like: blots of every size, periodic, in a pyramid of ever coarser images (Williams 1983).

The spectrum falls with frequency, so that there is much to see from near and from far. Looked up between texels
and between levels, so that an image changes smoothly with the pose; no level is looked up whose texels are much
finer than the pixels, so that nothing flickers.
"""

from functools import cache

import numpy as np
from scipy.fft import irfft2, rfftfreq

from procedures.arrays import FloatArray

TEXTURE_TEXELS = 1024  # texels, a power of two
TEXEL_M = 0.015  # m, of the finest level
MIPMAP_LEVELS = 9
MAX_FREQUENCY = 0.22  # cycles a texel, above which there is nothing: a texel's edge must not show from near
SPECTRUM_EXPONENT = 0.6  # of the amplitude with frequency; with 1, the eye's, features were followed half as well
TEXELS_PER_PIXEL = 0.7  # texels to a pixel's width: with 1 features were followed a tenth worse
MEAN, CONTRAST = 127.0, 48.0  # grey
Floats = np.ndarray[tuple[int, ...], np.dtype[np.float32]]


@cache
def pyramid() -> tuple[Floats, np.ndarray]:
    """Return the grey of all levels one after the other (n,), and where each begins (levels,), an index."""
    rng = np.random.default_rng(7)
    across, down = rfftfreq(TEXTURE_TEXELS), np.fft.fftfreq(TEXTURE_TEXELS)[:, None]
    f = np.hypot(across, down)
    f[0, 0] = 1.0
    size = np.exp(-((f / MAX_FREQUENCY) ** 4)) / f**SPECTRUM_EXPONENT
    size[0, 0] = 0.0
    spectrum = size * (rng.normal(size=f.shape) + 1j * rng.normal(size=f.shape))
    level: FloatArray = irfft2(spectrum, (TEXTURE_TEXELS, TEXTURE_TEXELS))
    level = np.clip(MEAN + CONTRAST * level / level.std(), 0, 255)
    levels = [level]
    for _ in range(MIPMAP_LEVELS - 1):
        levels.append(_halved(levels[-1]))
    begin = np.cumsum([0, *(each.size for each in levels[:-1])])
    return np.concatenate([each.ravel() for each in levels]).astype(np.float32), begin.astype(np.int32)


def _halved(level: FloatArray) -> FloatArray:
    """Return every other texel of a level, smoothed by 1 3 3 1 so that texels stay where they are."""
    for axis in (0, 1):
        one, two = (np.roll(level, -k, axis) for k in (1, 2))
        back = np.roll(level, 1, axis)
        level = np.take((back + 3 * level + 3 * one + two) / 8, range(0, level.shape[axis], 2), axis)
    return level


def grey(u: Floats, v: Floats, pixel: Floats) -> Floats:
    """Return the grey at places (u, v) [m] of a wall where a pixel covers ``pixel`` [m]; all of one shape."""
    texels, begin = pyramid()
    fine = np.clip(
        np.log2(np.maximum(pixel, 1e-6) * (TEXELS_PER_PIXEL / TEXEL_M)), 0, MIPMAP_LEVELS - 1.001, dtype=np.float32
    )
    level = fine.astype(np.int32)
    share = fine - level
    near, far = (_between(texels, begin, u, v, level + k) for k in (0, 1))
    mixed: Floats = near + share * (far - near)
    return mixed


def _between(texels: Floats, begin: np.ndarray, u: Floats, v: Floats, level: np.ndarray) -> Floats:
    """Return a level's grey, linear between the middles of its texels."""
    scale = np.ldexp(np.float32(1 / TEXEL_M), -level).astype(np.float32)
    x, y = u * scale - np.float32(0.5), v * scale - np.float32(0.5)
    x0, y0 = np.floor(x), np.floor(y)
    a, b = x - x0, y - y0
    size = TEXTURE_TEXELS >> level
    last = size - 1
    i, j = x0.astype(np.int32), y0.astype(np.int32)
    left, right = i & last, (i + 1) & last
    top, bottom = begin[level] + (j & last) * size, begin[level] + ((j + 1) & last) * size
    upper = texels[top + left] * (1 - a) + texels[top + right] * a
    lower = texels[bottom + left] * (1 - a) + texels[bottom + right] * a
    mixed: Floats = upper + b * (lower - upper)
    return mixed
