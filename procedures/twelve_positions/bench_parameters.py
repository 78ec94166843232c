"""Parameters of the bench with priors: plate tilt, face tilts, headings, gravity, and the mean cube.

Opposite faces share parallelism p, the sum of both up tilts, and perpendicularity q, half their difference: tilts
are p/2 + q with the axis up and p/2 - q with it down. Turning the misalignment with q changes nothing that twelve
positions can see, to first order: without a certificate q is held at what p makes likely by the machining items
of a face (Yao, Hu and He 2018, table 2: one for X up, three for X down, three and five for Y and Z). Misalignment
is reported for the *mean cube*, each pair's two normals averaged.

To second order the skew ``S_xy = q_xy + q_yx`` enters the bias, ``dD_x = -(S_xy p_xy + S_xz p_xz) / 2``
(`skew_jacobian`): 0.7e-7 g on Yao 2018's cube if q is zero.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.campaign.campaign import Campaign, MeasuredCube, Site
from procedures.campaign.measured_cube import NAMES, SKEW, from_tilts
from procedures.frames import AXES, rotation, slab_C_ln
from procedures.positions import cross_axes, face_normal, face_of, nominal_C_lb
from procedures.units import STANDARD_GRAVITY

FACE_TILT_RANGE_RAD = 1e-3  # rad, 1 sigma: a cube 0.4 mm off in 400 mm is not a fixture
MACHINING_ITEMS_UP, MACHINING_ITEMS_DOWN = np.array([1.0, 3.0, 3.0]), np.array([3.0, 5.0, 5.0])
HELD_STD_RAD = 1e-9  # rad, 1 sigma of what is held: far below any tilt, yet no more than the arithmetic bears
SLAB_TILT_RANGE_RAD = 5e-3  # rad, 1 sigma: 0.3 deg


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """One step's cube on the slab: which campaign, which cube, which position, 1 sigma of its heading [rad]."""

    campaign: int
    cube: int
    position: int
    heading_std: float


@dataclass(frozen=True, slots=True, eq=False)
class BenchPrior:
    """Rows of prior knowledge: the whitened residual is ``matrix @ x - mean``; matrix (k, p), mean (k,).

    ``loose`` (k,) marks plausible ranges: they keep a parameter in bounds and are no measurements of it.
    """

    mean: FloatArray
    matrix: FloatArray
    loose: BoolArray


