"""What follows from the models that were kept: probabilities of names, groups and nameless mass, coefficients."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.evidence.candidates import Candidate
from procedures.inference import priors
from procedures.inference.board import Board, Hypothesis
from procedures.inference.marginal import Held, Member, Ranked, log_sum
from procedures.inference.search import Model, Search
from procedures.twelve_positions.accelerometer_fit import TriadFit


@dataclass(frozen=True, slots=True, eq=False)
class Coefficients:
    """Coefficients of one name averaged over its options: ``value`` (k,), ``covariance`` (k, k), in its unit.

    ``acts`` (k,) is the probability that each of them acts. One that hardly does is zero in most of the options:
    its value and its sigma are of these, and say nothing of what it would be.
    ``nonlinear`` (value, 1 sigma of its logarithm) by the name of a time constant and the like.
    """

    candidate: Candidate
    names: tuple[str, ...]
    value: FloatArray
    covariance: FloatArray
    nonlinear: dict[str, tuple[float, float]]
    acts: FloatArray

    @property
    def std(self) -> FloatArray:
        """1 sigma (k,)."""
        found: FloatArray = np.sqrt(np.diag(self.covariance))
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """Something that acts: its likeliest name and that name's ``probability``, and the names it may have.

    ``shares`` holds by name the probability that this cause is it, of named and nameless hypotheses; ``joint`` is
    the probability that one of them acts, ``evidence`` ln of the odds that one does against none. ``nameless`` is
    the share without a name, ``form`` the likeliest of these and ``note`` where and how it acts. ``coefficients``
    are those of the likeliest name, None where there is none. ``places`` are where the likeliest name may act, as
    a position or a channel, with the share of each, the likeliest first.
    """

    hypothesis: Hypothesis
    probability: float
    joint: float
    shares: dict[str, float]
    nameless: float
    coefficients: Coefficients | None
    form: str
    note: str
    evidence: float
    places: tuple[tuple[Mapping[str, object], float], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """All that the models say: causes by probability, every name's probability, the best model."""

    causes: tuple[Cause, ...]
    probabilities: dict[str, float]
    best: Model

    @property
    def nameless(self) -> float:
        """Probability that at least one of the causes has no name."""
        return 1 - float(np.prod([1 - each.nameless for each in self.causes]))


def posterior(search: Search) -> Posterior:
    """Return what the models of a search say together."""
    search.widen()
    board, models = search.board, list(search.models.values())
    weights = np.exp(np.array([m.log_odds for m in models]) - log_sum(np.array([m.log_odds for m in models])))
    held = np.zeros((len(models), len(board.hypotheses)), dtype=bool)
    for i, model in enumerate(models):
        held[i, list(model.names)] = True
    present = weights @ held
    probabilities = _at_most_one(weights @ (held & ~_bent_further(board, models, held)))
    alone = np.divide(probabilities, present, out=np.ones_like(present), where=present > 0)
    best, causes = search.best, list[Cause]()
    for hypothesis, own in _acting(board, best.members):
        rest = [each for each in best.members if each not in own]
        ranking = search.ranked_with(rest)
        total = ranking.total.copy()
        if len(own) > 1:  # together they are likelier than one of them
            total[hypothesis] = log_sum(
                np.array([total[hypothesis], best.log_odds - search.polished(rest).log_odds])
            )
        shares = _at_most_one(np.exp(total - log_sum(np.append(total, 0.0))))
        order = [int(j) for j in np.argsort(-shares) if shares[j] >= priors.NEGLIGIBLE]
        first = order[0] if order else int(np.argmax(shares))
        named = [j for j in order if board.hypotheses[j].is_named]
        is_alone = float(np.sum(shares[named])) < 1 - priors.LIKELY
        without = [
            _share_without_name(h, a, is_alone=is_alone) for a, h in zip(alone, board.hypotheses, strict=True)
        ]
        nameless = float(_at_most_one(shares @ np.array(without)))
        top = named[0] if named else first
        member = ranking.member(board, top)
        found = averaged(board, rest, top, member) if board.hypotheses[top].is_named else None
        if top == hypothesis and len(own) > 1:
            found = _together(board, best.members, own)
        forms = [j for j in order if not board.hypotheses[j].is_named] or [first]
        form, of_group = forms[0], _at_most_one(weights @ held[:, order or [first]].any(axis=1))
        causes.append(Cause(
            board.hypotheses[top], float(min(probabilities[top], shares[top])), float(of_group),
            {board.hypotheses[j].name: float(shares[j]) for j in order}, nameless, found,
            board.hypotheses[form].curve, board.options[ranking.member(board, form).option].note,
            float(log_sum(total)),
            tuple(_places(board, ranking, top)),
        ))  # fmt: skip
    every = {h.name: float(p) for h, p in zip(board.hypotheses, probabilities, strict=True)}
    return Posterior(tuple(sorted(causes, key=lambda each: -each.evidence)), every, best)


