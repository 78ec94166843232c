"""history/1: every calibration of a unit, its parameters as series, and what they say together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import numpy as np

from fixtures_db.hash_chain import utc_text
from fixtures_db.imu_models import Limit
from fixtures_db.stored_calibrations import MADE_WITH, Run, turn_ons
from procedures.arrays import FloatArray
from procedures.statistics.calibration_drift import (
    CLUSTER_DAYS,
    MAX_SPANS_AHEAD,
    MIN_CALIBRATIONS,
    MIN_EARLIER,
    CalibrationSeries,
    ControlChart,
    Forecast,
    Repeatability,
    control_chart,
    control_limit,
    forecast,
    last_predictable_day,
    turn_on_repeatability,
)
from procedures.statistics.significance import holm, two_sided
from station.results.parameters_by_name import Parameter, applied, parameters, shifts
from station.results.result_formats import IS_KEY
from station.text import plural

DAY_S = 86400.0
RunParameter = tuple[Run, Parameter]


@dataclass(frozen=True, slots=True)
class Drift:
    """A change since the calibration before, the same in units of u, and its p, adjusted for all parameters."""

    shift: float
    shift_sigma: float
    p_adjusted: float


@dataclass(frozen=True, slots=True)
class StoredCalibration:
    """A calibration of a unit; ``effects`` are the error terms of its model, each with the hash of its file."""

    sha256: str
    model: str
    accepted_utc: str
    status: str
    verdict: str | None
    effects: dict[str, str] | None
    limited: int
    measured_utc: str
    cube: str | None
    slab: str | None
    site: str | None
    operator: str | None
    parameters: dict[str, Parameter]
    drift: dict[str, Drift]

    @property
    def accepted(self) -> str:
        """When it was accepted, to the minute."""
        return self.accepted_utc[:16].replace("T", " ")


@dataclass(frozen=True, slots=True)
class UnitChart:
    """A control chart of the last calibrations; ``alarms`` are the hashes of those that are out of control."""

    z: list[float]
    ewma: list[float]
    ewma_limit: list[float]
    alarms: list[str]


@dataclass(frozen=True, slots=True)
class Prediction:
    """The value predicted, its 95 % interval, and those until then: date, value, both ends of the interval."""

    value: float
    interval_95: tuple[float, float]
    fan: list[tuple[str, float, float, float]]
    probability_outside: float | None
    interval_reaches_limit_utc: str | None


@dataclass(frozen=True, slots=True)
class ParameterHistory:
    """A parameter over the calibrations that hold it in the newest one's unit; ``needs`` says what is missing."""

    name: str = field(metadata=IS_KEY)
    unit: str
    calibrations: list[str]
    measured_utc: list[str]
    value: list[float]
    std: list[float]
    limits: dict[str, float] | None
    needs: list[str]
    repeatability: Repeatability | None
    chart: UnitChart | None
    prediction: Prediction | None

    @property
    def kind(self) -> str:
        """What it is of, without its axis."""
        return self.name.rpartition(".")[0]

    @property
    def axis(self) -> str:
        """Its axis, or pair of axes."""
        return self.name.rpartition(".")[2]

    def at(self, value: float, std: float) -> Parameter:
        """Return a value of its kind, ``std`` its sigma, both in its unit."""
        return Parameter(self.name, value, std, self.unit)


@dataclass(frozen=True, slots=True)
class ModelHistory:
    """What the calibrations of one model and serial number say together."""

    model: str
    turn_ons: int
    first_utc: str
    last_utc: str
    predicted_utc: str
    predicted_because: str
    control_limit: float
    left_out: list[str]
    parameters: dict[str, ParameterHistory]


@dataclass(frozen=True, slots=True)
class UnitHistory:
    """Every calibration of a unit; the fields of this and of what it holds are the keys of `history/1`."""

    format: str
    serial: str
    calibrations: list[StoredCalibration]
    analysis: list[ModelHistory]


