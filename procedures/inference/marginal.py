"""The marginal likelihood of hypotheses, with the model's parameters, coefficients and amplitudes integrated out.

In the complement of the model's own columns the whitened residual y (m,) is N(0, I + S S') for members of columns
S, each times its amplitude (a Gaussian prior of its coefficients integrated out). With M = I + S'S, b = S'y,

    ln p(y | S) - ln p(y) = -1/2 ln det M + 1/2 b' M^-1 b

One hypothesis more, of columns W and amplitude s, with C = I + S S', G = W' C^-1 W = V diag(l) V' and
g = V' W' C^-1 y:

    gain(s) = -1/2 sum ln(1 + s^2 l) + 1/2 sum s^2 g^2 / (1 + s^2 l)

Where the noise is known to nu degrees of freedom only, as from the rows' own scatter, y is Student t: with q the
sum of squares y' C^-1 y, -q / 2 becomes -(nu + m) / 2 ln(1 + q / nu).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.special import log_ndtr

from procedures.arrays import FloatArray
from procedures.inference.board import Block, Board, Option

APART = 1e-12  # of two columns' lengths: a product below is rounding


@dataclass(frozen=True, slots=True)
class Member:
    """An option of a board by its number, and the amplitude at which it is held."""

    option: int
    amplitude: float


@dataclass(frozen=True, slots=True, eq=False)
class Ranked:
    """Every option with some members.

    ``gains`` (options,) is ln of the marginal likelihood over the amplitudes' prior, the option's share counted,
    ``best`` (options,) that at the best amplitude, ``amplitude`` (options,) which that is. ``total`` (hypotheses,)
    is ln of prior odds times marginal likelihood, all options together.
    """

    gains: FloatArray
    best: FloatArray
    amplitude: FloatArray
    total: FloatArray

    def member(self, board: Board, hypothesis: int) -> Member:
        """Return a hypothesis' best option."""
        own = board.options_of[hypothesis]
        option = int(own[np.argmax(self.best[own])])
        return Member(option, float(self.amplitude[option]))


def stacked(board: Board, members: Sequence[Member]) -> FloatArray:
    """Return the members' columns (m, s), each times its amplitude."""
    parts = [board.W[:, board.options[each.option].columns] * each.amplitude for each in members]
    return np.hstack(parts) if parts else np.zeros((len(board.y), 0))


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Members held at their amplitudes: with Q R = [S; I], the inverse of C is I - Q1 Q1', Q1 the upper part of Q.

    ``Q1`` is (m, s), ``Q2`` (s, s), ``inverse`` (s, s) that of M, ``c`` (s,) M^-1 S'y, ``squares`` y' C^-1 y.

    Large members that are nearly the same leave no digits of a difference of products. So what adds to them is
    projected out of the columns themselves.
    """

    Q1: FloatArray
    Q2: FloatArray
    inverse: FloatArray
    c: FloatArray
    squares: float
    gain: float

    @classmethod
    def of(cls, board: Board, members: Sequence[Member]) -> "Held":
        """Hold members."""
        S = stacked(board, members)
        m, s = S.shape
        Q, R = np.linalg.qr(np.vstack((S, np.eye(s))))
        back, along = np.linalg.solve(R, np.eye(s)), Q[:m].T @ board.y
        left = np.append(board.y - Q[:m] @ along, Q[m:] @ along)
        yy, squares = float(board.y @ board.y), float(left @ left)
        gain = float(tail(board, np.array(squares)) - tail(board, np.array(yy)))
        gain -= float(np.sum(np.log(np.abs(np.diag(R)))))
        return cls(Q[:m], Q[m:], back @ back.T, back @ along, squares, gain)

    def project_out(self, W: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what members leave of columns W (m, n) and what they take, (m + s, n) and (s, n).

        The first one's square is W' C^-1 W.
        """
        along = self.Q1.T @ W
        return np.vstack((W - self.Q1 @ along, -self.Q2 @ along)), along