def _share_without_name(hypothesis: Hypothesis, alone: float, *, is_alone: bool) -> float:
    """Return how far a hypothesis is without a name where it acts; ``alone`` is how far a name is what acts.

    A temperature that was not recorded is a cause that is known: it has no name only where it ``is_alone``.
    """
    if hypothesis.is_named:
        return 1 - alone
    return float(is_alone or hypothesis.kind != "unrecorded")


def _at_most_one(sums: FloatArray) -> FloatArray:
    """Return probabilities (m,) that rounding in their sums may have lifted above one."""
    found: FloatArray = np.minimum(sums, 1.0)
    return found


def _bent_further(board: Board, models: Sequence[Model], held: BoolArray) -> BoolArray:
    """Return in which models (m, h) a curve of the catalogue is not enough to follow what drives it.

    Next to it stands a function of the same driver, or it acts more often than twice, as by many jumps. Together
    they are another curve: the name is not what acts, as its law does not hold alone.
    """
    nameless = np.array([not each.is_named for each in board.hypotheses])
    drivers = np.array([each.driver for each in board.hypotheses])
    found = np.zeros_like(held)
    for i in np.flatnonzero(~nameless & (drivers != "")).tolist():
        found[:, i] = held[:, nameless & (drivers == drivers[i])].any(axis=1)
        found[:, i] |= [model.names.count(i) > priors.MOST_PLACES for model in models]
    return found


def _acting(board: Board, members: Sequence[Member]) -> Iterator[tuple[int, list[Member]]]:
    """Yield hypotheses with the members that are one cause: all coefficients of an effect at one place."""
    causes = dict[tuple[object, ...], list[Member]]()
    for each in members:
        option = board.options[each.option]
        columns = option.candidate and option.candidate.columns
        place = (str(columns.where), columns.shape, str(columns.nonlinear)) if columns else (each,)
        causes.setdefault((option.hypothesis, *place), []).append(each)
    for own in causes.values():
        yield board.options[own[0].option].hypothesis, own


def _places(board: Board, ranking: Ranked, hypothesis: int) -> Iterator[tuple[Mapping[str, object], float]]:
    """Yield where a name may act and the share of it, the likeliest first; what is negligible is left out."""
    own = board.options_of[hypothesis]
    shares = np.exp(ranking.gains[own] - log_sum(ranking.gains[own]))
    places, total = dict[str, Mapping[str, object]](), dict[str, float]()
    for number, share in zip(own.tolist(), shares.tolist(), strict=True):
        if (way := board.options[number].candidate) is not None:
            key = str(way.columns.where)
            places[key], total[key] = way.columns.where, total.get(key, 0.0) + share
    for key in sorted(total, key=lambda each: -total[each]):
        if total[key] >= priors.NEGLIGIBLE:
            yield places[key], total[key]