@dataclass(frozen=True, eq=False)
class BenchParameters:
    """The nuisance parameters of all steps and where each stands in their vector ``x`` (p,).

    Order: per campaign slab tilt (2); per site relative gravity error (1); per cube parallelism (6) and
    perpendicularity (6), row by face pair; per placement heading (1).
    """

    placements: tuple[Placement, ...]
    campaigns: tuple[Campaign, ...]
    cubes: int
    skew_seen: bool = False  # by rests in free attitudes: then only the cube's turning as a whole is held

    @cached_property
    def sites(self) -> tuple[Site, ...]:
        """The sites: campaigns at one share its gravity and that gravity's error."""
        return tuple(dict.fromkeys(campaign.site for campaign in self.campaigns))

    @property
    def shared(self) -> int:
        """Number of parameters that belong to no single placement."""
        return 2 * len(self.campaigns) + len(self.sites) + 12 * self.cubes

    @property
    def size(self) -> int:
        """Number of parameters."""
        return self.shared + len(self.placements)

    def slab(self, x: FloatArray, campaign: int) -> FloatArray:
        """Slab tilt (2,) [rad]: East and North components of the up vector seen from the slab."""
        return x[2 * campaign : 2 * campaign + 2]

    def gravity(self, x: FloatArray, campaign: int) -> FloatArray:
        """Local gravity (...) [g] of parameters (..., p)."""
        site = self.campaigns[campaign].site
        error = x[..., 2 * len(self.campaigns) + self.sites.index(site)]
        found: FloatArray = site.gravity / STANDARD_GRAVITY * (1 + error)
        return found

    def cube_slice(self, cube: int) -> slice:
        """Where a cube's parallelism (6) and perpendicularity (6) stand."""
        begin = 2 * len(self.campaigns) + len(self.sites) + 12 * cube
        return slice(begin, begin + 12)

    def heading_index(self, placement: int) -> int:
        """Where a placement's heading stands."""
        return self.shared + placement

    def parallelism(self, x: FloatArray, cube: int = 0) -> FloatArray:
        """Parallelism (3, 2) [rad] of a cube."""
        return x[self.cube_slice(cube)][:6].reshape(3, 2)

    def perpendicularity(self, x: FloatArray, cube: int = 0) -> FloatArray:
        """Perpendicularity (3, 2) [rad] of a cube."""
        return x[self.cube_slice(cube)][6:].reshape(3, 2)

    @cached_property
    def C_sb(self) -> FloatArray:
        """For every placement the rotation (m, 3, 3) from the cube's axes to the IMU's."""
        mountings = [self.campaigns[at.campaign].fixture.C_sb for at in self.placements]
        return np.array(mountings).reshape(-1, 3, 3)

    @cached_property
    def _nominal(self) -> FloatArray:
        return np.array([nominal_C_lb(at.position).T for at in self.placements]).reshape(-1, 3, 3)

    @cached_property
    def _campaign(self) -> IntArray:
        return np.array([at.campaign for at in self.placements])

    @cached_property
    def _turn_by_tilts(self) -> FloatArray:
        """(q, 3 m): takes cubes' parameters to rotation vectors of all placements' faces, as `face_rotation`."""
        G = np.zeros((len(self.placements), 3, self.size))
        for i, at in enumerate(self.placements):
            face = face_of(at.position)
            turn = np.stack([np.cross(face_normal(face), np.eye(3)[k]) for k in cross_axes(face)], axis=1)
            p = self.cube_slice(at.cube).start + 2 * AXES.index(face[0])
            G[i, :, p : p + 2] = turn / 2
            G[i, :, p + 6 : p + 8] = turn if face.endswith("up") else -turn
        return G[..., self.cube_slice(0).start : self.shared].reshape(3 * len(G), 12 * self.cubes).T

    @cached_property
    def _last(self) -> dict[str, tuple[bytes, FloatArray]]:
        return {}

    def _once(self, name: str, of: FloatArray, made: Callable[[], FloatArray]) -> FloatArray:
        """Return what was made last of the same numbers: a Jacobian's differences move one parameter at a time."""
        key = of.tobytes()
        known = self._last.get(name)
        if known is None or known[0] != key:
            known = self._last[name] = key, made()
            known[1].flags.writeable = False
        return known[1]

    def to_cube(self, x: FloatArray) -> FloatArray:
        """Return rotations (..., m, 3, 3) [1] from the slab's marks, at nominal heading, to placements' cubes."""
        tilts = x[..., self.cube_slice(0).start : self.shared]
        turned = (*x.shape[:-1], len(self.placements), 3)
        return self._once(
            "cube", tilts, lambda: rotation((tilts @ self._turn_by_tilts).reshape(turned)) @ self._nominal
        )

    def seen(self, x: FloatArray, vector_n: Sequence[FloatArray], motion: FloatArray | None = None) -> FloatArray:
        """Return (..., m, 3): each campaign's vector as every placement's cube sees it, in the vector's unit.

        All placements at once: this is the inner loop of the solve.

        Parameters
        ----------
        x : (..., p) the bench's parameters
        vector_n : a vector (3,) or (..., 3) of each campaign, East-North-Up, any unit
        motion : (m, 3, 3) [s], the integral over a turn of the rotation from its start; 1 of a dwell
        """
        on_slab = self._slabs(x) @ np.stack(vector_n, axis=-2)[..., None]
        turned = self._headings(x) @ on_slab[..., self._campaign, :, :]
        if motion is not None:
            turned = motion @ turned
        found: FloatArray = (self.to_cube(x) @ turned)[..., 0]
        return found

    def attitudes(self, x: FloatArray, seats: FloatArray | None = None) -> FloatArray:
        """Return (..., m, 3, 3): from East-North-Up to every placement's cube.

        ``x`` (..., p) are the bench's parameters, ``seats`` (..., m, 3) [rad] the cubes' rotation vectors in
        addition.
        """
        on_slab = self._slabs(x)[..., self._campaign, :, :]
        found: FloatArray = self.to_cube(x) @ self._headings(x) @ on_slab
        return found if seats is None else rotation(seats) @ found

    def _slabs(self, x: FloatArray) -> FloatArray:
        """Return (..., c, 3, 3): from East-North-Up to each campaign's slab."""
        tilts = x[..., : 2 * len(self.campaigns)]
        return self._once("slab", tilts, lambda: slab_C_ln(tilts.reshape(*x.shape[:-1], -1, 2)))

    def _headings(self, x: FloatArray) -> FloatArray:
        """Return (..., m, 3, 3): the turn of every placement by its heading's error."""
        angles = x[..., self.heading_index(0) : self.size]
        return self._once("heading", angles, lambda: rotation(-angles[..., None] * [0.0, 0.0, 1.0]))

    def seen_by_imu(
        self, x: FloatArray, vector_n: Sequence[FloatArray], motion: FloatArray | None = None
    ) -> FloatArray:
        """Return `seen` (..., m, 3) of ``x``, ``vector_n``, ``motion`` in the IMU's axes.

        Parameters
        ----------
        x, vector_n, motion : (..., p), (..., 3) each and (m, 3, 3) [s], as `seen` takes them
        """
        return (self.C_sb @ self.seen(x, vector_n, motion)[..., None])[..., 0]

    def priors(self) -> "BenchPrior":
        """Return what is known before the first count.

        Perpendicularity without a certificate is held where `MACHINING_ITEMS_UP` and `MACHINING_ITEMS_DOWN` put
        it; where the skew is seen or was measured, only the part of it that turns the cube.
        """
        blocks = list[tuple[FloatArray, FloatArray, bool]]()  # rows (n, p), means (n,), whether they are ranges

        def add(index: int, sigma: float, is_range: bool = False) -> FloatArray:
            row = np.zeros((1, self.size))
            row[0, index] = 1 / sigma
            blocks.append((row, np.zeros(1), is_range))
            return row

        for i in range(2 * len(self.campaigns)):
            add(i, SLAB_TILT_RANGE_RAD, True)
        for i, site in enumerate(self.sites):
            add(2 * len(self.campaigns) + i, site.gravity_std / site.gravity)
        for cube in range(self.cubes):
            certified = self._certificates(cube)
            begin = self.cube_slice(cube).start
            for pair in range(3):
                held = self.held_pairs(cube)[pair] and not self.skew_known(cube)
                for k in (0, 1):
                    add(begin + 2 * pair + k, FACE_TILT_RANGE_RAD * np.sqrt(2), True)
                    q = add(begin + 6 + 2 * pair + k, HELD_STD_RAD if held else FACE_TILT_RANGE_RAD, not held)
                    if held:
                        q[0, begin + 2 * pair + k] = -_datum_share(pair) / HELD_STD_RAD
            for (pair, sign), (tilt, covariance) in certified.items():
                white = np.linalg.inv(np.linalg.cholesky(covariance))
                row = np.zeros((2, self.size))
                row[:, begin + 2 * pair : begin + 2 * pair + 2] = white / 2
                row[:, begin + 6 + 2 * pair : begin + 8 + 2 * pair] = sign * white
                blocks.append((row, white @ tilt, False))
            if (measured := self.measured(cube)) is not None:
                white = np.linalg.inv(np.linalg.cholesky(measured.covariance))
                row = np.zeros((len(measured.names), self.size))
                row[:, begin : begin + 12] = white @ from_tilts()[[NAMES.index(name) for name in measured.names]]
                blocks.append((row, white @ measured.value, False))
            if self.skew_known(cube):
                blocks += [(row[None], np.zeros(1), False) for row in self._held_turns(cube)]
        for i, at in enumerate(self.placements):
            add(self.heading_index(i), at.heading_std)
        rows, means, is_range = zip(*blocks, strict=True)
        loose = np.repeat(is_range, [len(mean) for mean in means])
        return BenchPrior(np.concatenate(means), np.concatenate(rows), loose)

    def measured(self, cube: int) -> MeasuredCube | None:
        """Return what IMUs measured of a cube before; None of one that nobody did."""
        return self.campaigns[self._campaign_of(cube)].fixture.measured

    def skew_known(self, cube: int = 0) -> bool:
        """Say whether rests in free attitudes show a cube's skew, or it was measured: it is then not held."""
        measured = self.measured(cube) if self.cubes else None
        return self.skew_seen or (measured is not None and any(name in SKEW for name in measured.names))

    def _held_turns(self, cube: int) -> list[FloatArray]:
        """Return rows (p,) that hold ``q_ac - q_ca`` of uncertified pairs a, c where their p makes it likely."""
        begin, held, rows = self.cube_slice(cube).start, self.held_pairs(cube), list[FloatArray]()
        for a, c in ((0, 1), (0, 2), (1, 2)):
            row = np.zeros(self.size)
            for pair, other, sign in ((a, c, 1.0), (c, a, -1.0)):
                at = begin + 2 * pair + cross_axes(f"{AXES[pair]}_up").index(other)
                row[at + 6], row[at] = sign / HELD_STD_RAD, -sign * _datum_share(pair) / HELD_STD_RAD
            rows += [row] if held[a] and held[c] else []
        return rows

    def held_pairs(self, cube: int) -> list[bool]:
        """Say of each face pair whether its perpendicularity is held: of the first cube, without a certificate.

        A second cube differs from the first, and an IMU turned in its cube sees the difference: there it is free.
        """
        certified = self._certificates(cube)
        mountings = {c.fixture.C_sb.tobytes() for c in self.campaigns}
        alone = cube == 0 and len(mountings) == 1
        return [alone and (pair, 1) not in certified and (pair, -1) not in certified for pair in range(3)]

    def certified_pairs(self, cube: int) -> list[bool]:
        """Say of each face pair whether its parallelism is known: certified of both faces, or measured by IMUs."""
        certified, measured = self._certificates(cube), self.measured(cube) is not None
        return [measured or {(pair, 1), (pair, -1)} <= set(certified) for pair in range(3)]

    def _campaign_of(self, cube: int) -> int:
        stands = (at.campaign for at in self.placements if at.cube == cube)
        return next(stands, cube_numbers(self.campaigns).tolist().index(cube))

    def _certificates(self, cube: int) -> dict[tuple[int, int], tuple[FloatArray, FloatArray]]:
        return {
            (AXES.index(face[0]), 1 if face.endswith("up") else -1): (each.up_tilt, each.covariance)
            for face, each in self.campaigns[self._campaign_of(cube)].fixture.faces.items()
        }


