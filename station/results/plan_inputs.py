"""Inputs of a plan: a unit's noise, how long manual steps take at this station, required uncertainties.

Noise is from the unit's newest campaigns, else from those of other units of its model; times are from when the
steps were accepted.

Required uncertainties follow from limits, or are given by name. A parameter that was never measured needs a sigma
an eighth of its half interval: an expanded uncertainty (k=2) of a quarter of the tolerance (ANSI/NCSL Z540.3, test
uncertainty ratio 4:1). One that is known is accepted as long as its guard band stays inside
(`fixtures_db.imu_models`): its sigma may be what is between it and the limit, over the guard band's factor.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from sqlalchemy import select

from fixtures_db.campaigns import complete_campaigns
from fixtures_db.database import Database
from fixtures_db.imu_models import Limit, covered, limits_of
from fixtures_db.schema import CampaignRow, ImuRow
from fixtures_db.stored_calibrations import last_calibration
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.campaign.plan_steps import Dwell, Step, Turn
from procedures.errors import ProcedureError
from procedures.frames import TRIADS
from procedures.planning.campaign_design import HandTimes
from procedures.planning.design_sigmas import NAMES, WantedSigmas, wanted
from procedures.planning.step_information import UnitNoise
from procedures.units import PPM_PER_ONE
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_file import kept_plan
from station.files.limits_file import PPM, limits_in, units_of
from station.files.toml_file import read_text_file
from station.results.parameters_by_name import parameters

NEWEST = 3  # campaigns that are looked at


@dataclass(frozen=True, slots=True, eq=False)
class KnownNoise:
    """The noise, and from which recordings: in words."""

    noise: UnitNoise
    source: str


def known_noise(database: Database, model: str | None, serial: str | None, folders: Sequence[Path]) -> KnownNoise:
    """Return the noise that ``folders`` show where some are named, else what the database knows of a unit.

    Raise `DataRefused` if nothing is known; or as `noise_of` does.
    """
    known = noise_of(folders) if folders else noise_in_database(database, model, serial) if model else None
    if known is None:
        remedy = "name a campaign of it: --noise CAMPAIGN"
        raise DataRefused("noise", None, f"no campaign of {model or 'a unit'}", "one that shows its noise", remedy)
    return known


def noise_of(folders: Sequence[Path]) -> KnownNoise:
    """Return the noise that campaigns of one unit show, on the mean; raise as `read_campaign` and `fit` do."""
    found = [noise_in(fit([read_campaign(folder).campaign])) for folder in folders]
    return KnownNoise(mean_noise(found), ", ".join(str(folder) for folder in folders))


def noise_in_database(database: Database, model: str, serial: str | None) -> KnownNoise | None:
    """Return the noise of a unit's newest campaigns, else that of its model's; None where none can be read."""
    for unit in dict.fromkeys((serial, None)):
        read = list(_readable(_folders(database, model, unit)))
        if read:
            whose = f"{model} {unit}" if unit else f"units of {model}"
            return KnownNoise(mean_noise([noise for _, noise in read]), f"{len(read)} campaigns of {whose}")
    return None


def _folders(database: Database, model: str, serial: str | None) -> list[Path]:
    rows = select(CampaignRow).join(ImuRow).where(ImuRow.model == model, CampaignRow.state != "cancelled")
    if serial is not None:
        rows = rows.where(ImuRow.serial == serial)
    with database.read() as session:
        return [Path(row.folder) for row in session.scalars(rows.order_by(CampaignRow.id.desc()))]


def _readable(folders: Iterable[Path]) -> Iterable[tuple[Path, UnitNoise]]:
    """Give the newest that are still there and determine both triads."""
    left = NEWEST
    for folder in folders:
        if not left:
            return
        try:
            yield folder, noise_in(fit([read_campaign(folder).campaign]))
        except (DataRefused, ProcedureError, OSError):
            continue
        left -= 1


def noise_in(fits: CampaignFits) -> UnitNoise:
    """Return the noise that a campaign shows; raise `DataRefused` where it leaves a triad open."""
    accelerometer, gyroscope = fits.accelerometer, fits.gyroscope
    if accelerometer is None or gyroscope is None or fits.accel is None or fits.gyro is None:
        raise DataRefused("campaign", None, "a triad that is not solved", "a campaign that determines both triads")
    counts, gyro = fits.campaigns[0].counts, gyroscope.joint
    never = np.full(3, np.inf)
    return UnitNoise(
        fits.accel.noise / accelerometer.k, fits.gyro.noise / gyro.k,
        accelerometer.k if counts else never, gyro.k if counts else never,
        float(np.mean(gyro.excess / gyro.k)),
    )  # fmt: skip


def mean_noise(found: Sequence[UnitNoise]) -> UnitNoise:
    """Return the root mean squares of what campaigns show, and the mean of scale factors."""

    def rms(values: Iterable[FloatArray]) -> FloatArray:
        mean: FloatArray = np.sqrt(np.mean([value**2 for value in values], axis=0))
        return mean

    return UnitNoise(
        rms(one.accel_white for one in found), rms(one.gyro_white for one in found),
        np.mean([one.accel_scale for one in found], axis=0), np.mean([one.gyro_scale for one in found], axis=0),
        float(rms(np.array([one.instability]) for one in found)[0]),
    )  # fmt: skip


FEWEST_TIMES = 6  # placements, or turns, that were timed, below which the stated default stands
LEAST_S, MOST_S = 10.0, 300.0  # s: what is quicker was simulated, what is slower was a break
NEWEST_CAMPAIGNS = 20  # campaigns


def hand_times(database: Database) -> tuple[HandTimes, str]:
    """Return how long placements and turns take on the median, and where that is from, in words."""
    placements, turns = list[float](), list[float]()
    with database.read() as session:
        for row in list(complete_campaigns(session))[-NEWEST_CAMPAIGNS:]:
            for step, seconds in _timed(row):
                (turns if isinstance(step, Turn) else placements).append(seconds)
    usual = HandTimes()
    if len(placements) < FEWEST_TIMES:
        return (
            usual,
            f"{usual.placing:g} s per placement as stated: {len(placements)} were timed here, {FEWEST_TIMES} are "
            "needed",
        )
    placement = float(np.median(placements))
    turn = float(np.median(turns)) if len(turns) >= FEWEST_TIMES else usual.turn
    stated = f"{placement:.0f} s per placement, the median of {len(placements)} of this station"
    return HandTimes(placement, placement * usual.move / usual.placing, turn), stated


def _timed(row: CampaignRow) -> Sequence[tuple[Step, float]]:
    """Return dwells and turns with what they took in addition to recording, from the step accepted before."""
    try:
        steps = {step.name: step for step in kept_plan(Path(row.folder))}
    except (DataRefused, OSError):
        return ()
    accepted = [step for step in row.steps if not step.superseded]
    found = list[tuple[Step, float]]()
    for before, after in pairwise(accepted):
        step = steps.get(after.name)
        if isinstance(step, Dwell | Turn):
            recorded = step.seconds if isinstance(step, Dwell) else 0.0
            seconds = (after.accepted_utc - before.accepted_utc).total_seconds() - recorded
            if LEAST_S <= seconds <= MOST_S:
                found.append((step, seconds))
    return found


SIGMAS_OF_HALF = 8.0  # sigmas in half an interval: an expanded uncertainty of two is a quarter of it
PLANNED = tuple(dict.fromkeys(".".join(name.split(".")[:2]) for name in NAMES))
NUMBER_AND_UNIT = re.compile(r"\s*(\d*\.?\d+(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def limits_named(database: Database, limits: str | None) -> tuple[str | None, Sequence[Limit]]:
    """Return a model and its limits: those of a limits.toml, or those stored of a model; none of None.

    Raise `DataRefused` if there are none.
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
    found, stated = dict[str, float](), list[str]()
    for limit in limits:
        if limit.parameter not in NAMES:
            continue
        value = values.get(limit.parameter)
        low, high = limit.accepted(0.0)
        if value is not None and not low <= value <= high:
            stated.append(
                f"{limit.parameter} was {value:.6g} {limit.unit} at last, outside its limits: no plan helps"
            )
        elif (sigma := _sigma(limit, low, high, value)) is not None:
            centre = abs((low + high) / 2 if value is None else value)
            found[limit.parameter] = sigma / (centre if ".scale_factor" in limit.parameter else 1.0)
    return wanted(found), stated


def _sigma(limit: Limit, low: float, high: float, value: float | None) -> float | None:
    found = [(high - low) / 2 / SIGMAS_OF_HALF]
    if value is not None and limit.guard_band:
        found += [abs(value - end) / limit.guard_band for end in (low, high)]
    least = min(found)
    return least if 0 < least < np.inf else None


def wanted_by_name(asked: Iterable[str]) -> WantedSigmas:
    """Return the sigmas asked for as ``gyroscope.bias=0.02deg/h``, one for each axis; the smaller of two.

    Raise `ValueError` saying what is expected.
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
