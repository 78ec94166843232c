"""Parameters over the calibrations of a unit, as series of numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fixtures_db.stored_calibrations import Run, turn_ons
from procedures.arrays import FloatArray
from procedures.history.repeatability import CalibrationSeries
from station.results.parameters_by_name import Parameter, applied, parameters
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
