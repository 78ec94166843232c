"""A campaign in memory: all that a solve needs, independent of where it came from, and its clock.

The device's clock as a campaign's own records show it, against the reference time of each row (``utc_s``).
Nothing is concluded from a reference that leaves the rate open to more than 0.1 % or is no time [s] of these rows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.reference_time import ClockRate, fit_clock
from procedures.counts.sample_records import Series
from procedures.units import PPM_PER_ONE


@dataclass(frozen=True, slots=True)
class Site:
    """Where the slab stands: latitude [rad], gravity and its 1 sigma [m/s2], magnetic field [uT] East-North-Up."""

    latitude: float
    gravity: float
    gravity_std: float
    magnetic: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class ProcedureSigma:
    """How well the operator works, 1 sigma [rad]: a position's heading, a turn's return to where it began, a seat.

    ``seat`` is by how much a face lies otherwise on the slab from placement to placement, of each of its two
    tilts.

    ``unsettled_gyro`` [rad/s] and ``unsettled_accelerometer`` [m/s2]: 1 sigma of the bias from step to step where
    the unit was not given the time to settle.
    """

    heading: float = float(np.radians(0.1))
    closure: float = float(np.radians(0.02))
    unsettled_gyro: float = 0.0
    unsettled_accelerometer: float = 0.0
    seat: float = float(np.radians(1 / 3600))


@dataclass(frozen=True, slots=True, eq=False)
class FaceCertificate:
    """A measured resting face: up vector's components along the two other cube axes (2,) and covariance (2, 2)."""

    up_tilt: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredCube:
    """A cube as IMUs measured it: ``value`` (n,) [rad] of ``names`` and covariance (n, n) [rad2].

    The names are of `procedures.campaign.measured_cube.NAMES`; ``units`` names the IMUs, model and serial number.
    """

    names: tuple[str, ...]
    value: FloatArray
    covariance: FloatArray
    units: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Fixture:
    """The cube: certificates by face name (``x_up`` ...), and how the IMU sits in it.

    ``C_sb`` (3, 3) takes the cube's axes to the IMU's; its rows are the cube axes along which IMU x, y, z point.
    ``measured`` is what IMUs found of a cube whose faces have no certificate.
    """

    faces: Mapping[str, FaceCertificate] = field(default_factory=dict)
    C_sb: FloatArray = field(default_factory=lambda: np.eye(3))
    id: str | None = None
    measured: MeasuredCube | None = None


@dataclass(frozen=True, slots=True, eq=False)
class DwellRecord:
    """A dwell as it was recorded; ``name`` is the file's name or the step's.

    ``turn_on`` says, of every step, for which time from 1 the unit was switched on in its campaign.
    """

    name: str
    position: int
    series: Series
    turn_on: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class TurnRecord:
    """A turn as it was recorded: cube axis up, direction + or -, revolutions (or a part), where it begins."""

    name: str
    axis: str
    direction: str
    revolutions: float
    start_position: int
    series: Series
    turn_on: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class RestRecord:
    """A dwell in none of the twelve positions: ``up`` is the face where it is known (``x_up`` ...), else None."""

    name: str
    up: str | None
    series: Series


@dataclass(frozen=True, slots=True, eq=False)
class SequenceRecord:
    """An unsegmented recording: rests in unknown attitudes and moves between them."""

    name: str
    series: Series


@dataclass(frozen=True, slots=True, eq=False)
class MoveRecord:
    """A move by hand from the end of the step named ``before`` to the beginning of the step named ``after``.

    ``off`` (3,) [rad], IMU axes, is by how much it turned besides what leads from one placement to the other, if
    so.
    """

    name: str
    before: str
    after: str
    series: Series
    off: FloatArray | None = None


StepRecord = DwellRecord | TurnRecord | RestRecord | SequenceRecord


@dataclass(frozen=True, slots=True, eq=False)
class SoakRecord:
    """A long rest while temperature or an auxiliary channel moves.

    In a position 1..12, or 0: then with the face ``up`` (``x_up`` ...), or None: at an attitude unknown.
    """

    name: str
    position: int
    up: str | None
    series: Series


UNKNOWN = "unknown"  # model or serial number that neither the device nor a person says


