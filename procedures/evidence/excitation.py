"""What the sensors went through, at a few nodes of every step: the coordinates that effects are made of.

Attitudes are nominal, as the plan says: on fitted attitudes an effect that faces cannot excite would turn into a
copy of the faces' own tilts. Rests at unknown attitudes have no nominal one: there it is what gravity showed.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TurnTotal, channel
from procedures.counts.sample_records import CountSeries, Series
from procedures.effects.excitation import Excitation, ExcitationStep
from procedures.frames import TRIADS, rotation, rotation_vector
from procedures.geodesy import earth_rate_n
from procedures.positions import face_normal, nominal_C_lb
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.twelve_positions.manual_rotations import heading_history
from procedures.units import STANDARD_GRAVITY

DWELL_NODES = 96
TURN_NODE_S = 0.1  # s: a hand turns a few degrees meanwhile
TEMPERATURE_DEGREE = 2  # degree of the polynomial through a step's temperature, of which its rate is the slope


@dataclass(frozen=True, slots=True, eq=False)
class StepNodes:
    """One step's nodes: fields as in `Excitation`; ``step`` and ``change`` there come from the order of all."""

    step: ExcitationStep
    f: FloatArray
    omega: FloatArray
    magnetic: FloatArray
    accel_output: FloatArray
    gyro_output: FloatArray
    t: FloatArray
    rest_s: FloatArray
    temperature: FloatArray
    temperature_rate: FloatArray
    auxiliary: dict[str, FloatArray]
    C_sb: FloatArray
    E_accel: FloatArray
    E_gyro: FloatArray
    C_sn: FloatArray
    vibration: FloatArray
    seconds: FloatArray  # (n,) that a node stands for


SHAKEN = ("dwell", "rest", "soak")  # kinds of steps whose vibration is measured
PER_PART = ("C_sb", "E_accel", "E_gyro")


def join_nodes(parts: Sequence[StepNodes]) -> Excitation:
    """Return the nodes of all parts one after the other."""
    sizes = [len(part.t) for part in parts]
    number = np.repeat(np.arange(len(parts)), sizes)
    names = sorted({name for part in parts for name in part.auxiliary})
    missing = [np.full(size, np.nan) for size in sizes]
    shared = {f.name for f in fields(Excitation)} & {f.name for f in fields(StepNodes)} - {
        "step",
        "auxiliary",
        *PER_PART,
    }
    at_nodes: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in shared
    } | {name: np.stack([getattr(part, name) for part in parts])[number] for name in PER_PART}
    auxiliary = {
        name: np.concatenate([p.auxiliary.get(name, gap) for p, gap in zip(parts, missing, strict=True)])
        for name in names
    }
    for values in (at_nodes["temperature"], at_nodes["temperature_rate"], *auxiliary.values()):
        _fill_moves(values, at_nodes["t"], number, parts)
    return Excitation(
        **at_nodes,
        change=_changes(parts, number),
        auxiliary=auxiliary,
        step=number.astype(np.int64),
        steps=tuple(part.step for part in parts),
    )


def _fill_moves(values: FloatArray, t: FloatArray, number: IntArray, parts: Sequence[StepNodes]) -> None:
    """Put into ``values`` (n,) in moves that are too short to measure them what goes straight between their ends.

    ``t`` (n,) [s] is device time, ``number`` (n,) the part of every node.
    """
    campaign = np.array([part.step.campaign for part in parts])[number]
    for i, part in enumerate(parts):
        if part.step.kind == "move" and not np.isfinite(values[here := number == i]).all():
            known = np.flatnonzero((campaign == part.step.campaign) & np.isfinite(values))
            known = known[np.argsort(t[known])]
            if len(known):
                values[here] = np.interp(t[here], t[known], values[known])