def _datum_share(pair: int) -> float:
    """Return q / p of the likeliest cube: the up face's share of p, less a half."""
    return float(MACHINING_ITEMS_UP[pair] / (MACHINING_ITEMS_UP[pair] + MACHINING_ITEMS_DOWN[pair]) - 0.5)


def cube_numbers(campaigns: Sequence[Campaign]) -> IntArray:
    """Return (c,) the number of each campaign's cube: campaigns whose ``fixture.id`` agrees share one."""
    names = [i if c.fixture.id is None else c.fixture.id for i, c in enumerate(campaigns)]
    order = list(dict.fromkeys(names))
    return np.array([order.index(name) for name in names], dtype=np.int64)


def tilt_names() -> list[str]:
    """Return the six names ``x.y``, ``x.z``, ``y.x`` ... of a cube's parallelism or perpendicularity."""
    return [f"{axis}.{AXES[k]}" for axis in AXES for k in cross_axes(f"{axis}_up")]


def mean_cube(q: FloatArray) -> FloatArray:
    """Return (3, 3): columns the unit mean normals of the face pairs for perpendicularity ``q`` (3, 2)."""
    normals = np.eye(3)
    for pair, axis in enumerate(AXES):
        normals[list(cross_axes(f"{axis}_up")), pair] = q[pair]
    unit: FloatArray = normals / np.linalg.norm(normals, axis=0)
    return unit