@dataclass(frozen=True, slots=True, eq=False)
class RateTable:
    """A turntable's points, in the order they were taken; ``axis`` is the cube's that it turned about.

    ``reference`` (n,) [deg/s], ``output`` (n, 3) of the gyroscopes, nan where absent, per second for counts;
    ``temperature`` (n,) [degC] and ``t`` (n,) [s], the middle of a point, nan where unknown; t rises.
    ``lines`` (n,) are those of the file, None where a point is no line.
    """

    name: str
    axis: str
    reference: FloatArray
    output: FloatArray
    temperature: FloatArray
    t: FloatArray | None = None
    lines: Sequence[int] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """One campaign of one unit. ``counts`` says whether the output is counts (else rates).

    ``nominal_period`` [s] is the sample period that the campaign states, where it states one. ``period_std``,
    relative, is 1 sigma of the sample period that all its steps have in common, where stamps leave it open.
    ``nominal_scale`` is how many outputs are 1 deg/s or 1 g, of the triads (`TRIADS`) whose unit is stated.
    """

    model: str
    serial: str
    counts: bool
    site: Site
    dwells: tuple[DwellRecord, ...]
    turns: tuple[TurnRecord, ...]
    sigma: ProcedureSigma = ProcedureSigma()
    fixture: Fixture = field(default_factory=Fixture)
    rests: tuple[RestRecord, ...] = ()
    sequences: tuple[SequenceRecord, ...] = ()
    nominal_period: float | None = None
    rate_tables: tuple[RateTable, ...] = ()
    soaks: tuple[SoakRecord, ...] = ()
    period_std: float = 0.0
    nominal_scale: Mapping[str, float] = field(default_factory=dict)
    moves: tuple[MoveRecord, ...] = ()

    @property
    def steps(self) -> tuple[StepRecord, ...]:
        """Dwells, turns, rests and sequences."""
        return (*self.dwells, *self.turns, *self.rests, *self.sequences)


def period_std(campaigns: Sequence[Campaign]) -> float:
    """Return the relative 1 sigma of the time base that stamps leave open: of the worst of campaigns."""
    return max(campaign.period_std for campaign in campaigns)


MAX_CLOCK_PPM = 5e4  # ppm: beyond, no clock is off
MAX_RATE_ERROR = 1e-3  # relative: 4 sigma of a rate from which something is concluded
RATE_SIGMAS = 4.0
MAX_CLOCK_FACTOR = 20.0  # times as fast, or as slow: no device is set as wrong, utc_s is no time [s] of these rows
MIN_RECORD_S = 2.0  # of a record that determines it


def is_known(rate: ClockRate) -> bool:
    """Say whether a rate is known to 0.1 %, by four sigma."""
    return RATE_SIGMAS * rate.std / PPM_PER_ONE <= MAX_RATE_ERROR


def clock_rate(campaign: Campaign) -> ClockRate | None:
    """Fit reference time over device time where rows hold it; None where too few do, or it is no time [s]."""
    return None if false_rate(campaign) is not None else fit_clock(_pieces(campaign))


def false_rate(campaign: Campaign) -> float | None:
    """Return by how much ``utc_s`` moves in a device's second where it is no time [s] of these rows; else None.

    Milliseconds move by 1000, what runs backwards by -1, a constant by 0. Median of the records.
    """
    paces, grains = list[float](), list[float]()
    for t, u in _pieces(campaign):
        t, u = t[known := np.isfinite(t) & np.isfinite(u)], u[known]
        if len(t) and t[-1] - t[0] >= MIN_RECORD_S:
            steps = np.abs(np.diff(u))
            paces.append(float((u[-1] - u[0]) / (t[-1] - t[0])))
            grains.append(float(np.median(steps[steps > 0])) / float(t[-1] - t[0]) if steps.any() else 0.0)
    if not paces:
        return None
    pace, grain = float(np.median(paces)), float(np.median(grains))
    is_time = (
        pace < MAX_CLOCK_FACTOR and pace + 2 * grain > 1 / MAX_CLOCK_FACTOR
    )  # coarse stamps may stand still in a short record
    return None if is_time else pace


def _pieces(campaign: Campaign) -> list[tuple[FloatArray, FloatArray]]:
    return [
        (s.t, s.extra["utc_s"])
        for step in (*campaign.steps, *campaign.soaks)
        if "utc_s" in (s := step.series).extra
    ]