def tail(board: Board, squares: FloatArray) -> FloatArray:
    """Return ln of the density, shaped like ``squares``: the sum of squares of y, whitened, that is left."""
    return log_density(squares, len(board.y), board.evidence.noise_dof)


def log_density(squares: FloatArray, rows: float, nu: float) -> FloatArray:
    """Return ln of the density (m,) of whitened ``rows`` by their sum of ``squares`` (m,) [sigma^2].

    The noise is known to ``nu`` degrees of freedom.
    """
    if not np.isfinite(nu):
        return -0.5 * squares
    found: FloatArray = -0.5 * (nu + rows) * np.log1p(np.maximum(squares, 0.0) / nu)
    return found


def ranked(board: Board, members: Sequence[Member], only: int | None = None) -> Ranked:
    """Return what every hypothesis, or ``only`` one, is worth with members; nothing where these are its own."""
    held, n = Held.of(board, members), len(board.options)
    gains, best, amplitude = np.full(n, -np.inf), np.full(n, -np.inf), np.zeros(n)
    blocks = board.blocks if only is None else board.blocks_of[only]
    every = np.arange(n) if only is None else board.options_of[only]
    columns, W = np.arange(board.W.shape[1]), board.W
    if only is not None:
        columns = np.unique(np.concatenate([board.options[i].columns for i in every.tolist()]))
        W = W[:, columns]
    beyond, along = held.project_out(W)
    rest, left = np.ascontiguousarray(beyond.T), beyond[: len(board.y)].T @ board.y
    number = np.zeros(board.W.shape[1], dtype=np.int64)
    number[columns] = np.arange(len(columns))
    for block in blocks:
        of = rest[number[block.columns]]  # (b, k, m + s)
        G, g = of @ np.swapaxes(of, 1, 2), left[number[block.columns]]
        values = gains_of(board, held.squares, G, g, block)
        most = np.argmax(values, axis=1)
        at = np.arange(len(most))
        shares = np.array([board.options[i].log_share for i in block.options])
        gains[block.options] = shares + log_mean(values + block.log_weights)
        best[block.options] = shares + values[at, most]
        amplitude[block.options] = block.amplitudes[at, most]
    for i in every.tolist():
        option = board.options[i]
        if option.taken is not None:
            own = number[option.columns]
            values = _gains_of_rows(board, held, option, along[:, own].T, left[own])
            most = int(np.argmax(values))
            gains[i] = option.log_share + log_mean(values)
            best[i], amplitude[i] = option.log_share + values[most], _amplitudes(board, option)[most]
    for member in members:
        same = board.same_as[member.option]
        gains[same] = best[same] = -np.inf
    total = np.array([
        each.log_odds + (log_sum(gains[own]) if len(own) else -np.inf)
        for each, own in zip(board.hypotheses, board.options_of, strict=True)
    ])  # fmt: skip
    return Ranked(gains, best, amplitude, total)


def gains_of(board: Board, squares: float, G: FloatArray, g: FloatArray, block: Block) -> FloatArray:
    """Return the gain (b, amplitudes) of options with G (b, k, k) and g (b, k)."""
    if G.shape[1] == 1:
        size, along = np.maximum(G[:, 0], 0.0), g
    else:
        size, along = _eigenvalues(G, g)
    found = gains_along(size, along, block.amplitudes, np.array(squares), len(board.y), board.evidence.noise_dof)
    gains: FloatArray = found + _log_positive(G, g, block.amplitudes) if block.is_loss else found
    return gains


