"""A closed room around a track with pillars next to it: where rays from a camera end, and what is seen there.

A ray meets a box where it is within all three of its slabs (Kay, Kajiya 1986). Walls have blots of every size in a
pyramid of ever coarser images (Williams 1983), looked up between texels and between levels, so that an image
changes smoothly with the pose and nothing flickers.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.fft import irfft2, rfftfreq

from drivers.simulated.companions.truths import CameraTruth
from drivers.simulated.vehicle_track import VehicleTrack
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


WALL_MARGIN_M = 9.0  # m, from the track to the walls
EYE, CEILING = 1.6, 9.0  # m, from the track down and up
PILLAR_SPACING_M = 10.0  # m, between pillars
PILLAR_HALF_WIDTHS_M = 0.8, 2.5  # m; thin ones are all edges, where features go astray
MIN_PILLAR_DISTANCE_M = 4.0  # m, from the track: what is nearer goes by faster than features are followed
MAX_PILLAR_DISTANCE_M = 18.0  # m, of the track: pillars further off are not needed
MIN_RANGE_M = 0.05  # m
MIN_DIRECTION = 1e-9  # of a ray's parts: all are divided by
SEEN_FROM = 45.0  # m: pillars further off are not drawn


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """Where rays end: ``depth`` along them, ``axis`` of the surface's normal, ``box`` 0 for the room."""

    depth: Floats
    axis: np.ndarray
    box: np.ndarray


class Room:
    """The room; ``low`` and ``high`` (boxes, 3) [m] are the corners, the room's own first."""

    def __init__(self, track: VehicleTrack | None) -> None:
        points = np.zeros((1, 3)) if track is None else track.positions(np.arange(track.t[0], track.t[-1], 0.1))
        rng = np.random.default_rng([1, 0x5CE6])
        low: FloatArray = points.min(axis=0) - np.array([WALL_MARGIN_M, WALL_MARGIN_M, EYE])
        high: FloatArray = points.max(axis=0) + np.array([WALL_MARGIN_M, WALL_MARGIN_M, CEILING])
        pillars = _pillars(low, high, points, rng)
        self.low = np.vstack((low, pillars[0])).astype(np.float32)
        self.high = np.vstack((high, pillars[1])).astype(np.float32)
        self._shift = rng.uniform(0, 100, (len(self.low), 2)).astype(np.float32)  # of each box's texture

    def image(self, camera: CameraTruth, C_nc: FloatArray, p_c: FloatArray) -> Floats:
        """Return what a camera at ``p_c`` (3,) [m] sees, (h, w) grey; ``C_nc`` (3, 3) is its attitude in n."""
        rays = _rays(camera, np.arange(camera.width), np.arange(camera.height)[:, None])
        d = _turned(rays, C_nc)
        o = p_c.astype(np.float32)
        hits = self._walls(o, d)
        for box in self._near(o):
            if (part := self._covered(box, camera, C_nc, p_c)) is not None:
                self._against(box, o, d[:, *part], RayHits(hits.depth[part], hits.axis[part], hits.box[part]))
        return self._painted(o, d, hits, np.einsum("i...,i...->...", rays, rays) / np.float32(camera.fx))

    def ends(self, camera: CameraTruth, C_nc: FloatArray, p_c: FloatArray, uv: FloatArray) -> FloatArray:
        """Return the places (n, 3) [m] that stand at points of an image.

        Parameters
        ----------
        C_nc
            (3, 3), camera to East-North-Up.
        p_c
            (3,) [m], where the camera is.
        uv
            (n, 2) [px], the points.
        """
        d = _turned(_rays(camera, uv[:, 0], uv[:, 1]), C_nc)
        o = p_c.astype(np.float32)
        hits = self._walls(o, d)
        for box in self._near(o):
            self._against(box, o, d, hits)
        ends: FloatArray = (o + (hits.depth * d).T).astype(np.float64)
        return ends

    def _walls(self, o: Floats, d: Floats) -> RayHits:
        """Return where rays meet the room from inside."""
        far = (np.where(d > 0, _up(self.high[0], d), _up(self.low[0], d)) - _up(o, d)) / d
        axis = far.argmin(axis=0).astype(np.int8)
        return RayHits(far.min(axis=0), axis, np.zeros(axis.shape, np.int32))

    def _near(self, o: Floats) -> np.ndarray:
        middle = (self.low[1:, :2] + self.high[1:, :2]) / 2
        return 1 + np.flatnonzero(np.hypot(*(middle - o[:2]).T) < SEEN_FROM)

    def _covered(
        self, box: int, camera: CameraTruth, C_nc: FloatArray, p_c: FloatArray
    ) -> tuple[slice, slice] | None:
        """Return rows and columns of the image in which a box may stand, None where it is out of sight."""
        corners = np.array(np.meshgrid(*zip(self.low[box], self.high[box], strict=True))).reshape(3, 8).T
        y = (corners - p_c) @ C_nc
        if (y[:, 2] < MIN_RANGE_M).all():
            return None
        if (y[:, 2] < MIN_RANGE_M).any():
            return slice(0, camera.height), slice(0, camera.width)
        uv = (y / y[:, 2:]) @ camera.K.T
        low, high = np.floor(uv.min(axis=0)), np.ceil(uv.max(axis=0)) + 1
        size = camera.width, camera.height
        (u0, v0), (u1, v1) = (np.clip(each[:2], 0, size).astype(int).tolist() for each in (low, high))
        return (slice(v0, v1), slice(u0, u1)) if u0 < u1 and v0 < v1 else None

    def _against(self, box: int, o: Floats, d: Floats, hits: RayHits) -> None:
        """Let rays that meet a box before anything else end there."""
        one, two = (_up(each[box] - o, d) / d for each in (self.low, self.high))
        enter, leave = np.minimum(one, two), np.maximum(one, two)
        near, far = enter.max(axis=0), leave.min(axis=0)
        met = (near < far) & (near > MIN_RANGE_M) & (near < hits.depth)
        hits.depth[met], hits.axis[met], hits.box[met] = near[met], enter.argmax(axis=0)[met], box

    def _painted(self, o: Floats, d: Floats, hits: RayHits, pixel: Floats) -> Floats:
        """Return the grey where rays end; a pixel covers ``pixel`` times depth over slant there."""
        at = _up(o, d) + hits.depth * d
        u = np.where(hits.axis == 0, at[1], at[0]) + self._shift[hits.box, 0]
        v = np.where(hits.axis == 2, at[1], at[2]) + self._shift[hits.box, 1]
        slant: Floats = np.abs(np.choose(hits.axis, d)).astype(np.float32)
        return grey(u, v, hits.depth * pixel / slant)