def unit_history(
    serial: str, runs: Sequence[Run], limits: Mapping[str, Sequence[Limit]], asked: datetime | None = None
) -> UnitHistory:
    """Return the history of a unit; ``limits`` are those of each model, for ``asked`` see `analysis`."""
    models = dict.fromkeys(run.model for run in runs)
    together = [
        analysis([run for run in runs if run.model == model], limits.get(model, ()), asked) for model in models
    ]
    return UnitHistory("history/1", serial, entries(runs), together)


def by_parameter(runs: Sequence[Run]) -> tuple[dict[str, list[RunParameter]], list[str]]:
    """Return by parameter the runs that hold it, with a sigma and in the unit of the newest; what was left out.

    Recordings that were solved again count once.
    """
    found, distinct = dict[str, list[RunParameter]](), turn_ons(runs)
    for run in distinct:
        for name, one in applied(parameters(run.document)).items():
            found.setdefault(name, []).append((run, one))
    usable, left_out = dict[str, list[RunParameter]](), list[str]()
    for name, held in found.items():
        unit = held[-1][1].unit
        alike = [(run, one) for run, one in held if one.unit == unit and one.std is not None and one.std > 0]
        if len(alike) < len(held):
            left_out.append(
                f"{name}: {len(held) - len(alike)} of {len(held)} not in {unit} or without uncertainty"
            )
        if alike:
            usable[name] = alike
    if again := len(runs) - len(distinct):
        left_out.append(f"{plural(again, 'calibration')} of recordings that were solved again later")
    return usable, left_out


def values_and_sigmas(held: Sequence[Parameter]) -> tuple[FloatArray, FloatArray]:
    """Return values and sigmas (n,) of parameters that all have one."""
    return np.array([one.value for one in held]), np.array([one.std for one in held], dtype=np.float64)


HORIZON_DAYS = 3652  # how far ahead a limit's date is looked for
PREDICTION_POINTS = 12  # points of the prediction


def entries(runs: Sequence[Run]) -> list[StoredCalibration]:
    """Return each calibration in the order of storing; drift is against the one before of the same model."""
    made, last = list[StoredCalibration](), dict[str, dict[str, Parameter]]()
    for run in runs:
        found = applied(parameters(run.document))
        moved = shifts(found, last.get(run.model, {}))
        p_adjusted = holm({name: two_sided(one.sigmas) for name, one in moved.items()})
        made.append(
            StoredCalibration(
                sha256=run.sha256,
                model=run.model,
                accepted_utc=run.document["accepted_utc"],
                status=run.document["status"],
                verdict=run.document.get("verdict"),
                effects={str(e["name"]): str(e.get("sha256", "")) for e in run.document.get("effects", ())}
                or None,
                limited=len(run.document.get("limits", ())),
                measured_utc=utc_text(run.ended),
                **{kind: run.made_with.get(kind) for kind in MADE_WITH},
                parameters=found,
                drift={name: Drift(one.shift, one.sigmas, p_adjusted[name]) for name, one in moved.items()},
            )
        )
        last[run.model] = found
    return made


def analysis(runs: Sequence[Run], limits: Sequence[Limit], asked: datetime | None) -> ModelHistory:
    """Return what the runs of one model and serial number say together.

    Recordings that were solved again count once. ``asked`` is the date of the prediction; None is the date until
    which the newest calibration is valid, else a year after it.
    """
    distinct = turn_ons(runs)
    until, because = _within(distinct, *_due(distinct[-1], asked))
    found, left_out = by_parameter(runs)
    control = control_limit(max(len(found), 1))
    limit_of = {limit.parameter: limit for limit in limits}
    return ModelHistory(
        model=distinct[-1].model,
        turn_ons=len(distinct),
        first_utc=utc_text(distinct[0].ended),
        last_utc=utc_text(distinct[-1].ended),
        predicted_utc=utc_text(until),
        predicted_because=because,
        control_limit=control,
        left_out=left_out,
        parameters={name: _parameter(held, limit_of.get(name), control, until) for name, held in found.items()},
    )


def _within(runs: Sequence[Run], until: datetime, because: str) -> tuple[datetime, str]:
    """Return the date of the prediction, no later than the history lets it be; as it is where none is made."""
    first = runs[0].ended
    last = last_predictable_day(np.array([(run.ended - first).total_seconds() / DAY_S for run in runs]))
    if last is None or until <= (end := first + timedelta(days=last)):
        return until, because
    return end, f"{MAX_SPANS_AHEAD:g} times its history, not {until:%Y-%m-%d}"