def mean_axes(q: FloatArray) -> FloatArray:
    """Return (3, 3): columns the axes nearest to `mean_cube` for ``q`` (3, 2) [rad], its polar factor."""
    U, _, Vt = np.linalg.svd(mean_cube(q))
    axes: FloatArray = U @ Vt
    return axes


def skew_variance(p: FloatArray, held: Sequence[bool]) -> FloatArray:
    """Return the variance (3,) [rad^2] of the skews S_xy, S_xz, S_yz of a cube whose parallelism is ``p`` (3, 2).

    An item's variance is judged from p, whose two values per pair have the pair's items between them; the factor
    is the mean of the posterior of a variance seen with that many degrees of freedom. Certified pairs add none.
    """
    free = np.asarray(held)
    items = MACHINING_ITEMS_UP + MACHINING_ITEMS_DOWN
    if not free.any():
        return np.zeros(3)
    item = np.sum((p**2 / items[:, None])[free]) / max(2 * free.sum() - 2, 1)
    q = np.where(free, item * MACHINING_ITEMS_UP * MACHINING_ITEMS_DOWN / items, 0.0)
    return np.array([q[0] + q[1], q[0] + q[2], q[1] + q[2]])


def skew_jacobian(p: FloatArray, E: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return d(k)/k (3, 3) and dD (3, 3) [g] by the skews S_xy, S_xz, S_yz [rad]; rows are sensors in cube axes.

    ``p`` (3, 2) [rad] is the cube's parallelism, ``E`` (3, 3) the misalignment, sensors and columns in cube axes.
    ``|K_q|`` changes by ``k E_qa E_qc S_ac`` as the cube's skew turns misalignment into it.
    """
    pairs = ((0, 1), (0, 2), (1, 2))
    scale = np.stack([E[:, a] * E[:, c] for a, c in pairs], axis=1)
    table = np.zeros((3, 3))
    for pair, axis in enumerate(AXES):
        table[pair, list(cross_axes(f"{axis}_up"))] = p[pair]
    bias = np.zeros((3, 3))
    for k, (a, c) in enumerate(pairs):
        bias[a, k], bias[c, k] = -table[a, c] / 2, -table[c, a] / 2
    return scale, bias
