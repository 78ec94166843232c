"""What the bench adds to the IMU: slab tilt, face tilts, headings and gravity, as parameters with priors.

A cube face's tilt is kept as two numbers a pair of opposite faces shares: parallelism p, the sum of both
faces' up tilts, and perpendicularity q, half their difference, so that the tilts are p/2 + q with the axis
up and p/2 - q with it down. Turning the IMU's misalignment with q changes nothing that twelve positions can see:
without a certificate q is held at zero, and the misalignment refers to the *mean cube*, each pair's two normals averaged.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign import Campaign
from procedures.earth import STANDARD_GRAVITY
from procedures.frames import AXES, cross_axes, face_normal, face_of, nominal_C_lb, rotation, slab_C_ln

FACE_RANGE = 1e-3  # rad, 1 sigma: a cube 0.4 mm off in 400 mm is not a fixture
SLAB_RANGE = 5e-3  # rad, 1 sigma: 0.3 deg


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """One step's cube on the slab: which campaign, which cube, which position, 1 sigma of its heading [rad]."""

    campaign: int
    cube: int
    position: int
    heading_std: float


@dataclass(frozen=True, eq=False)
class Bench:
    """The nuisance parameters of all steps and where each stands in the vector (p,).

    Order: per campaign slab tilt (2) and relative gravity error (1); per cube parallelism (6) and
    perpendicularity (6), row by face pair; per placement heading (1).
    """

    placements: tuple[Placement, ...]
    campaigns: tuple[Campaign, ...]
    cubes: int

    @property
    def size(self) -> int:
        """Number of parameters."""
        return 3 * len(self.campaigns) + 12 * self.cubes + len(self.placements)

    def slab(self, x: FloatArray, campaign: int) -> FloatArray:
        """Slab tilt (2,) [rad]: East and North components of the up vector seen from the slab."""
        return x[3 * campaign : 3 * campaign + 2]

    def gravity(self, x: FloatArray, campaign: int) -> float:
        """Local gravity [g]."""
        return self.campaigns[campaign].site.gravity / STANDARD_GRAVITY * (1 + float(x[3 * campaign + 2]))

    def cube_slice(self, cube: int) -> slice:
        """Where a cube's parallelism (6) and perpendicularity (6) stand."""
        begin = 3 * len(self.campaigns) + 12 * cube
        return slice(begin, begin + 12)

    def heading_index(self, placement: int) -> int:
        """Where a placement's heading stands."""
        return 3 * len(self.campaigns) + 12 * self.cubes + placement

    @cached_property
    def _nominal(self) -> FloatArray:
        return np.stack([nominal_C_lb(at.position).T for at in self.placements])

    @cached_property
    def _campaign(self) -> IntArray:
        return np.array([at.campaign for at in self.placements])

    @cached_property
    def _tilt_rotation(self) -> FloatArray:
        """(m, 3, p): takes the parameters to the rotation vector of every placement's face, as `face_C_bs`."""
        G = np.zeros((len(self.placements), 3, self.size))
        for i, at in enumerate(self.placements):
            face = face_of(at.position)
            turn = np.stack([np.cross(face_normal(face), np.eye(3)[k]) for k in cross_axes(face)], axis=1)
            p = self.cube_slice(at.cube).start + 2 * AXES.index(face[0])
            G[i, :, p : p + 2] = turn / 2
            G[i, :, p + 6 : p + 8] = turn if face.endswith("up") else -turn
        return G

    def to_cube(self, x: FloatArray) -> FloatArray:
        """Return (m, 3, 3): the rotation from the slab's marks, at nominal heading, to every placement's cube."""
        result: FloatArray = rotation(self._tilt_rotation @ x) @ self._nominal
        return result

    def seen(self, x: FloatArray, vector_n: Sequence[FloatArray], motion: FloatArray | None = None) -> FloatArray:
        """Return (m, 3): each campaign's vector, given East-North-Up, as every placement's cube sees it.

        ``motion`` (m, 3, 3), where given, is the integral over a turn of the rotation from its start.
        All placements at once: this is the inner loop of the solve.
        """
        on_slab = np.stack([slab_C_ln(self.slab(x, i)) @ v for i, v in enumerate(vector_n)])[self._campaign]
        heading = np.zeros((len(self.placements), 3))
        heading[:, 2] = -x[self.heading_index(0) : self.size]
        turned = rotation(heading) @ on_slab[..., None]
        if motion is not None:
            turned = motion @ turned
        result: FloatArray = (self.to_cube(x) @ turned)[..., 0]
        return result

    def priors(self) -> tuple[FloatArray, FloatArray]:
        """Return mean (k,) and matrix (k, p): the whitened prior residual is ``matrix @ x - mean``.

        Parameters held at zero (perpendicularity without a certificate) have a sigma of 1e-12 rad.
        """
        rows, means = [], []

        def add(index: int, sigma: float) -> None:
            row = np.zeros(self.size)
            row[index] = 1 / sigma
            rows.append(row)
            means.append(0.0)

        for i, campaign in enumerate(self.campaigns):
            add(3 * i, SLAB_RANGE)
            add(3 * i + 1, SLAB_RANGE)
            add(3 * i + 2, campaign.site.gravity_std / campaign.site.gravity)
        for cube in range(self.cubes):
            certified = self._certificates(cube)
            begin = self.cube_slice(cube).start
            for pair in range(3):
                held = not any((pair, sign) in certified for sign in (1, -1))
                for k in (0, 1):
                    add(begin + 2 * pair + k, FACE_RANGE * np.sqrt(2))
                    add(begin + 6 + 2 * pair + k, 1e-12 if held else FACE_RANGE)
            for (pair, sign), (tilt, covariance) in certified.items():
                white = np.linalg.inv(np.linalg.cholesky(covariance))
                row = np.zeros((2, self.size))
                row[:, begin + 2 * pair : begin + 2 * pair + 2] = white / 2
                row[:, begin + 6 + 2 * pair : begin + 8 + 2 * pair] = sign * white
                rows.extend(row)
                means.extend(white @ tilt)
        for i, at in enumerate(self.placements):
            add(self.heading_index(i), at.heading_std)
        return np.array(means), np.stack(rows)

    def certified_pairs(self, cube: int) -> list[bool]:
        """Say of each face pair whether any of its two faces has a certificate."""
        certified = self._certificates(cube)
        return [(pair, 1) in certified or (pair, -1) in certified for pair in range(3)]

    def _certificates(self, cube: int) -> dict[tuple[int, int], tuple[FloatArray, FloatArray]]:
        first = next(at.campaign for at in self.placements if at.cube == cube)
        return {
            (AXES.index(face[0]), 1 if face.endswith("up") else -1): (each.up_tilt, each.covariance)
            for face, each in self.campaigns[first].fixture.faces.items()
        }


def cube_numbers(campaigns: Sequence[Campaign]) -> IntArray:
    """Return (c,) the number of each campaign's cube: campaigns whose ``fixture.id`` agrees share one."""
    names: list[object] = [c.fixture.id if c.fixture.id is not None else object() for c in campaigns]
    first = {id(name) if not isinstance(name, str) else name: None for name in names}
    order = list(first)
    return np.array([order.index(id(n) if not isinstance(n, str) else n) for n in names], dtype=np.int64)


def tilt_names() -> list[str]:
    """Return the six names ``x.y``, ``x.z``, ``y.x`` ... of a cube's parallelism or perpendicularity."""
    return [f"{axis}.{AXES[k]}" for axis in AXES for k in cross_axes(f"{axis}_up")]