def _eigenvalues(G: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the eigenvalues (b, k) of G (b, k, k) and g (b, k) along its eigenvectors.

    Columns that have nothing in common, as of sensors, are taken apart: the time goes with the cube.
    """
    length = np.sqrt(np.maximum(np.diagonal(G, axis1=1, axis2=2), 0.0))
    in_common = np.any(np.abs(G) > APART * length[:, :, None] * length[:, None, :], axis=0)
    number, part = connected_components(in_common, directed=False)
    size, along = np.empty(g.shape), np.empty(g.shape)
    for own in (np.flatnonzero(part == i) for i in range(number)):
        size[:, own], V = np.linalg.eigh(G[:, own[:, None], own])
        along[:, own] = np.einsum("bij,bi->bj", V, g[:, own])
    return np.maximum(size, 0.0), along


def gains_along(
    size: FloatArray,
    along: FloatArray,
    amplitudes: FloatArray,
    squares: FloatArray,
    rows: float,
    nu: float,
    times: FloatArray | float = 1.0,
) -> FloatArray:
    """Return the gain (b, m) at ``amplitudes`` (b, m) [1] by the eigenvalues l and the V'g of some columns.

    Parameters
    ----------
    size, along : (b, k), each eigenvalue ``times`` times, with ``along`` squared the sum over all of them
    squares : (b,), the sum of squares of the whitened data [sigma^2]
    rows, nu : how many these are, and to how many degrees of freedom their noise is known
    times : (k,)
    """
    s2 = amplitudes[..., None] ** 2
    spread = 1 + s2 * size[..., None, :]
    explained = np.sum(s2 * along[..., None, :] ** 2 / spread, axis=-1)
    found = -0.5 * np.sum(times * np.log(spread), axis=-1)
    whole = squares[..., None]
    gains: FloatArray = found + log_density(whole - explained, rows, nu) - log_density(whole, rows, nu)
    return gains


def _amplitudes(board: Board, option: Option) -> FloatArray:
    return board.hypotheses[option.hypothesis].amplitudes


def _gains_of_rows(board: Board, held: Held, option: Option, by_members: FloatArray, g: FloatArray) -> FloatArray:
    """Return the gain (amplitudes,) of an option whose columns are single rows, with what is held.

    Then G = I - U U' with few columns U: but for these directions it has the eigenvalue 1. ``by_members`` (k, s)
    is what the members take of the columns, ``g`` (k,) what they leave of W'y.
    """
    assert option.taken is not None
    X, sigma, _ = np.linalg.svd(np.hstack((option.taken, by_members)), full_matrices=False)
    along = X.T @ g
    rest = max(float(g @ g - along @ along), 0.0)
    return gains_along(
        np.append(np.maximum(1 - sigma**2, 0.0), 1.0), np.append(along, np.sqrt(rest)), _amplitudes(board, option),
        np.array(held.squares), len(board.y), board.evidence.noise_dof,
        np.append(np.ones(len(sigma)), len(g) - len(sigma)),
    )  # fmt: skip


def _log_positive(G: FloatArray, g: FloatArray, amplitudes: FloatArray) -> FloatArray:
    """Return ln of how much likelier coefficients above zero are with the data than before (b, amplitudes)."""
    size, V = np.linalg.eigh(G)
    variances = 1 / (np.maximum(size, 0.0)[:, None] + 1 / amplitudes[:, :, None] ** 2)
    C = (V[:, None] * variances[:, :, None, :]) @ np.swapaxes(V, 1, 2)[:, None]
    mean = np.einsum("baij,bj->bai", C, g)
    found: FloatArray = np.sum(np.log(2) + log_ndtr(mean / np.sqrt(np.einsum("baii->bai", C))), axis=2)
    return found


def log_mean(x: FloatArray) -> FloatArray:
    """Return ln of the mean (...) of exp(x) along the last axis of x (..., n), both without unit."""
    most = np.max(x, axis=-1, keepdims=True)
    found: FloatArray = np.log(np.mean(np.exp(x - most), axis=-1)) + most[..., 0]
    return found


def log_sum(x: FloatArray) -> float:
    """Return ln of the sum of exp(x) (n,)."""
    most = float(np.max(x))
    return most + float(np.log(np.sum(np.exp(x - most)))) if np.isfinite(most) else -np.inf
