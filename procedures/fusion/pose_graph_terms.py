"""The terms of the outer graph and their linearisation.

State of a node: position p (3) in n [m], yaw correction d [rad], then, where they are estimated, the antenna's
lever arm l (3) in b [m] and GNSS's time offset tau [s]. The attitude is ``C_nb = Rz(d) C_ob``: roll and pitch
are the odometry's. A correction, no Euler yaw, is carried, because an IMU's x axis may well point up.

    step    p_j - p_i - Rz(d_i) (p_oj - p_oi),   d_j - d_i         weighted by the odometry's drift
    fix     p_k + Rz(d_k) (a + C_of l + v_o (tau - tau0)) - z      a: from node k to the fix, C_of: attitude there
    course  (GNSS course - course of the odometry's velocity) - d_k

Huber's loss weights fix and course, by the length of the whitened residual (Han 2022 IV.B, whose eq. 9 is lost).

Node i is tied to node i + 1 and to nothing else, so that the matrix of the normal equations is a band
(`BlockTridiagonal`): ``D`` (n, d, d) are the blocks on the diagonal, ``U`` (n - 1, d, d) those above it, ``g``
(n, d) the gradient.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solveh_banded

from procedures.arrays import FloatArray, IntArray
from procedures.frames import wrapped


@dataclass(frozen=True, slots=True, eq=False)
class BlockTridiagonal:
    """Half of the second derivative of a cost over a chain, block by block, and half of its gradient."""

    D: FloatArray
    U: FloatArray
    g: FloatArray


def solve_chain(chain: BlockTridiagonal) -> tuple[FloatArray, FloatArray]:
    """Return the step (n, d) to the minimum, in the units of the nodes, and the covariance (d, d) of the last."""
    n, d = chain.g.shape
    right = np.zeros((n * d, 1 + d))
    right[:, 0] = -chain.g.ravel()
    right[-d:, 1:] = np.eye(d)
    solved = solveh_banded(_upper_band(chain), right, overwrite_ab=True, overwrite_b=True, check_finite=False)
    return solved[:, 0].reshape(n, d), solved[-d:, 1:]


def _upper_band(chain: BlockTridiagonal) -> FloatArray:
    """Return the matrix in LAPACK's upper band storage: element (i, j) at row w + i - j, w = 2 d - 1."""
    n, d = chain.g.shape
    band = np.zeros((2 * d, n, d))
    for row in range(d):
        for column in range(d):
            if row <= column:
                band[2 * d - 1 + row - column, :, column] = chain.D[:, row, column]
            band[d - 1 + row - column, 1:, column] = chain.U[:, row, column]
    return band.reshape(2 * d, n * d)


