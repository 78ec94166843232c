"""The cost of a visual-inertial window as normal equations, and what leaves it as a prior (marginalisation)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.fusion.gnss_velocity import KeyframeFix
from procedures.fusion.inner.landmarks import DEFAULT_INVERSE_DEPTH, FREE, LOST, Landmarks, Visual, linearise
from procedures.fusion.inner.window_state import CAMERA, COMMON, FRAME, OFFSET, Factor, Normal, WindowState, zero
from procedures.fusion.inner.window_terms import Site, add_fixes, add_inertial, add_wheels
from procedures.fusion.preintegration import Preintegrated

DEPTH_STD = 1.0  # 1/m about `DEFAULT_INVERSE_DEPTH`: says nothing to sights, keeps the normal equations regular
RAY_WEIGHT = 1e-2  # of a ray, whose sights weigh 1e5


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is known from before: a normal equation at the state ``at``, of the first of the frames."""

    normal: Normal
    at: WindowState


@dataclass(frozen=True, slots=True, eq=False)
class WindowMeasurements:
    """What ties the keyframes: ``parts`` between them, and what ``fixes`` say at each."""

    parts: Sequence[Preintegrated]
    fixes: Sequence[KeyframeFix]


@dataclass(frozen=True, slots=True, eq=False)
class Eliminated:
    """Free landmarks that were eliminated: ``rows`` (l,), with what gives their step once the poses' is known."""

    rows: BoolArray
    columns: IntArray
    inverse: FloatArray
    W: FloatArray
    b: FloatArray

    def step(self, moved: FloatArray) -> FloatArray:
        """Return the landmarks' step (n, 3) for the state's step ``moved`` (size,), whitened units of `Sights`."""
        due = self.b + self.W @ moved[self.columns]
        return -(self.inverse @ due[:, :, None])[:, :, 0]


NOTHING = Eliminated(
    np.zeros(0, np.bool_), np.zeros(0, np.int64), np.zeros((0, 3, 3)), np.zeros((0, 3, 0)), np.zeros((0, 3))
)


def assemble(
    state: WindowState, prior: Prior, held: WindowMeasurements, site: Site, marks: Landmarks, seen: BoolArray,
    scale: FloatArray,
) -> tuple[Normal, Eliminated]:  # fmt: skip
    """Return the normal equations of prior, IMU, fixes and sights ``seen`` (l, k), whitened by ``scale`` (2,)."""
    normal = zero(state.size)
    _add_prior(normal, state, prior)
    add_inertial(normal, state, held.parts, site)
    add_fixes(normal, state, held.fixes)
    add_wheels(normal, state, [fix.wheel for fix in held.fixes])
    rows = seen.any(axis=1) & marks.ready
    if not len(rows):
        return normal, NOTHING
    sights = replace(marks.sights, seen=seen & rows[:, None])
    return normal, _add_visual(normal, state, linearise(state, sights, scale), marks, rows)


def _add_prior(normal: Normal, state: WindowState, prior: Prior) -> None:
    known = prior.at.held_from
    parts = (slice(known), slice(known, None))
    places = (slice(known), slice(state.held_from, state.held_from + 3 * len(prior.at.held)))
    moved = replace(state, held=state.held[: len(prior.at.held)]).less(prior.at)
    g = prior.normal.g + prior.normal.A @ moved
    for row, i in zip(places, parts, strict=True):
        normal.g[row] += g[i]
        for column, j in zip(places, parts, strict=True):
            normal.A[row, column] += prior.normal.A[i, j]


def _add_visual(
    normal: Normal, state: WindowState, visual: Visual, marks: Landmarks, rows: BoolArray
) -> Eliminated:
    starts = COMMON + FRAME * np.arange(len(state.p))
    columns = np.concatenate((np.arange(CAMERA), [OFFSET], (starts[:, None] + np.arange(6)).ravel()))
    free = rows & (marks.slot == FREE)
    visual.L[free] += np.diag([RAY_WEIGHT, RAY_WEIGHT, 1 / DEPTH_STD**2])
    visual.b[free, 2] += (marks.sights.at[free, 2] - DEFAULT_INVERSE_DEPTH) / DEPTH_STD**2
    W, b = visual.W[free], visual.b[free]
    root = np.asarray(np.linalg.inv(np.linalg.cholesky(visual.L[free])), np.float64)  # inverse = root' root
    inverse, V = np.swapaxes(root, 1, 2) @ root, (root @ W).reshape(-1, len(columns))
    normal.A[np.ix_(columns, columns)] += visual.H - V.T @ V
    normal.g[columns] += visual.g - V.T @ (root @ b[:, :, None]).ravel()
    fixed = np.flatnonzero(rows & ~free)
    slots = state.held_from + 3 * marks.slot[fixed][:, None] + np.arange(3)
    normal.A[slots[:, :, None], slots[:, None, :]] += visual.L[fixed]
    ties = visual.W[fixed].reshape(-1, len(columns))
    normal.A[np.ix_(slots.ravel(), columns)] += ties
    normal.A[np.ix_(columns, slots.ravel())] += ties.T
    normal.g[slots.ravel()] += visual.b[fixed].ravel()
    return Eliminated(free, columns, inverse, W, b)


