"""Which effects of the instrument a design could tell, and which it would take for one another: by its columns.

As in a diagnosis an effect's columns, of the catalogue and at nominal attitudes, stand beside the joint fit's own
(K, b, slab, faces, headings, seats, with what is known of them). Dwells show their mean, turns and moves what they
add up to; a move is the shortest way at an even speed, its specific force gravity alone. What the joint fit leaves
of an effect's columns says the sigma of its coefficients. Temperatures are not planned: their effects are left
out.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.effects import EFFECTS
from procedures.effects.effect import Excitation
from procedures.evidence.candidates import NAVIGATION_GRADE_STD
from procedures.planning.campaign_design import CampaignDesign
from procedures.planning.design_excitation import DesignStep, design_steps, excitation_of, rows_of
from procedures.planning.design_sigmas import RIDGE, DesignSigmas
from procedures.planning.placing_rows import OWN, SEAT, SHARED
from procedures.planning.step_information import NO_CLOSURE_STD_RAD

STANDS_SIGMAS = 3.0  # of a coefficient of its plausible size
NOTHING = 1e-9  # of information in what nothing excites


@dataclass(frozen=True, slots=True)
class ToldEffect:
    """An effect, whether it would show where it has its plausible size, and which others could take its place."""

    name: str
    is_told: bool
    not_apart: tuple[str, ...] = ()


def effects_told(sigmas: DesignSigmas, design: CampaignDesign) -> list[ToldEffect]:
    """Return every effect of the instrument of which a design's steps can speak, in the catalogue's order."""
    campaign, hands = sigmas.steps.campaign, sigmas.steps.hands
    steps = design_steps(campaign, hands, design)
    A, known, std = _base(sigmas, design, steps)
    columns = _columns(steps, excitation_of(campaign, steps), std)
    names, edges = list(columns), np.cumsum([0, *(H.shape[1] for H in columns.values())])
    M = _left(np.concatenate(list(columns.values()), axis=1), A, known)
    at = {name: slice(*edges[i : i + 2]) for i, name in enumerate(names)}
    return [_told(name, M, at) for name in names]


def _left(H: FloatArray, A: FloatArray, known: FloatArray) -> FloatArray:
    """Return the information (k, k) on the coefficients of H (r, k) that the base model A (r, p) leaves."""
    N = A.T @ A + known
    scale = 1 / np.sqrt(np.maximum(np.diag(N), NOTHING))
    whole = N * np.outer(scale, scale) + RIDGE * np.eye(len(N))
    across = scale[:, None] * (A.T @ H)
    left: FloatArray = H.T @ H - across.T @ np.linalg.solve(whole, across)
    return left


def _told(name: str, M: FloatArray, at: Mapping[str, slice]) -> ToldEffect:
    own = at[name]
    alone = _stands(M[own, own])
    if not alone.any():
        return ToldEffect(name, False)
    alike = list[str]()
    for other, theirs in at.items():
        beside = M[theirs, theirs] + np.eye(theirs.stop - theirs.start)  # held to its plausible size
        shared = M[theirs, own]
        left = M[own, own] - shared.T @ np.linalg.solve(beside, shared)
        if other != name and not _stands(left)[alone].any():
            alike.append(other)
    return ToldEffect(name, True, tuple(alike))


def _stands(information: FloatArray) -> BoolArray:
    """Say of each coefficient (k,) whether one of its plausible size stands, by the information on such sizes."""
    variance = np.diag(np.linalg.inv(information + NOTHING * np.eye(len(information))))
    stands: BoolArray = STANDS_SIGMAS**2 * variance < 1
    return stands


def _columns(steps: list[DesignStep], excitation: Excitation, std: FloatArray) -> dict[str, FloatArray]:
    """Return whitened columns (r, k), for coefficients of plausible size, of effects that have one way to act."""
    grades = _grades(steps, std)
    found = dict[str, FloatArray]()
    for effect in EFFECTS:
        if effect.kind != "instrument" or effect.is_scatter:
            continue
        ways = effect.columns(excitation)
        if len(ways) != 1 or ways[0].nonlinear:
            continue
        sizes = grades[effect.name.startswith("gyroscope")] * effect.plausible_of(ways[0])
        H = rows_of(steps, excitation, ways[0]) * sizes / std[:, None]
        if np.all(np.isfinite(H)) and H.any():
            found[effect.name] = H
    return found


def _grades(steps: list[DesignStep], std: FloatArray) -> tuple[float, float]:
    """Return by how much plausible sizes of effects are wider than of navigation grade, of each triad."""
    kinds = np.concatenate([np.repeat((0, 1) if s.kind == "dwell" else (2,), 3) for s in steps])
    median = [float(np.median(std[kinds == triad])) for triad in (0, 1)]
    accel, gyro = (max(one / usual, 1.0) for one, usual in zip(median, NAVIGATION_GRADE_STD, strict=True))
    return accel, gyro


def _base(
    sigmas: DesignSigmas, design: CampaignDesign, steps: list[DesignStep]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the base model's whitened rows (r, p), what is known (p, p), and 1 sigma (r,) of every row."""
    info, places, moves = sigmas.steps, design.placings, design.moves
    n, noise, hands, care = len(places), info.noise, info.hands, info.campaign.sigma
    shared = OWN * n + np.arange(SHARED)
    known = np.zeros((OWN * n + SHARED,) * 2)
    known[np.ix_(shared, shared)] = sigmas.known[moves]
    parts = list[tuple[FloatArray, FloatArray, FloatArray]]()  # rows, their columns, variance
    for i, at in enumerate(places):
        own = np.arange(OWN * i, OWN * (i + 1))
        closure = NO_CLOSURE_STD_RAD if at.turn is None else care.closure
        known[own, own] = 1 / np.square([care.heading, care.seat, care.seat, closure])
        if at.turn is not None:
            variance = [noise.turn_variance(hands.turn)]
            rows = [info.rows.turn[at.turn].copy()]
        else:
            seconds = np.array([at.seconds])
            variance = [noise.accel_variance(seconds)[0], noise.gyro_variance(seconds)[0]]
            rows = [info.rows.accel[at.position - 1].copy(), info.rows.gyro[at.position - 1].copy()]
        for each, one in zip(rows, variance, strict=True):
            each[:, SEAT] *= moves
            parts.append((each, np.r_[own, shared], one))
    for i, at in enumerate(places[1:]):
        if moves and at.is_carried:
            rows_of_move = info.rows.move[places[i].position - 1, at.position - 1]
            columns = np.r_[OWN * i : OWN * (i + 2), shared]
            parts.append((rows_of_move, columns, np.full(3, noise.move_variance(hands.move))))
    std = np.sqrt(np.concatenate([variance for _, _, variance in parts]))
    A = np.zeros((len(std), len(known)))
    for i, (rows_of_part, columns, _) in enumerate(parts):
        A[3 * i : 3 * i + 3, columns] = rows_of_part
    return A / std[:, None], known, std