def _changes(parts: Sequence[StepNodes], number: IntArray) -> FloatArray:
    """Return by how much f (n, 3) differs from the step before, in the order of time; nan for the first.

    A move is no step before another: it leads from the one before it to the next.
    """
    order = sorted(range(len(parts)), key=lambda i: (parts[i].step.campaign, parts[i].t[0]))
    change, before = np.full((len(number), 3), np.nan), -1
    for after in order:
        part, is_move = parts[after], parts[after].step.kind == "move"
        if before >= 0 and parts[before].step.campaign == part.step.campaign:
            change[number == after] = (part.f if is_move else part.f[0]) - parts[before].f[-1]
        before = before if is_move else after
    return change


@lru_cache(maxsize=1024)  # a loop asks for the same steps after every refit: their samples are as they were
def equal_bins(series: Series, count: int) -> "Bins":
    """Cut a series into about ``count`` bins of whole samples."""
    n = len(series)
    return Bins(series, np.unique(np.linspace(0, n, min(count, n) + 1).round().astype(np.int64)))


@dataclass(frozen=True, eq=False)
class Bins:
    """A series cut into ``edges`` (m + 1,), sample numbers."""

    series: Series
    edges: IntArray

    def mean(self, values: FloatArray) -> FloatArray:
        """Return the means (m, ...) of samples ``values`` (n, ...) in every bin, in their unit."""
        sums = np.add.reduceat(np.asarray(values, dtype=np.float64), self.edges[:-1], axis=0)
        size = np.diff(self.edges).astype(np.float64)
        return sums / (size if sums.ndim == 1 else size[:, None])

    @cached_property
    def middle(self) -> FloatArray:
        """Device time (m,) [s] of the bins' middles."""
        return self.mean(self.series.t) - self.series.period / 2

    @property
    def seconds(self) -> FloatArray:
        """How long each is (m,) [s]."""
        return np.diff(self.edges) * self.series.period

    @cached_property
    def temperature(self) -> tuple[FloatArray, FloatArray]:
        """Return temperature (m,) [degC] and its rate (m,) [K/min] at the bins, of a polynomial."""
        t, T = self.series.t, self.series.temperature
        known = np.isfinite(T)
        middle = self.middle
        if known.sum() < 8 * (TEMPERATURE_DEGREE + 1):
            return np.full(len(middle), np.nan), np.full(len(middle), np.nan)
        centre, half = t.mean(), max(np.ptp(t) / 2, 1e-9)
        polynomial = np.polynomial.Polynomial(
            np.polynomial.polynomial.polyfit((t[known] - centre) / half, T[known], TEMPERATURE_DEGREE)
        )
        x = (middle - centre) / half
        return polynomial(x), 60 * polynomial.deriv()(x) / half

    @cached_property
    def auxiliary(self) -> dict[str, FloatArray]:
        """Return the means (m,) of every auxiliary channel in the bins, in its unit; nan where none is known."""
        found = {}
        for name, values in self.series.extra.items():
            if name.startswith("aux_"):
                known = np.isfinite(values)
                share = self.mean(known.astype(float))
                with np.errstate(invalid="ignore", divide="ignore"):
                    found[name.removeprefix("aux_")] = self.mean(np.where(known, values, 0.0)) / share
        return found


