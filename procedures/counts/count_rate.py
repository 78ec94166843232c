"""From counts to a rate with an honest sigma.

Every node says that the cumulative output lay in ``[c, c + 1)``, and the output is a straight line plus the random
walk that white rate noise integrates to; `procedures.counts.count_propagation.propagate` combines the statements.
The noise is the one that makes the counts most likely, averaged over what they leave open. Only nodes that can
bind are used: in each of `NODE_WINDOWS` stretches the few that come closest to either end of their interval; and
where the noise leaves more than `MAX_NODES` in doubt every few of them. Why, and figures:
docs/explanation/count-rate.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.counts.count_kernels import theta_of_first_and_all
from procedures.counts.count_noise import Search, Tries, Weights, noise_posterior, white_count_noise
from procedures.counts.count_propagation import Nodes, output_under_sites, propagate, rate_within_counts
from procedures.errors import TooShort

NODE_WINDOWS, NODES_PER_WINDOW_END = 64, 3
MAX_NODES = 5200  # of a dwell, once those in doubt are in: 100 s at 50 Hz are not thinned
ADMIT_SIGMAS = 3.5  # sigmas from either end of its interval within which a node is admitted
MIN_POINT_EDGES = 2  # below which a dwell gives an interval, no point
# counts per span, and times what noise makes: 1 sigma from which lines are weighed themselves
WIDE, WALKS = 0.02, 2.0
TRIANGLE, RAMP = np.sqrt(24), np.sqrt(18)  # widths in 1 sigma
MIN_DWELL_SAMPLES = 8
MAX_SWEEPS, SWEEP_TOLERANCE = 60, 1e-3
# of all paths: fewer leave slow ones alone for longer, more fall out of a processor's own memory
NODES_AT_ONCE = 12000


@dataclass(frozen=True, slots=True, eq=False)
class RateEstimate:
    """Mean rate of a dwell's channel [output/s], 1 sigma; slope [/s] and curvature [/s2] of the rate, 1 sigma.

    ``noise`` is the white rate noise [output/sqrt(s)]. ``edges`` counts the different count boundaries crossed,
    in addition to the usual increment: noise crossing one to and fro is one edge. With fewer than two there is no
    point estimate: ``interval`` holds the rates that the counts allow, ``rate`` is their mean, by how likely they
    are.
    """

    rate: float
    std: float
    slope: float
    slope_std: float
    curvature: float
    curvature_std: float
    noise: float
    edges: int
    interval: tuple[float, float] | None = None


@dataclass(slots=True, eq=False)
class _Path:
    """One channel's cumulative count in one dwell, about the line of ``rate`` counts per sample.

    ``t`` (m,) node times in samples from the middle; ``low`` (m,) the least the output can have been there;
    ``keep`` (m,) the nodes in use, ``is_thinned`` if only every few of those in doubt; ``tau``, ``nu`` their sites
    after the last `take`; ``found`` each noise's sites and log evidence with these nodes, ``made`` their `arrays`
    by terms. ``step`` is the change of the count in addition to the usual increments.
    """

    t: FloatArray
    low: FloatArray
    segment: IntArray
    keep: BoolArray
    rate: float
    edges: int
    step: int
    is_thinned: bool = False
    tau: FloatArray = field(default_factory=lambda: np.zeros(0))
    nu: FloatArray = field(default_factory=lambda: np.zeros(0))
    found: dict[float, tuple[FloatArray, FloatArray, float]] = field(default_factory=dict)
    made: dict[int, tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = field(default_factory=dict)

    @property
    def span(self) -> float:
        return float(self.t[-1] - self.t[0])

    def arrays(self, terms: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return times, links, lows and the integrated Legendre polynomials of the nodes in use.

        theta is then the rate's mean, slope and curvature, each in counts per span.
        """
        if terms not in self.made:
            t = self.t[self.keep]
            linked = np.concatenate(([0.0], (np.diff(self.segment[self.keep]) == 0) * 1.0))
            x = 2 * t / self.span
            columns = (x / 2, (x**2 - 1) / 4, (x**3 - x) / 4)
            basis = np.ascontiguousarray(np.stack(columns[:terms], axis=1))
            self.made[terms] = t, linked, self.low[self.keep], basis
        return self.made[terms]

    def nodes(self) -> Nodes:
        """Return the nodes in use, of the mean rate alone."""
        t, linked, low, basis = self.arrays(1)
        return Nodes(t, linked, low, basis[:, 0])

    def take(self, noise: float) -> float:
        """Take the sites found at a noise; return the log evidence."""
        self.tau, self.nu, evidence = self.found[noise]
        return evidence

    def terms(self, noise: float) -> tuple[FloatArray, FloatArray]:
        """Mean rate of the line, slope and curvature of the cubic, and their variances, in counts per span."""
        t, linked, _, basis = self.arrays(3)
        line, bent = theta_of_first_and_all(t, linked, self.tau, self.nu, basis, noise)
        theta = np.array([line[0][0], bent[0][1], bent[0][2]])
        return theta, np.array([line[1][0, 0], bent[1][1, 1], bent[1][2, 2]])

    def of_lines(self, mean: float, std: float, noise: float) -> tuple[float, float]:
        """Return mean and 1 sigma of the rate [counts per span]: of the lines that fit, if theirs is larger."""
        t, linked, low, _ = self.arrays(1)
        found = rate_within_counts(t, low, linked, mean / self.span, std / self.span)
        if found is None or found[1] * self.span < std:
            return mean, std
        return found[0] * self.span, float(np.hypot(found[1] * self.span, noise * np.sqrt(self.span)))

    def allowed(self, noise: float) -> tuple[float, float]:
        """Return the least and the largest rate next to ``rate`` that the counts allow, counts per sample.

        Between any two nodes the output moved by the count's change, give or take one and three sigma of the
        random walk: a bound that no approximation enters. Ends and edges bound most.
        """
        turn = np.flatnonzero(np.abs(np.diff(self.low, n=2)) > 0.5) + 1
        ends = np.flatnonzero(np.diff(self.segment, prepend=-1, append=self.segment[-1] + 1))
        at = np.unique(np.clip(np.concatenate((turn, turn + 1, ends, ends - 1)), 0, len(self.t) - 1))
        i, j = np.triu_indices(len(at), 1)
        same = self.segment[at[i]] == self.segment[at[j]]
        i, j = at[i][same], at[j][same]
        dt, change = self.t[j] - self.t[i], self.low[j] - self.low[i]
        slack = 1 + 3 * noise * np.sqrt(dt)
        return float(np.max((change - slack) / dt)), float(np.min((change + slack) / dt))

    def admit(self, noise: float) -> bool:
        """Take in the nodes that the sites found so far leave in doubt; say whether there were any."""
        if self.is_thinned or self.keep.all():
            return False
        nodes = self.nodes()
        t, (mean, variance) = nodes.t, output_under_sites(nodes, noise, self.tau, self.nu)
        before = np.clip(np.searchsorted(t, self.t, side="right") - 1, 0, len(t) - 2)
        share = (self.t - t[before]) / (t[before + 1] - t[before])
        at = mean[before] + share * (mean[before + 1] - mean[before])
        bridge = noise**2 * share * (1 - share) * (t[before + 1] - t[before])
        margin = ADMIT_SIGMAS * np.sqrt(np.maximum(variance[before], variance[before + 1]) + np.maximum(bridge, 0))
        doubtful = (at - self.low < margin) | (self.low + 1 - at < margin)
        fresh = bool(np.any(doubtful & ~self.keep))
        if fresh:
            self.keep |= doubtful
            self.thin()
            self.found.clear()
            self.made.clear()
        return fresh

    def thin(self) -> None:
        """Keep every few of more nodes than `MAX_NODES`, by their number alone, and each segment's ends."""
        among = np.flatnonzero(self.keep)
        every = -(-len(among) // MAX_NODES)
        if every > 1:
            # nodes chosen by what they say would make the noise look larger
            self.keep = _segment_ends(self.segment)
            self.keep[among[every // 2 :: every]] = True
            self.is_thinned = True


def estimate_counts(
    dwells: Sequence[IntArray], period: float, starts: Sequence[IntArray] | None = None,
    times: Sequence[FloatArray] | None = None,
) -> list[RateEstimate]:  # fmt: skip
    """Estimate the rate of one channel in each of several dwells.

    Parameters
    ----------
    dwells, starts, times : increments (n,), indices (s,), s (n,) of each dwell, as `estimate_channels` takes them
    """
    return estimate_channels([dwells], period, starts, times)[0]


def estimate_channels(
    channels: Sequence[Sequence[IntArray]], period: float, starts: Sequence[IntArray] | None = None,
    times: Sequence[FloatArray] | None = None,
) -> list[list[RateEstimate]]:  # fmt: skip
    """Estimate the rates of several channels in the same dwells, which share each channel's white noise.

    The interval likelihood is this project's own; expectation propagation is Minka, UAI 2001.

    Parameters
    ----------
    channels : increments (n,) of each dwell, counts per sample, by channel
    period : sample period [s]
    starts : index (s,) of the first sample of every gap-free segment of each dwell; default: no gap
    times : end (n,) of each sample's interval [s] of each dwell; default: evenly spaced

    Raises
    ------
    TooShort
        If a dwell has fewer than `MIN_DWELL_SAMPLES` samples.
    """
    for dwell in (each for dwells in channels for each in dwells):
        if len(dwell) < MIN_DWELL_SAMPLES:
            raise TooShort("a dwell", len(dwell), MIN_DWELL_SAMPLES)
    starts = starts or [np.zeros(1, dtype=np.int64)] * len(channels[0])
    samples = [
        np.arange(1.0, len(dwell) + 1) if times is None else times[i] / period
        for i, dwell in enumerate(channels[0])
    ]
    laid = [[_path(*each) for each in zip(dwells, samples, starts, strict=True)] for dwells in channels]
    white = [white_count_noise(dwells) for dwells in channels]
    searches = [noise_posterior(paths) for paths, noise in zip(laid, white, strict=True) if not noise > 0]
    posteriors = iter(_searched(searches))
    found = list[list[RateEstimate]]()
    for paths, noise in zip(laid, white, strict=True):
        if noise > 0:
            found.append([_with_white_noise(path, noise, period) for path in paths])
            continue
        weights = next(posteriors)
        _fit([(path, each) for each, _ in weights for path in paths])
        found.append([_averaged_over_noise(path, weights, period, refit=True) for path in paths])
    return found


def estimate_dithered(
    increments: FloatArray, t: FloatArray, starts: IntArray, period: float, noise: float
) -> RateEstimate:
    """Return the rate of increments whose rounding is white, such as those of counts less a line.

    Parameters
    ----------
    increments : increments (n,) of a dwell, counts per sample, whole or not
    t : end (n,) of each sample's interval [s]
    starts : index (s,) of the first sample of every gap-free segment
    period : sample period [s]
    noise : white noise [count/sqrt(sample)]
    """
    return _with_white_noise(_path(increments, t / period, starts), noise, period)


def _with_white_noise(path: _Path, noise: float, period: float) -> RateEstimate:
    path.keep[:] = True
    path.tau, path.nu = np.full(len(path.t), 12.0), 12.0 * (path.low + 0.5)
    return _averaged_over_noise(path, [(noise, 1.0)], period, refit=False)


def _path(increments: IntArray | FloatArray, t: FloatArray, starts: IntArray) -> _Path:
    """Lay the nodes: one before each segment's first sample and one after every sample."""
    at = np.zeros(len(increments) + len(starts))
    count = np.zeros_like(at)
    first = np.zeros(len(at), dtype=bool)
    for k, (begin, end) in enumerate(zip(starts, [*starts[1:], len(increments)], strict=True)):
        here = slice(begin + k, end + k + 1)
        at[here] = np.concatenate(([t[begin] - 1.0], t[begin:end]))
        count[here] = np.concatenate(([0], np.cumsum(increments[begin:end])))
        first[begin + k] = True
    segment = np.cumsum(first) - 1
    at -= (at[0] + at[-1]) / 2
    rate = _common_slope(at, count, segment)
    low = count - rate * at
    low -= (np.bincount(segment, low) / np.bincount(segment))[segment] + 0.5
    running = np.concatenate(([0], np.cumsum(increments - np.round(np.median(increments)))))
    return _Path(at, low, segment, _binding(low, segment), rate, int(np.ptp(running)), int(running[-1]))


def _common_slope(at: FloatArray, count: FloatArray, segment: IntArray) -> float:
    """Least-squares slope shared by segments that each have their own level."""
    size = np.bincount(segment)
    x = at - (np.bincount(segment, at) / size)[segment]
    return float(x @ count / (x @ x))


def _binding(low: FloatArray, segment: IntArray) -> BoolArray:
    """Mark the nodes nearest to either end of their interval in every window, and each segment's ends."""
    n = len(low)
    width = max(n // NODE_WINDOWS, 1)
    keep = np.ones(n, dtype=bool)
    if width <= 2 * NODES_PER_WINDOW_END:
        return keep
    rows = n // width
    order = np.argsort(low[: rows * width].reshape(rows, width), axis=1) + width * np.arange(rows)[:, None]
    keep[order[:, NODES_PER_WINDOW_END:-NODES_PER_WINDOW_END].ravel()] = False
    return keep | _segment_ends(segment)


def _segment_ends(segment: IntArray) -> BoolArray:
    """Mark the first and the last node of every segment."""
    changes = np.diff(segment, prepend=segment[0] - 1, append=segment[-1] + 1) != 0
    ends: BoolArray = changes[:-1] | changes[1:]
    return ends


def _searched(searches: Sequence[Search[_Path, Weights]]) -> list[Weights]:
    """Run searches to their end; what those that go on want tried is tried together."""
    found = dict[int, Weights]()
    while len(found) < len(searches):
        asked: Tries[_Path] = []
        for i, search in enumerate(searches):
            if i not in found:
                try:
                    asked += next(search)
                except StopIteration as end:
                    found[i] = end.value
        _fit(asked)
    return [found[i] for i in range(len(searches))]


def _fit(asked: Tries[_Path]) -> None:
    """Find the sites of paths at noises, once as long as a path's nodes stay."""
    new = [(path, noise) for path, noise in asked if noise not in path.found]
    while new:
        size = np.cumsum([np.count_nonzero(path.keep) for path, _ in new])
        here = max(int(np.searchsorted(size, NODES_AT_ONCE, side="right")), 1)
        nodes = [path.nodes() for path, _ in new[:here]]
        sites = propagate(nodes, [noise for _, noise in new[:here]], MAX_SWEEPS, SWEEP_TOLERANCE)
        for (path, noise), one in zip(new[:here], sites, strict=True):
            path.found[noise] = one.tau, one.nu, one.evidence
        new = new[here:]


def _averaged_over_noise(
    path: _Path, weights: Sequence[tuple[float, float]], period: float, refit: bool
) -> RateEstimate:
    """Average a dwell's rate, slope and curvature over what is open of the noise."""
    mean, square = np.zeros(3), np.zeros(3)
    for noise, weight in weights:
        if refit:
            path.take(noise)
        theta, variance = path.terms(noise)
        mean += weight * theta
        square += weight * (variance + theta**2)
    std = np.sqrt(np.maximum(square - mean**2, 0.0))
    noise_mean = float(np.sqrt(sum(w * s * s for s, w in weights)))
    walk = noise_mean * float(np.sqrt(path.span))  # where it makes the sigma no line fits, and none is needed
    if std[0] > WIDE + WALKS * walk and path.edges >= MIN_POINT_EDGES:
        mean[0], std[0] = path.of_lines(mean[0], std[0], noise_mean)
    half = path.span * period / 2
    value, sigma = (each / (path.span * period) * (1, 1 / half, 3 / half**2) for each in (mean, std))
    rate = path.rate / period + value[0]
    interval = None
    if path.edges < MIN_POINT_EDGES:
        low, high = (path.rate + bound for bound in path.allowed(noise_mean))
        interval = (low / period, high / period)
        rate, sigma[0] = _likely(interval, path.step)
    return RateEstimate(
        rate=float(rate), std=float(sigma[0]), slope=float(value[1]), slope_std=float(sigma[1]),
        curvature=float(value[2]), curvature_std=float(sigma[2]),
        noise=noise_mean / float(np.sqrt(period)), edges=path.edges, interval=interval,
    )  # fmt: skip


def _likely(interval: tuple[float, float], step: int) -> tuple[float, float]:
    """Return mean and 1 sigma of the rates of an ``interval``, for a remainder of which nothing is known.

    A rate that passes no integer in a dwell: a triangle. One that passes one at the moment that is seen: a ramp,
    which rises from where the count stands still.
    """
    low, high = interval
    if not step:
        return (low + high) / 2, (high - low) / TRIANGLE
    return (low + high) / 2 + np.sign(step) * (high - low) / 6, (high - low) / RAMP