def _together(board: Board, members: Sequence[Member], own: Sequence[Member]) -> Coefficients | None:
    """Return the coefficients that several members make together, at their amplitudes, with all others."""
    ways = [way for each in own if (way := board.options[each.option].candidate) is not None]
    candidate = max(
        ways, key=lambda each: len(each.columns.coefficients)
    )  # of polynomials that of the highest order
    held, columns = Held.of(board, members), candidate.columns
    k = len(columns.coefficients) - len(columns.nonlinear)
    number = {name: i for i, name in enumerate(columns.coefficients)}
    T, first = np.zeros((k, len(held.c))), 0
    for each in members:
        option = board.options[each.option]
        end = first + len(option.columns)
        if each in own and option.mask is not None and option.scale is not None and option.candidate is not None:
            names = [option.candidate.columns.coefficients[i] for i in option.mask]
            at = [
                number.get(name, number.get(f"{name}.1", 0)) for name in names
            ]  # x of a line is x.1 of a parabola
            T[at, range(first, end)] = option.scale * each.amplitude
        first = end
    value, covariance = T @ held.c, T @ held.inverse @ T.T
    if candidate.effect.shown is not None:
        value, std = candidate.effect.shown(value, np.sqrt(np.diag(covariance)))
        covariance = np.diag(std**2)
    constants = {name: (size, 0.0) for name, size in columns.nonlinear.items()}
    acts = np.any(T, axis=1).astype(float)
    return Coefficients(candidate, columns.coefficients[:k], value, covariance, constants, acts)


def averaged(board: Board, rest: Sequence[Member], hypothesis: int, member: Member) -> Coefficients:
    """Return a name's coefficients, averaged over its amplitudes, masks and time constants, with members."""
    held, best = Held.of(board, rest), board.options[member.option]
    candidate = best.candidate
    assert candidate is not None
    columns = candidate.columns
    k = len(columns.coefficients) - len(columns.nonlinear)
    amplitudes, weights = list[float](), list[float]()
    means, spreads, constants = list[FloatArray](), list[FloatArray](), list[FloatArray]()
    held_in = list[FloatArray]()
    for number in board.options_of[hypothesis]:
        option = board.options[int(number)]
        way = option.candidate
        assert way is not None
        assert option.mask is not None
        assert option.scale is not None
        if (
            way.columns.where != columns.where
            or way.columns.shape != columns.shape
            or len(way.columns.coefficients) != len(columns.coefficients)
        ):
            continue
        W = board.W[:, option.columns]
        beyond, _ = held.project_out(W)
        G, g = beyond.T @ beyond, beyond[: len(W)].T @ board.y
        size, V = np.linalg.eigh(G)
        size, along = np.maximum(size, 0.0), V.T @ g
        grid, log_weights = board.hypotheses[hypothesis].amplitudes, board.hypotheses[hypothesis].log_weights
        if candidate.effect.is_scatter:  # the amplitude itself is what is reported
            coarse, grid = grid, np.geomspace(grid[0], grid[-1], priors.FINER_AMPLITUDES * len(grid))
            log_weights = np.interp(np.log(grid), np.log(coarse), log_weights)
        for s, log_weight in zip(grid.tolist(), log_weights.tolist(), strict=True):
            spread = 1 + s**2 * size
            gain = 0.5 * float(np.sum(s**2 * along**2 / spread - np.log(spread)))
            weights.append(option.log_share + log_weight + gain)
            mean, C = np.zeros(k), np.zeros((k, k))
            mean[option.mask] = option.scale * (V @ (s**2 * along / spread))
            C[np.ix_(option.mask, option.mask)] = (
                option.scale[:, None] * (V * (s**2 / spread)) @ V.T * option.scale
            )
            means.append(mean)
            held_in.append(np.isin(np.arange(k), option.mask).astype(float))
            amplitudes.append(s)
            spreads.append(C)
            constants.append(np.log(np.array(list(way.columns.nonlinear.values()))))
    p = np.exp(np.array(weights) - log_sum(np.array(weights)))
    if candidate.effect.is_scatter:
        logs = np.log(amplitudes)
        times, own = float(np.exp(p @ logs)), float(candidate.term.plausible[0])
        std = times * own * float(np.sqrt(p @ (logs - p @ logs) ** 2))
        return Coefficients(candidate, ("value",), np.array([times * own]), np.array([[std**2]]), {}, np.ones(1))
    every = np.array(means)
    value, acts = p @ every, p @ np.array(held_in)
    off = every - value
    covariance = np.einsum("i,ijk->jk", p, np.array(spreads)) + (off * p[:, None]).T @ off
    if candidate.effect.shown is not None:
        shown, u = candidate.effect.shown(value, np.sqrt(np.diag(covariance)))
        return Coefficients(candidate, columns.coefficients[:k], shown, np.diag(u**2), {}, acts)
    nonlinear = dict[str, tuple[float, float]]()
    for i, name in enumerate(columns.nonlinear):
        logs = np.array([each[i] for each in constants])
        middle = float(p @ logs)
        nonlinear[name] = float(np.exp(middle)), float(np.sqrt(p @ (logs - middle) ** 2))
    return Coefficients(candidate, columns.coefficients[:k], value, covariance, nonlinear, acts)