class NodeBuilder:
    """Makes the parts of steps at rest and of turns for one set of fits."""

    def __init__(self, fits: CampaignFits) -> None:
        self.campaigns = fits.campaigns
        self.accel = fits.accelerometer
        self.gyro = fits.gyroscope.joint if fits.gyroscope is not None else None

    @cached_property
    def tilts(self) -> dict[tuple[int, str], tuple[float, float, float]]:
        """By campaign and name of each dwell the rotation vector [rad], IMU axes, from nominal to as solved."""
        return {**_tilts(self.gyro), **_tilts(self.accel)}

    def rest(
        self,
        number: int,
        step: ExcitationStep,
        series: Series,
        C_sn: FloatArray | None,
        f: FloatArray | None = None,
        nodes: int = DWELL_NODES,
    ) -> StepNodes:
        """Return a step at rest; ``C_sn`` (3, 3) takes East-North-Up to the IMU's axes, where that is known.

        ``f`` (3,) [g] is the specific force in IMU axes where the attitude is not.
        """
        campaign, bins = self.campaigns[number], equal_bins(series, nodes)
        n = len(bins.edges) - 1
        up, earth, magnetic = site_vectors(campaign)
        unknown = np.full(3, np.nan)
        f = C_sn @ up if C_sn is not None else unknown if f is None else f
        omega = C_sn @ earth if C_sn is not None else np.zeros(3)
        field = C_sn @ magnetic if C_sn is not None else unknown
        many = [np.tile(vector, (n, 1)) for vector in (f, omega, field)]
        attitude = np.tile(np.full((3, 3), np.nan) if C_sn is None else C_sn, (n, 1, 1))
        return self.part(campaign, step, bins, attitude, *many)

    def turn(self, turn: TurnTotal, step: ExcitationStep) -> StepNodes:
        """Return a turn, its rate as the gyroscopes measured it."""
        campaign, series = self.campaigns[turn.campaign], turn.record.series
        bins = equal_bins(series, max(round(len(series) * series.period / TURN_NODE_S), 8))
        assert self.gyro is not None
        K, b = self.gyro.K, self.gyro.b
        up, earth, magnetic = site_vectors(campaign)
        heading = bins.mean(heading_history(turn, campaign.fixture.C_sb, K, b, float(earth[2])))
        C_bl = nominal_C_lb(turn.record.start_position).T
        about = np.zeros((len(heading), 3))
        about[:, 2] = -heading
        C_sn = campaign.fixture.C_sb @ C_bl @ rotation(about)
        samples = np.asarray(channel(series, "gyroscope"), dtype=np.float64)
        rate = bins.mean(samples) / (series.period if isinstance(series, CountSeries) else 1.0)
        omega: FloatArray = np.linalg.solve(K, (rate - b).T).T.astype(np.float64)
        return self.part(campaign, step, bins, C_sn, C_sn @ up, omega, C_sn @ magnetic)

    def part(
        self,
        campaign: Campaign,
        step: ExcitationStep,
        bins: Bins,
        C_sn: FloatArray,
        f: FloatArray,
        omega: FloatArray,
        field: FloatArray,
    ) -> StepNodes:
        """Return a step's m nodes.

        Parameters
        ----------
        campaign, step, bins : what it is of, and its samples in m bins
        C_sn : (m, 3, 3), East-North-Up to the IMU's axes, nan where that is not known
        f, omega, field : (m, 3) [g], [deg/s], [uT], IMU axes
        """
        temperature, warming = bins.temperature
        return StepNodes(
            step, f, omega, field, _output(self.accel, f), _output(self.gyro, omega), bins.middle,
            bins.middle - (bins.series.t[0] - bins.series.period), temperature, warming, bins.auxiliary,
            campaign.fixture.C_sb, _misalignment(self.accel), _misalignment(self.gyro), C_sn,
            np.tile(self._vibration(step, bins.series), (len(f), 1)), bins.seconds,
        )  # fmt: skip

    def _vibration(self, step: ExcitationStep, series: Series) -> FloatArray:
        """Return the variance (3,) [g^2] of the accelerometers' samples about a parabola; 0 of other steps."""
        samples = channel(series, "accelerometer")
        if samples is None or step.kind not in SHAKEN:
            return np.zeros(3)
        nominal = self.campaigns[step.campaign].nominal_scale.get("accelerometer", 1.0)
        k = np.full(3, nominal) if self.accel is None else self.accel.k
        x = np.linspace(-1.0, 1.0, len(samples))
        smooth, _ = np.linalg.qr(np.stack((np.ones(len(x)), x, x**2), axis=1))
        level = samples - smooth @ (smooth.T @ samples)
        per = series.period if isinstance(series, CountSeries) else 1.0
        found: FloatArray = np.mean(level**2, axis=0) / (k * per) ** 2
        return found


def _tilts(fit: TriadFit | None) -> dict[tuple[int, str], tuple[float, float, float]]:
    if fit is None:
        return {}
    bench, at = fit.bench, fit.fit.x[12:]
    turned = bench.C_sb @ bench.attitudes(at[: bench.size])
    nominal = bench.C_sb @ np.array([nominal_C_lb(place.position).T for place in bench.placements]).reshape(
        -1, 3, 3
    )
    vectors = rotation_vector(turned @ np.swapaxes(nominal, 1, 2)).tolist()
    of_dwells = zip(fit.seen.dwells, vectors, strict=False)  # turns' placements follow those of dwells
    return {(number, record.name): tuple(vector) for (number, record), vector in of_dwells}


