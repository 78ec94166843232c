"""A hypothesis is columns and a prior: what would show in the rows, and how large it may be.

Named effects, scatters, random walks, wider noise of a class of rows and smooth functions without a name are all
of this one kind. A hypothesis has options, each with its share of the prior: where an effect acted, at which time
constant, in all sensors or in one.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from procedures.arrays import FloatArray, IntArray
from procedures.effects.excitation import Columns
from procedures.evidence.candidates import Candidate
from procedures.evidence.linear_model import Term, variance_classes
from procedures.evidence.rate_points import ROWS_BY_HAND, same_rates
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import AXES, TRIADS
from procedures.inference import priors
from procedures.inference.board import Board, Hypothesis, Option
from procedures.inference.marginal import log_sum
from procedures.inference.nonlinear_constants import between
from procedures.inference.smooth_functions import Function, driver_in, functions, unrecorded, walk
from procedures.statistics.least_squares import left_singular

OF_REPEATS = "a function of the rate that all repeats share, gyroscope"
OF_ROWS = {
    "mean": "positions", "slope": "drifts within positions", "curvature": "drifts within positions",
    "turn": "rotations", "move": "transfers", "norm": "rests", "soak": "soaks", "level": "soaks",
    "rate": "rate points", "prior": "stated values",
}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Columns H (n, k) of a hypothesis, in sigmas of the rows, each times 1 sigma of its coefficient.

    That is ``scale`` (k,). ``masks`` are which of them act together, with ln of the share; where there is no
    ``candidate``, only all do. ``rows`` (k,) are those that the columns are, each one alone.
    """

    hypothesis: int
    H: FloatArray
    masks: Sequence[tuple[float, IntArray]] = ()
    candidate: Candidate | None = None
    scale: FloatArray | None = None
    note: str = ""
    rows: IntArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Library:
    """Every hypothesis and the ways in which it may hold, as columns of the rows."""

    hypotheses: tuple[Hypothesis, ...]
    ways: tuple[Way, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The hypotheses' names, in their order."""
        return tuple(each.name for each in self.hypotheses)

    def with_adopted(self, evidence: Evidence, adopted: Sequence[Candidate]) -> "Library":
        """Return the library with the columns of some candidates where the model stands with them in it."""
        ways, number = list(self.ways), {each.name: i for i, each in enumerate(self.hypotheses)}
        for one in adopted:
            exact = _way(evidence, number[one.effect.name], one, 0.0)
            same = [i for i, way in enumerate(ways) if way.candidate is not None and _is_same(way.candidate, one)]
            if one.columns.nonlinear and same:
                shares = [(share + one.log_volume, mask) for share, mask in ways[same[0]].masks]
                ways.append(replace(exact, masks=shares))
            for i in [] if one.columns.nonlinear else same:
                ways[i] = replace(exact, masks=ways[i].masks)
        return Library(self.hypotheses, tuple(ways))

    def with_functions(
        self, nameless: Mapping[str, Function], odds: float = priors.ODDS_NAMELESS, kind: str = "nameless"
    ) -> "Library":
        """Return the library with functions without a name: their shares, whitened columns (n, k) and notes."""
        hypotheses, ways = list(self.hypotheses), list(self.ways)
        for name, (options, driver) in nameless.items():
            total = sum(share for share, _, _ in options)
            ways += [
                Way(len(hypotheses), H, [(float(np.log(share / total)), np.arange(H.shape[1]))], note=note)
                for share, H, note in options
            ]
            if options:
                hypotheses.append(_without_name(name, kind, odds, priors.OF_NAMELESS, driver))
        return Library(tuple(hypotheses), tuple(ways))

    def with_terms(self, evidence: Evidence, terms: Iterable[tuple[str, Candidate, float]]) -> "Library":
        """Return the library with terms by name, each one way in which it acts, with ln of its prior odds."""
        hypotheses, ways = list(self.hypotheses), list(self.ways)
        for name, candidate, log_odds in terms:
            ways.append(_way(evidence, len(hypotheses), candidate, 0.0))
            hypotheses.append(Hypothesis(name, "term", log_odds, priors.OF_NAMELESS, candidate.effect))
        return Library(tuple(hypotheses), tuple(ways))

    def with_noise(self, classes: Iterable[tuple[str, FloatArray]]) -> "Library":
        """Return the library with classes of rows that may be noisier than stated, columns (n, k) [1].

        A column is a row, or the rows that share what they scatter by.
        """
        hypotheses, ways = list(self.hypotheses), list(self.ways)
        for name, E in classes:
            rows = np.argmax(E, axis=0) if np.all(np.count_nonzero(E, axis=0) == 1) else None
            ways.append(Way(len(hypotheses), E, [(0.0, np.arange(E.shape[1]))], rows=rows))
            hypotheses.append(_without_name(name, "noise", priors.ODDS_NAMED, priors.OF_SPREAD))
        return Library(tuple(hypotheses), tuple(ways))

    def on(self, evidence: Evidence) -> Board:
        """Return every hypothesis on an evidence of the same rows."""
        white = evidence.A / evidence.sigma[:, None]
        Q, _ = np.linalg.qr(white, mode="complete")
        basis = Q[:, white.shape[1] :]
        sizes = np.cumsum([0, *(way.H.shape[1] for way in self.ways)])
        every = basis.T @ np.hstack([np.zeros((len(white), 0)), *(way.H for way in self.ways)])
        rows, parts, options, width = list[FloatArray](), list[FloatArray](), list[Option](), 0
        for way, first, end in zip(self.ways, sizes, sizes[1:], strict=False):
            H, W, masks = way.H, every[:, first:end], way.masks
            if way.candidate is None and way.rows is None:
                V = principal(W)
                H, W, masks = H @ V, W @ V, [(way.masks[0][0], np.arange(V.shape[1]))]
            rows.append(H)
            parts.append(W)
            for share, mask in masks:
                scale = None if way.scale is None else way.scale[mask]
                taken = None if way.rows is None else Q[way.rows, : white.shape[1]]
                own = Option(way.hypothesis, share, width + mask, way.candidate, mask, scale, way.note, taken)
                options.append(own)
            width += W.shape[1]
        W = np.hstack([*parts, np.zeros((basis.shape[1], 1))])
        H = np.hstack([*rows, np.zeros((len(white), 1))])
        y = basis.T @ (evidence.residual / evidence.sigma)
        return Board(evidence, H, y, W, self.hypotheses, _plainest(W, y, options, self.hypotheses), basis)


def _plainest(
    W: FloatArray, y: FloatArray, options: Sequence[Option], hypotheses: Sequence[Hypothesis]
) -> tuple[Option, ...]:
    """Return the options without those that do what a plainer effect does, as far as the data y (m,) show.

    A lag of a second, a settling of a week and a function of two temperatures do what a coefficient of temperature
    or a drift does: that is the name they then have. Of a name that goes by something else, or by a parabola, it
    is chance that both do the same here: they compete.
    """
    spans = {
        id(each.candidate): each
        for each in sorted(options, key=lambda o: len(o.columns))
        if each.is_plain and hypotheses[each.hypothesis].kind != "term"
    }
    owner = np.repeat(np.arange(len(options)), [len(each.columns) for each in options])
    every = np.concatenate([np.zeros(0, dtype=np.int64), *(each.columns for each in options)])
    sums = csr_array((np.ones(len(every)), (owner, every)), shape=(len(options), W.shape[1]))
    sizes, drivers = np.array([_coefficients(each) for each in options]), np.array([_driver(o) for o in options])
    whole, most = np.maximum(sums @ np.sum(W**2, axis=0), 1e-300), np.zeros(len(options))
    explained = np.zeros(len(options))  # squares of y, by the plain effect that does most of what an option does
    for plain in spans.values():
        columns = plain.columns
        U, size = left_singular(W[:, columns])
        Q = U[:, size > np.finfo(float).eps * len(W) * np.max(size, initial=0.0)]
        share = sums @ np.sum((Q.T @ W) ** 2, axis=0) / whole
        is_plainer = (len(columns) <= sizes) & ((drivers == _driver(plain)) | (drivers == ""))
        does_most = (share > most) & is_plainer
        explained = np.where(does_most, np.sum((Q.T @ y) ** 2), explained)
        most = np.where(does_most, share, most)

    def is_kept(option: Option, share: float, by_plain: float) -> bool:
        is_free = option.is_bent or hypotheses[option.hypothesis].kind == "nameless"
        if option.is_plain or not is_free or share < 1 - priors.UNRESOLVED:
            return True
        return bool(_explained(W[:, option.columns], y) - by_plain > priors.WINDOW)

    return tuple(
        each for each, share, plain in zip(options, most.tolist(), explained.tolist(), strict=True)
        if is_kept(each, share, plain)
    )  # fmt: skip


def _coefficients(option: Option) -> float:
    """Return how many linear coefficients an effect has in all sensors, inf of a function without a name."""
    if option.candidate is None:
        return np.inf
    columns = option.candidate.columns
    return len(columns.coefficients) - len(columns.nonlinear)


def _driver(option: Option) -> str:
    return "" if option.candidate is None else option.candidate.effect.driver


def _explained(W: FloatArray, y: FloatArray) -> float:
    """Return the squares of y (m,) that columns W (m, k) explain."""
    found: FloatArray = W @ np.linalg.lstsq(W, y)[0]
    return float(found @ found)


def _is_same(one: Candidate, other: Candidate) -> bool:
    a, b = one.columns, other.columns
    return one.effect.name == other.effect.name and (a.where, a.shape, a.orders) == (b.where, b.shape, b.orders)


def library_of(evidence: Evidence, pool: Mapping[str, Sequence[Candidate]]) -> Library:
    """Return every hypothesis on an evidence; ``pool`` are by name the ways in which effects may act."""
    walks = {f"a random walk of the bias, {triad}": walk(evidence, triad) for triad in TRIADS}
    found = named(evidence, pool).with_functions(functions(evidence) | walks)
    # what is known to act and was not recorded is as likely as what has a name
    found = found.with_functions(unrecorded(evidence), priors.ODDS_NAMED, "unrecorded")
    return found.with_noise(_noise(evidence))


def named(evidence: Evidence, pool: Mapping[str, Sequence[Candidate]]) -> Library:
    """Return the hypotheses that have a name; ``pool`` are by name the ways in which effects may act."""
    hypotheses, ways = list[Hypothesis](), list[Way]()
    for name, candidates in pool.items():
        if candidates and candidates[0].effect.is_bench_parameter:
            tried = [
                each for each in (beyond_its_prior(evidence, each) for each in candidates) if each is not None
            ]
        else:
            tried = [each for each in candidates if each.is_tried]
        if tried:
            hypotheses.append(_named(name, tried))
            ways += _named_ways(evidence, len(hypotheses) - 1, tried)
    return Library(tuple(hypotheses), tuple(ways))


def _without_name(name: str, kind: str, odds: float, amplitudes: FloatArray, driver: str = "") -> Hypothesis:
    return Hypothesis(name, kind, float(np.log(odds)), amplitudes, driver=driver)


def _named(name: str, ways: Sequence[Candidate]) -> Hypothesis:
    effect = ways[0].effect
    amplitudes = priors.OF_SPREAD if effect.is_scatter and effect.kind != "instrument" else priors.OF_NAMED
    log_odds, has_places = float(np.log(priors.ODDS_NAMED)), any(way.columns.where for way in ways)
    again = log_odds if has_places else float(np.log(priors.ODDS_ANOTHER))
    is_bent = any(way.columns.nonlinear for way in ways)  # with two knees it would be any curve
    is_single = effect.is_scatter or len(ways[0].columns.coefficients) == 1 or is_bent
    is_curve = is_bent or has_places
    driver = driver_in(name.split(".")[0], effect.driver) if is_curve else ""
    return Hypothesis(name, effect.kind, log_odds, amplitudes, effect, None if is_single else again, driver)


def _named_ways(evidence: Evidence, number: int, candidates: Sequence[Candidate]) -> list[Way]:
    """Return the ways of a name; an order more of a polynomial is as likely as another coefficient."""
    finer = [*candidates, *between(candidates)]
    shares = np.log(priors.ODDS_ANOTHER) * np.array([max(each.columns.orders, default=1) - 1 for each in finer])
    shares -= log_sum(shares)
    return [_way(evidence, number, each, share) for each, share in zip(finer, shares.tolist(), strict=True)]


def _way(evidence: Evidence, number: int, candidate: Candidate, log_share: float) -> Way:
    """Return a candidate's columns times 1 sigma of its coefficients."""
    k = len(candidate.columns.coefficients) - len(candidate.columns.nonlinear)
    scale = candidate.term.plausible[:k]
    H = candidate.term.H[:, :k] * scale / evidence.sigma[:, None]
    shares = [(share + log_share, mask) for share, mask in masks(candidate)]
    return Way(number, H, shares, candidate, scale)


def beyond_its_prior(evidence: Evidence, parameter: Candidate) -> Candidate | None:
    """Return that a bench parameter varies more than its prior says: a scatter of its prior rows, as stated there.

    None of one that has no prior rows.
    """
    stated = evidence.is_range & np.any(evidence.A[:, parameter.taken] != 0, axis=1)
    rows = np.flatnonzero(stated & (np.count_nonzero(evidence.A, axis=1) == 1))
    if not len(rows):
        return None
    per_unit = np.max(np.abs(evidence.A[rows]), axis=1)
    one = float(np.median(evidence.sigma[rows] / per_unit))
    effect = replace(parameter.effect, is_scatter=True, plausible=one)
    H = np.eye(len(evidence.sigma))[:, rows] * (evidence.sigma[rows] / one)
    columns = Columns(tuple(str(i) for i in range(len(rows))))
    return Candidate(effect, columns, Term(H, np.full(len(rows), one)), np.zeros_like(parameter.taken))


def masks(way: Candidate) -> Iterator[tuple[float, IntArray]]:
    """Yield ln of a share, and the indices (k,) of coefficients that act.

    These are all, those of one sensor, those of each sensor's own axis (of a matrix), or one alone; what only goes
    with others acts with each of them.
    """
    names = way.columns.coefficients[: len(way.columns.coefficients) - len(way.columns.nonlinear)]
    with_each = [i for i, name in enumerate(names) if name in way.columns.side_effects]
    every = np.array([i for i in range(len(names)) if i not in with_each], dtype=np.int64)
    if way.effect.is_scatter or len(every) == 1:
        yield 0.0, np.arange(len(names))
        return
    sensors = sorted({names[i][0] for i in every})
    own = [np.array([i for i in every if names[i][0] == each]) for each in sensors]
    levels = [[every]]
    if 1 < len(own) < len(every):
        levels.append(own)
        along = np.array([i for i in every if names[i] == 2 * names[i][0]], dtype=np.int64)
        levels += [[along]] if len(along) > 1 else []
    levels.append([every[i : i + 1] for i in range(len(every))])
    for level in levels:
        for mask in level:
            yield -float(np.log(len(levels) * len(level))), np.append(mask, with_each).astype(np.int64)


def principal(W: FloatArray) -> FloatArray:
    """Return V (k, r): whitened columns W (m, k) times V have the same W W', but for what is negligible."""
    if not W.shape[1]:
        return np.zeros((0, 0))
    variances, V = np.linalg.eigh(W.T @ W)
    found: FloatArray = V[:, variances > priors.NEGLIGIBLE**2 * max(float(variances[-1]), 1e-300)]
    return found


def _noise(evidence: Evidence) -> Iterator[tuple[str, FloatArray]]:
    """Yield by name that a class of rows is noisier than its samples say: a column for each of its rows."""
    shared = variance_classes(evidence)
    for number in np.unique(shared[shared > 0]).tolist():
        rows = np.flatnonzero(shared == number)
        triad, kind = divmod(number - 1, len(KINDS))
        if len(rows) > len(AXES):
            yield (
                f"a scatter of {OF_ROWS[KINDS[kind]]} beyond noise, {TRIADS[triad]}",
                np.eye(len(shared))[:, rows],
            )


def of_repeats(evidence: Evidence) -> Iterator[tuple[str, FloatArray]]:
    """Yield, where rates are repeated, that their repeats share an error: columns (n, k) [1] by name.

    Pure error separates it from scatter: what repeats at a rate is a function of the rate, however narrow. It
    takes up any nonlinearity: it is to be held against a scatter, once what has a name is in the model.
    """
    rows = np.flatnonzero(evidence.rows("rate"))
    if len(rows):
        nodes = np.array([each.nodes.start for each in evidence.weights])  # of a table a row is a point
        set_alike = np.column_stack((evidence.axis[rows], same_rates(evidence.excitation.omega[nodes[rows]])))
        kinds, kind = np.unique(set_alike, axis=0, return_inverse=True)
        if len(kinds) <= min(ROWS_BY_HAND, len(rows)) / 2:
            E = np.zeros((len(evidence.residual), len(kinds)))
            E[rows, kind] = 1.0
            yield OF_REPEATS, E