def _rays(camera: CameraTruth, u: np.ndarray, v: np.ndarray) -> Floats:
    """Return rays (3, ...) of depth 1 through image points."""
    x, y = np.broadcast_arrays((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy)
    return np.stack((x, y, np.ones(x.shape))).astype(np.float32)


def _turned(rays: Floats, C_nc: FloatArray) -> Floats:
    """Return rays (3, ...) in East-North-Up; none is along a surface for good."""
    d: Floats = np.einsum("ij,j...->i...", C_nc.astype(np.float32), rays)
    d[np.abs(d) < MIN_DIRECTION] = MIN_DIRECTION
    return d


def _up(vector: Floats, like: Floats) -> Floats:
    """Return a vector (3,) with as many axes as ``like`` (3, ...)."""
    return vector.reshape(3, *(1,) * (like.ndim - 1))


def _pillars(
    low: FloatArray, high: FloatArray, points: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return the corners of pillars that stand next to the track."""
    east, north = np.meshgrid(*(np.arange(low[i] + 2, high[i] - 2, PILLAR_SPACING_M) for i in (0, 1)))
    grid = np.column_stack((east.ravel(), north.ravel()))
    middle = grid + rng.uniform(-0.3 * PILLAR_SPACING_M, 0.3 * PILLAR_SPACING_M, grid.shape)
    half = rng.uniform(*PILLAR_HALF_WIDTHS_M, grid.shape)
    away = np.linalg.norm(middle[:, None] - points[None, :, :2], axis=2).min(axis=1)
    kept = (away - np.hypot(*half.T) > MIN_PILLAR_DISTANCE_M) & (away < MAX_PILLAR_DISTANCE_M)
    middle, half = middle[kept], half[kept]
    top = low[2] + rng.uniform(1.5, 8.0, len(middle))
    return np.column_stack((middle - half, np.full(len(middle), low[2]))), np.column_stack((middle + half, top))