def _output(fit: TriadFit | None, u: FloatArray) -> FloatArray:
    """Return E u + D (n, 3) of inputs (n, 3), the inputs where the triad is not solved."""
    if fit is None:
        return u
    output: FloatArray = (u @ fit.K.T + fit.b) / fit.k
    return output


def _misalignment(fit: TriadFit | None) -> FloatArray:
    """Return E (3, 3), unit where the triad is not solved."""
    return np.eye(3) if fit is None else fit.K / fit.k[:, None]


def site_vectors(campaign: Campaign) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return specific force at rest [g], Earth rate [deg/s] and magnetic field [uT], (3,) each, East-North-Up."""
    up = np.array([0.0, 0.0, campaign.site.gravity / STANDARD_GRAVITY])
    field = np.full(3, np.nan) if campaign.site.magnetic is None else np.array(campaign.site.magnetic)
    return up, np.degrees(earth_rate_n(campaign.site.latitude)), field


def attitude(campaign: Campaign, position: int) -> FloatArray:
    """Return the nominal rotation C_sn (3, 3), without unit, East-North-Up to IMU axes, in position 1..12."""
    return campaign.fixture.C_sb @ nominal_C_lb(position).T


def on_face(campaign: Campaign, face: str) -> FloatArray:
    """Return the specific force (3,) [g], IMU axes, with a face of the cube up."""
    return campaign.site.gravity / STANDARD_GRAVITY * campaign.fixture.C_sb @ face_normal(face)


@dataclass(frozen=True, slots=True, eq=False)
class SteppedRows:
    """Rows of one triad, their numbers (r,), freed of ``absorbed`` (r, q); ``sigma`` (r,) whitens them."""

    rows: IntArray
    sigma: FloatArray
    absorbed: FloatArray

    def free(self, H: FloatArray) -> None:
        """Free these rows of columns H (n, k), in units of ``sigma``, of what the steps take of them."""
        taken = self.absorbed.T @ (H[self.rows] / self.sigma[:, None])
        H[self.rows] -= self.sigma[:, None] * (self.absorbed @ taken)


def stepped_rows(fits: CampaignFits, marked: Callable[..., BoolArray]) -> tuple[SteppedRows, ...]:
    """Return the rows that were freed of steps.

    ``marked`` takes kinds and a triad to marks (n,), no unit, as `Evidence.rows` does.
    """
    joints = (fits.accelerometer, fits.gyroscope.joint if fits.gyroscope is not None else None)
    found = list[SteppedRows]()
    for triad, joint in zip(TRIADS, joints, strict=True):
        if joint is not None and joint.profiled:
            parts = list(_parts(fits, joint))
            rows = [np.flatnonzero(marked(kind, triad=triad)) for kind, _, _ in parts]
            sigma = np.concatenate([std.ravel() for _, std, _ in parts])
            absorbed = np.concatenate([joint.absorbed[of_fit] for _, _, of_fit in parts])
            found.append(SteppedRows(np.concatenate(rows), sigma, absorbed))
    return tuple(found)


def _parts(fits: CampaignFits, joint: TriadFit) -> Iterator[tuple[str, FloatArray, slice]]:
    """Yield the kinds of rows that a bias shows in, the sigma that whitened them, and which rows they are."""
    dwells = 3 * len(joint.seen.dwells)
    yield "mean", joint.sigma / joint.k, slice(0, dwells)
    gyroscope = fits.gyroscope
    if gyroscope is None or joint is not gyroscope.joint:
        return
    yield "turn", gyroscope.turn_sigma / joint.k, slice(dwells, dwells + 3 * len(gyroscope.turns))
    if gyroscope.moves is not None:
        sigma = np.degrees(gyroscope.moves.sigma)[:, None] * np.ones(3)
        yield "move", sigma, gyroscope.moves.rows