def _due(newest: Run, asked: datetime | None) -> tuple[datetime, str]:
    if asked is not None:
        return asked, "as asked"
    valid = newest.document.get("valid_until")
    if valid is not None and (until := datetime.fromisoformat(valid).astimezone(UTC)) > newest.ended:
        return until, "the newest calibration is valid until then"
    return newest.ended + timedelta(days=365), "a year after the newest, which has no due date"


def _parameter(
    held: Sequence[RunParameter], limit: Limit | None, control: float, until: datetime
) -> ParameterHistory:
    runs, newest = [run for run, _ in held], held[-1][1]
    day = np.array([(run.ended - runs[0].ended).total_seconds() / DAY_S for run in runs])
    series = CalibrationSeries(day, *values_and_sigmas([one for _, one in held]))
    ends = None
    if limit is not None and limit.unit == newest.unit:
        ends = {key: one for key in ("low", "high") if (one := getattr(limit, key)) is not None}
    repeatability = turn_on_repeatability(series)
    chart = control_chart(series, control)
    asked, last = (until - runs[0].ended).total_seconds() / DAY_S, last_predictable_day(day)
    is_near = last is not None and asked <= last + 1e-3
    ahead = forecast(series, (ends or {}).get("low"), (ends or {}).get("high")) if is_near else None
    return ParameterHistory(
        name=newest.name,
        unit=newest.unit,
        calibrations=[run.sha256 for run in runs],
        measured_utc=[utc_text(run.ended) for run in runs],
        value=series.value.tolist(),
        std=series.std.tolist(),
        limits=ends,
        needs=list(_needs(repeatability, chart, ahead, series)),
        repeatability=repeatability,
        chart=None if chart is None else _chart(chart, runs),
        prediction=None if ahead is None else _prediction(ahead, runs[0].ended, float(day[-1]), asked),
    )


def _needs(
    repeatability: Repeatability | None,
    chart: ControlChart | None,
    ahead: Forecast | None,
    series: CalibrationSeries,
) -> list[str]:
    needs = []
    if repeatability is None:
        needs.append(f"turn-on repeatability: two within {CLUSTER_DAYS:g} days")
    if chart is None:
        needs.append(f"control chart: {MIN_EARLIER + 1} turn-ons, {len(series)} there")
    if ahead is None:
        there = f"{plural(len(series), 'turn-on')} over {series.day[-1] - series.day[0]:.3g} days"
        further = f"{MIN_CALIBRATIONS} more than {CLUSTER_DAYS:g} days apart, over a third of the days ahead"
        needs.append(f"prediction: {there}; needs {further}")
    return needs


def _chart(found: ControlChart, runs: Sequence[Run]) -> UnitChart:
    alarms = [run.sha256 for run, is_out in zip(runs[MIN_EARLIER:], found.alarms, strict=True) if is_out]
    return UnitChart(found.z.tolist(), found.ewma.tolist(), (found.limit * found.ewma_std).tolist(), alarms)


def _prediction(ahead: Forecast, first: datetime, last: float, asked: float) -> Prediction:
    """Return the prediction for the day ``asked``, after ``last``, both counted from the ``first`` calibration."""
    day = max(asked, last)
    fan = [ahead.at(last + (day - last) * (i / PREDICTION_POINTS) ** 2) for i in range(PREDICTION_POINTS + 1)]
    found, touch = fan[-1], None
    if found.outside is not None:
        horizon = min(float(HORIZON_DAYS), MAX_SPANS_AHEAD * last)
        touch = ahead.first_touch([last + horizon * (i / 40) ** 2 for i in range(41)])
    return Prediction(
        found.value,
        (found.low_95, found.high_95),
        [(_date(first, one.day), one.value, one.low_95, one.high_95) for one in fan],
        found.outside,
        None if touch is None else _date(first, touch),
    )


def _date(first: datetime, day: float) -> str:
    return utc_text((first + timedelta(days=day)).replace(microsecond=0))