@dataclass(frozen=True, slots=True, eq=False)
class BackSubstitution:
    """What was eliminated: its step is ``-(by[:, :-1] d + by[:, -1])`` for a step d (m,) of what stays.

    ``by`` is (n, m + 1); ``factor`` that of its own normal equations (n, n), what stays being known.
    """

    by: FloatArray
    factor: Factor


def marginalised(
    state: WindowState, prior: Prior, held: WindowMeasurements, site: Site, marks: Landmarks, scale: FloatArray
) -> tuple[Prior, BackSubstitution]:
    """Return the prior that the oldest keyframe leaves and how it went, and drop it from ``marks``.

    Landmarks it saw that are still followed are held by the prior from now on; those that are lost go with it,
    with all their sights, whitened by ``scale`` (2,), so that no sight is used twice and none is lost.
    """
    seen, followed = marks.sights.seen, marks.feature != LOST
    known = marks.slot != FREE
    concerned = marks.ready & (seen[:, :1].any(axis=1) | known)
    new = np.flatnonzero(concerned & followed & ~known)
    marks.slot[new] = len(state.held) + np.arange(len(new))
    state = replace(state, held=np.vstack((state.held, marks.sights.at[new])))
    used = seen & concerned[:, None]
    used[followed, 1:] = False
    one = WindowMeasurements(held.parts[:1], held.fixes[:1])
    normal, _ = assemble(state, prior, one, site, marks, used, scale)
    _add_first_guess(normal, state, marks, new)
    gone = marks.slot[(marks.slot != FREE) & ~followed]
    return _reduced(normal, state, marks, gone, concerned & ~followed)


def _add_first_guess(normal: Normal, state: WindowState, marks: Landmarks, new: IntArray) -> None:
    """Add what keeps a free landmark's depth regular, once, when it becomes one that is held."""
    at = state.held_from + 3 * marks.slot[new][:, None] + np.arange(3)
    normal.A[at, at] += [RAY_WEIGHT, RAY_WEIGHT, 1 / DEPTH_STD**2]
    normal.g[at[:, 2]] += (marks.sights.at[new, 2] - DEFAULT_INVERSE_DEPTH) / DEPTH_STD**2


def _reduced(
    normal: Normal, state: WindowState, marks: Landmarks, gone: IntArray, rows: BoolArray
) -> tuple[Prior, BackSubstitution]:
    """Eliminate the oldest keyframe and the slots ``gone``; drop ``rows`` of the landmarks, renumber the rest."""
    stays = np.ones(state.size, bool)
    stays[state.frame(0)] = False
    kept = ~np.isin(np.arange(len(state.held)), gone)
    stays[state.held_from :] = np.repeat(kept, 3)
    A, B = normal.A[np.ix_(~stays, ~stays)], normal.A[np.ix_(~stays, stays)]
    factor = Factor(A)
    solved = factor.solve(np.column_stack((B, normal.g[~stays])))
    left = normal.A[np.ix_(stays, stays)] - B.T @ solved[:, :-1]
    g = normal.g[stays] - B.T @ solved[:, -1]
    held = marks.slot != FREE
    marks.slot[held] = (np.cumsum(kept) - 1)[marks.slot[held]]
    marks.keep(~rows)
    marks.drop_first_frame()
    after = replace(state.part(slice(1, None)), held=state.held[kept])
    return Prior(Normal((left + left.T) / 2, g), after), BackSubstitution(solved, factor)


def walked(prior: Prior, at: int, variance: float) -> Prior:
    """Return what is known after the unknown ``at`` has walked by ``variance``."""
    normal = prior.normal
    A, g, stiff = normal.A, normal.g, 1 / variance
    row, pull, whole = A[at].copy(), float(g[at]), float(A[at, at]) + stiff
    loose, moved = A - np.outer(row, row) / whole, g - row * pull / whole
    loose[at], loose[:, at] = row * stiff / whole, row * stiff / whole
    moved[at] = pull * stiff / whole
    return replace(prior, normal=Normal(loose, moved))