def eliminate(A: FloatArray, B: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what a node leaves to its neighbour when it is eliminated: ``-B' A^-1 B`` and ``-B' A^-1 a``.

    Parameters
    ----------
    A, B, a : (d, d), (d, d), (d,)
        The node's own block, its tie and its gradient, in the units of its state (the Schur complement).
    """
    factor = cho_factor(A, check_finite=False)
    return -B.T @ cho_solve(factor, B, check_finite=False), -B.T @ cho_solve(factor, a, check_finite=False)


CONSTANTS_WALK = 1e-4  # per sqrt(step): how far a lever arm [m] or a time offset [s], constants, may move
HUBER_FIX = 2.3  # of a whitened vector of three; 1.345 sqrt(3): 95 % efficient on clean fixes
HUBER_COURSE = 1.345
LEVER = slice(4, 7)


@dataclass(frozen=True, slots=True, eq=False)
class OdometrySteps:
    """Odometry of n nodes: ``step_o`` (n - 1, 3) [m] and the inverse of its drift ``info`` (n - 1, 4, 4)."""

    step_o: FloatArray
    info: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FixTerms:
    """Fixes as they are tied to nodes: ``node`` (m,), ``arm_o`` (m, 3) [m] from node to fix, ``C_of`` (m, 3, 3),
    ``v_o`` (m, 3) [m/s] of the antenna, ``tau`` (m,) [s] the offset that they were tied with, ``z`` (m, 3) [m],
    ``weight`` (m,) [1/m2]; ``course`` (m,) [rad] and ``course_weight`` (m,) [1/rad2], 0 where it says nothing.
    """  # noqa: D205

    node: IntArray
    arm_o: FloatArray
    C_of: FloatArray
    v_o: FloatArray
    tau: FloatArray
    z: FloatArray
    weight: FloatArray
    course: FloatArray
    course_weight: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class NodePrior:
    """What is known of the first node: information (d, d) and gradient (d,) at the state ``at`` (d,)."""

    info: FloatArray
    gradient: FloatArray
    at: FloatArray


@dataclass(frozen=True, slots=True)
class NodeLayout:
    """Which constants are estimated in addition to position and yaw."""

    lever_arm: bool = False
    time_offset: bool = False

    @property
    def size(self) -> int:
        """The length of a state."""
        return 4 + 3 * self.lever_arm + self.time_offset

    def lever_of(self, x: FloatArray, given: FloatArray) -> FloatArray:
        """Return the lever arm (..., 3) [m] of states ``x`` (..., d), or what was ``given`` (3,)."""
        return x[..., LEVER] if self.lever_arm else np.broadcast_to(given, (*x.shape[:-1], 3))

    def offset_of(self, x: FloatArray, given: float) -> FloatArray:
        """Return the time offset (...,) [s] of states ``x`` (..., d), or what was given."""
        return x[..., -1] if self.time_offset else np.full(x.shape[:-1], given)


def rz(yaw: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the rotations (..., 3, 3) about the vertical by ``yaw`` (...,) [rad] and their derivatives."""
    R, dR = np.zeros((*np.shape(yaw), 3, 3)), np.zeros((*np.shape(yaw), 3, 3))
    c, s = np.cos(yaw), np.sin(yaw)
    R[..., 0, 0] = R[..., 1, 1] = dR[..., 1, 0] = c
    R[..., 1, 0], R[..., 0, 1] = s, -s
    dR[..., 0, 0] = dR[..., 1, 1] = -s
    dR[..., 0, 1] = -c
    R[..., 2, 2] = 1.0
    return R, dR


def linearise(
    x: FloatArray, nodes: OdometrySteps, fixes: FixTerms, prior: NodePrior, layout: NodeLayout,
    lever_arm: FloatArray,
) -> tuple[BlockTridiagonal, FloatArray]:  # fmt: skip
    """Return the normal equations at states ``x`` (n, d), and the length (m,) of each fix's whitened residual.

    ``lever_arm`` (3,) [m] in b is what holds where it is not estimated.
    """
    n, d = x.shape
    chain = BlockTridiagonal(np.zeros((n, d, d)), np.zeros((n - 1, d, d)), np.zeros((n, d)))
    chain.D[0] += prior.info
    chain.g[0] += prior.gradient + prior.info @ (x[0] - prior.at)
    R, dR = rz(x[:, 3])
    _add_steps(chain, x, nodes, R, dR)
    size = _add_fixes(chain, x, fixes, layout, lever_arm, R, dR)
    _add_courses(chain, x, fixes)
    return chain, size


def _add_steps(
    chain: BlockTridiagonal, x: FloatArray, nodes: OdometrySteps, R: FloatArray, dR: FloatArray
) -> None:
    n, d = x.shape
    W = np.zeros((n - 1, d, d))
    W[:, :4, :4] = nodes.info
    W[:, range(4, d), range(4, d)] = 1 / CONSTANTS_WALK**2
    r = x[1:] - x[:-1]
    r[:, :3] -= np.einsum("nij,nj->ni", R[:-1], nodes.step_o)
    J = np.broadcast_to(-np.eye(d), (n - 1, d, d)).copy()
    J[:, :3, 3] = -np.einsum("nij,nj->ni", dR[:-1], nodes.step_o)
    JtW = J.transpose(0, 2, 1) @ W
    chain.D[:-1] += JtW @ J
    chain.D[1:] += W
    chain.U[:] = JtW
    chain.g[:-1] += (JtW @ r[..., None])[..., 0]
    chain.g[1:] += (W @ r[..., None])[..., 0]


def _add_fixes(
    chain: BlockTridiagonal, x: FloatArray, f: FixTerms, layout: NodeLayout, given: FloatArray, R: FloatArray,
    dR: FloatArray,
) -> FloatArray:  # fmt: skip
    at = x[f.node]
    lever = layout.lever_of(at, given)
    late = layout.offset_of(at, 0.0) - f.tau if layout.time_offset else np.zeros(len(at))
    arm = f.arm_o + np.einsum("nij,nj->ni", f.C_of, lever) + f.v_o * late[:, None]
    r = at[:, :3] + np.einsum("nij,nj->ni", R[f.node], arm) - f.z
    J = np.zeros((len(at), 3, x.shape[1]))
    J[:, range(3), range(3)] = 1.0
    J[:, :, 3] = np.einsum("nij,nj->ni", dR[f.node], arm)
    if layout.lever_arm:
        J[:, :, LEVER] = R[f.node] @ f.C_of
    if layout.time_offset:
        J[:, :, -1] = np.einsum("nij,nj->ni", R[f.node], f.v_o)
    size: FloatArray = np.linalg.norm(r, axis=1) * np.sqrt(f.weight)
    Jt = J.transpose(0, 2, 1) * (f.weight * huber(size, HUBER_FIX))[:, None, None]
    np.add.at(chain.D, f.node, Jt @ J)
    np.add.at(chain.g, f.node, (Jt @ r[..., None])[..., 0])
    return size


def _add_courses(chain: BlockTridiagonal, x: FloatArray, f: FixTerms) -> None:
    r = wrapped(f.course - x[f.node, 3])
    weight = f.course_weight * huber(np.abs(r) * np.sqrt(f.course_weight), HUBER_COURSE)
    np.add.at(chain.D[:, 3, 3], f.node, weight)
    np.add.at(chain.g[:, 3], f.node, -weight * r)


def huber(size: FloatArray, limit: float) -> FloatArray:
    """Return Huber's weights (n,) of whitened residuals ``size`` (n,): 1 within the limit, then limit / size."""
    return limit / np.maximum(size, limit)
