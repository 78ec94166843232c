"""history/1: every calibration of a unit, its parameters as series, and what they say together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from fixtures_db.hash_chain import utc_text
from fixtures_db.imu_models import Limit
from fixtures_db.stored_calibrations import Run, turn_ons
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
from station.text import plural

DAY_S = 86400.0
RunParameter = tuple[Run, Parameter]


@dataclass(frozen=True, slots=True, eq=False)
class ParameterSeries:
    """One parameter: the runs that hold it in the newest run's unit, and its series, in days after the first."""

    parameter: Parameter
    runs: tuple[Run, ...]
    series: CalibrationSeries


def unit_series(runs: Sequence[Run]) -> tuple[dict[str, ParameterSeries], list[str]]:
    """Return the series of the runs of one unit, oldest first, by parameter name; what was left out and why."""
    held, left_out = by_parameter(runs)
    made = {
        name: ParameterSeries(one[-1][1], tuple(run for run, _ in one), _series(one)) for name, one in held.items()
    }
    return made, left_out


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


def _series(held: Sequence[RunParameter]) -> CalibrationSeries:
    first = held[0][0].ended
    day = np.array([(run.ended - first).total_seconds() / DAY_S for run, _ in held])
    return CalibrationSeries(day, *values_and_sigmas([one for _, one in held]))


HORIZON_DAYS = 3652  # how far ahead a limit's date is looked for
PREDICTION_POINTS = 12  # points of the prediction


def entries(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return each calibration in the order of storing; drift is against the one before of the same model."""
    made, last = list[dict[str, Any]](), dict[str, dict[str, Any]]()
    for run in runs:
        found = applied(parameters(run.document))
        moved = shifts(found, applied(parameters(last.get(run.model, {}))))
        p_adjusted = holm({name: two_sided(one.sigmas) for name, one in moved.items()})
        made.append(
            {
                "sha256": run.sha256,
                **{key: run.document[key] for key in _COPIED_FIELDS if key in run.document},
                **effects_held(run.document),
                "limited": len(run.document.get("limits", ())),
                "measured_utc": utc_text(run.ended),
                **run.made_with,
                "parameters": {
                    name: {"value": one.value, "std": one.std, "unit": one.unit} for name, one in found.items()
                },
                "drift": {
                    name: {"shift": one.shift, "shift_sigma": one.sigmas, "p_adjusted": p_adjusted[name]}
                    for name, one in moved.items()
                },
            }
        )
        last[run.model] = run.document
    return made


_COPIED_FIELDS = ("model", "accepted_utc", "status", "verdict")


def effects_held(document: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Return ``effects`` of a calibration/1 by name, with the hash of a file's; nothing where it has none."""
    held = {str(one["name"]): str(one.get("sha256", "")) for one in document.get("effects", ())}
    return {"effects": held} if held else {}


def analysis(runs: Sequence[Run], limits: Sequence[Limit], asked: datetime | None) -> dict[str, Any]:
    """Return what the runs of one model and serial number say together.

    Recordings that were solved again count once. ``asked`` is the date of the prediction; None is the date until
    which the newest calibration is valid, else a year after it.
    """
    distinct = turn_ons(runs)
    until, because = _within(distinct, *_due(distinct[-1], asked))
    found, left_out = unit_series(runs)
    control = control_limit(max(len(found), 1))
    limit_of = {limit.parameter: limit for limit in limits}
    return {
        "model": distinct[-1].model,
        "turn_ons": len(distinct),
        "first_utc": utc_text(distinct[0].ended),
        "last_utc": utc_text(distinct[-1].ended),
        "predicted_utc": utc_text(until),
        "predicted_because": because,
        "control_limit": control,
        "left_out": left_out,
        "parameters": {
            name: _parameter(track, limit_of.get(name), control, until) for name, track in found.items()
        },
    }


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


def _parameter(track: ParameterSeries, limit: Limit | None, control: float, until: datetime) -> dict[str, Any]:
    series, unit = track.series, track.parameter.unit
    made: dict[str, Any] = {
        "unit": unit,
        "calibrations": [run.sha256 for run in track.runs],
        "measured_utc": [utc_text(run.ended) for run in track.runs],
        "value": series.value.tolist(),
        "std": series.std.tolist(),
    }
    if limit is not None and limit.unit == unit:
        made["limits"] = {key: one for key in ("low", "high") if (one := getattr(limit, key)) is not None}
    repeatability = turn_on_repeatability(series)
    chart = control_chart(series, control)
    day, last = (until - track.runs[0].ended).total_seconds() / DAY_S, last_predictable_day(series.day)
    is_near = last is not None and day <= last + 1e-3
    ends = made.get("limits", {})
    ahead = forecast(series, ends.get("low"), ends.get("high")) if is_near else None
    made["needs"] = list(_needs(repeatability, chart, ahead, series))
    if repeatability is not None:
        made["repeatability"] = {
            "std": repeatability.value,
            "interval_95": [repeatability.low_95, repeatability.high_95],
            "turn_ons": repeatability.runs,
            "dof": repeatability.dof,
            **({} if repeatability.std is None else {"std_of_std": repeatability.std}),
        }
    if chart is not None:
        made["chart"] = _chart(chart, track)
    if ahead is not None:
        made["prediction"] = _prediction(ahead, track, until)
    return made


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


def _chart(found: ControlChart, track: ParameterSeries) -> dict[str, Any]:
    judged = track.runs[MIN_EARLIER:]
    return {
        "z": found.z.tolist(),
        "ewma": found.ewma.tolist(),
        "ewma_limit": (found.limit * found.ewma_std).tolist(),
        "alarms": [run.sha256 for run, is_out in zip(judged, found.alarms, strict=True) if is_out],
    }


def _prediction(ahead: Forecast, track: ParameterSeries, until: datetime) -> dict[str, Any]:
    first, last = track.runs[0].ended, float(track.series.day[-1])
    day = max((until - first).total_seconds() / DAY_S, last)
    fan = [ahead.at(last + (day - last) * (i / PREDICTION_POINTS) ** 2) for i in range(PREDICTION_POINTS + 1)]
    found = fan[-1]
    made: dict[str, Any] = {
        "value": found.value,
        "interval_95": [found.low_95, found.high_95],
        "fan": [[_date(first, one.day), one.value, one.low_95, one.high_95] for one in fan],
    }
    if found.outside is not None:
        made["probability_outside"] = found.outside
        horizon = min(float(HORIZON_DAYS), MAX_SPANS_AHEAD * (last - float(track.series.day[0])))
        touch = ahead.first_touch([last + horizon * (i / 40) ** 2 for i in range(41)])
        if touch is not None:
            made["interval_reaches_limit_utc"] = _date(first, touch)
    return made


def _date(first: datetime, day: float) -> str:
    return utc_text((first + timedelta(days=day)).replace(microsecond=0))