def averaged_parameters(search: Search, found: Posterior) -> tuple[FloatArray, FloatArray]:
    """Return by how much the model's parameters (p,) move on average over what the causes may be.

    Second is the covariance (p, p) that this adds to that of noise. What may act unseen in addition to the causes,
    as likely as before the data, is no part of the average; what the data make ten times as likely is.

    With A the model's own columns and S those of members, on all rows, and c the members' coefficients in units
    of their prior, the parameters move by ``dx = A^+ (S c - y)``; to the covariance of noise is added
    A^+ S cov(c) S' A^+', and that of dx from model to model.
    """
    board, shown = search.board, {name for each in found.causes for name in each.shares}
    shown |= {name for name, p in found.probabilities.items() if p >= 1 - priors.LIKELY}
    models = [m for m in search.window if {board.hypotheses[i].name for i in m.names} <= shown] or [search.best]
    models += search.elsewhere()
    evidence = board.evidence
    Q, R = np.linalg.qr(evidence.A / evidence.sigma[:, None])
    y = evidence.residual / evidence.sigma
    log_odds = np.array([each.log_odds for each in models])
    p = np.exp(log_odds - log_sum(log_odds))
    changes, added = np.zeros((len(models), R.shape[1])), np.zeros((R.shape[1], R.shape[1]))
    for i, model in enumerate(models):
        held = Held.of(board, model.members)
        parts = [board.H[:, board.options[each.option].columns] * each.amplitude for each in model.members]
        S = np.hstack([np.zeros((len(y), 0)), *parts])
        taken = np.linalg.solve(R, Q.T @ S)
        changes[i] = taken @ held.c - np.linalg.solve(R, Q.T @ y)
        added += p[i] * taken @ held.inverse @ taken.T
    mean: FloatArray = p @ changes
    return mean, added + ((changes - mean) * p[:, None]).T @ (changes - mean)


def averaged_fits(
    fits: CampaignFits, average: tuple[FloatArray, FloatArray], columns_of: tuple[IntArray, IntArray]
) -> CampaignFits:
    """Return fits with parameters and covariance averaged over the models of what the causes may be.

    Parameters
    ----------
    fits : where the board was linearised, with the covariance of noise alone
    average : by how much the parameters (p,) move and the covariance (p, p) added, of `averaged_parameters`
    columns_of : (k,) of each triad, which of them are its own
    """
    mean, added = average

    def moved(joint: TriadFit, columns: IntArray) -> TriadFit:
        one = joint.fit
        covariance = one.covariance + added[np.ix_(columns, columns)]
        return replace(joint, fit=replace(one, x=one.x + mean[columns], covariance=covariance))

    accel, gyro = fits.accelerometer, fits.gyroscope
    first, second = columns_of
    return replace(
        fits, accelerometer=accel and moved(accel, first),
        gyroscope=gyro and replace(gyro, joint=moved(gyro.joint, second)),
    )  # fmt: skip
