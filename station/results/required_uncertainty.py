"""Which sigmas limits ask for, and those that are asked for by name.

A parameter that was never measured needs a sigma an eighth of its half interval: an expanded uncertainty (k=2) of
a quarter of the tolerance (ANSI/NCSL Z540.3, test uncertainty ratio 4:1). One that is known is accepted as long as
its guard band stays inside (`fixtures_db.imu_models`): its sigma may be what is between it and the limit, over
the guard band's factor.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from fixtures_db.database import Database
from fixtures_db.imu_models import Limit, covered, limits_of
from fixtures_db.stored_calibrations import last_calibration
from procedures.frames import TRIADS
from procedures.planning.design_sigmas import NAMES, WantedSigmas, wanted
from procedures.units import PPM_PER_ONE
from station.errors import DataRefused
from station.files.limits_file import PPM, limits_in, units_of
from station.files.toml_file import read_text_file
from station.results.parameters_by_name import parameters

SIGMAS_OF_HALF = 8.0  # sigmas in half an interval: an expanded uncertainty of two is a quarter of it
PLANNED = tuple(dict.fromkeys(".".join(name.split(".")[:2]) for name in NAMES))
NUMBER_AND_UNIT = re.compile(r"\s*(\d*\.?\d+(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def limits_named(database: Database, limits: str | None) -> tuple[str | None, Sequence[Limit]]:
    """Return a model and its limits: those of a limits.toml, or those stored of a model; none of None.

    Raises
    ------
    DataRefused
        If there are none.
    """
    if limits is None:
        return None, ()
    if Path(limits).is_file():
        return limits_in(read_text_file(Path(limits)), Path(limits))
    with database.read() as session:
        if found := limits_of(session, limits):
            return limits, found
    remedy = f"`station fixtures limits {limits} --import FILE` stores them"
    raise DataRefused("limits", None, f"no limits of {limits}, and no such file", "a model with limits", remedy)


def last_values(database: Database, model: str | None, serial: str | None) -> dict[str, float]:
    """Return the parameters of a unit's last calibration by name, none where it has none."""
    if model is None or serial is None:
        return {}
    with database.read() as session:
        last = last_calibration(session, model, serial)
        document = {} if last is None else json.loads(last.document)
    return {name: one.value for name, one in parameters(document).items()}


def wanted_by(limits: Iterable[Limit], values: Mapping[str, float]) -> tuple[WantedSigmas, list[str]]:
    """Return what limits ask for, ``values`` by parameter being known, and what no plan can do about some of them.

    Limits of a single side ask for something only where the value is known.
    """
    found, said = dict[str, float](), list[str]()
    for limit in limits:
        if limit.parameter not in NAMES:
            continue
        value = values.get(limit.parameter)
        low, high = limit.accepted(0.0)
        if value is not None and not low <= value <= high:
            said.append(
                f"{limit.parameter} was {value:.6g} {limit.unit} at last, outside its limits: no plan helps"
            )
        elif (sigma := _sigma(limit, low, high, value)) is not None:
            centre = abs((low + high) / 2 if value is None else value)
            found[limit.parameter] = sigma / (centre if ".scale_factor" in limit.parameter else 1.0)
    return wanted(found), said


def _sigma(limit: Limit, low: float, high: float, value: float | None) -> float | None:
    found = [(high - low) / 2 / SIGMAS_OF_HALF]
    if value is not None and limit.guard_band:
        found += [abs(value - end) / limit.guard_band for end in (low, high)]
    least = min(found)
    return least if 0 < least < np.inf else None


def wanted_by_name(asked: Iterable[str]) -> WantedSigmas:
    """Return the sigmas asked for as ``gyroscope.bias=0.02deg/h``, one for each axis; the smaller of two.

    Raises
    ------
    ValueError
        Saying what is expected.
    """
    found = WantedSigmas(np.full(len(NAMES), np.inf))
    for text in asked:
        name, _, given = text.partition("=")
        parts = NUMBER_AND_UNIT.fullmatch(given)
        sigma, unit = (float(parts[1]), parts[2]) if parts else (0.0, "")
        names = [one for one in covered(name.strip()) if one in NAMES]
        if not names or name.strip() in TRIADS:
            raise ValueError(f"found {name.strip()!r}, expected one of {', '.join(PLANNED)}, or an axis of it")
        if not 0 < sigma < np.inf or not unit:
            raise ValueError(f"found {text!r}, expected a number and its unit, such as gyroscope.bias=0.02deg/h")
        found = found.and_also(wanted(dict.fromkeys(names, _in_files(name.strip(), sigma, unit))))
    return found


def _in_files(name: str, sigma: float, unit: str) -> float:
    if ".scale_factor" in name:
        if unit != PPM:
            raise ValueError(f"found {name} in {unit!r}, expected {PPM}")
        return sigma / PPM_PER_ONE
    units = units_of(name)
    if unit not in units:
        raise ValueError(
            f"found {name} in {unit!r}, expected one of {', '.join(one for one in units if one != '1')}"
        )
    return units[unit] * sigma
