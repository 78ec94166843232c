"""What a campaign goes on for whose steps are not fixed: the sigmas asked for, and the noise it is reckoned by."""

from pathlib import Path

import numpy as np

from fixtures_db.database import Database
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Fixture
from procedures.planning.campaign_design import HandTimes
from procedures.planning.design_sigmas import NAMES
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import ProcedureTable, SiteTable
from station.files.campaign_folder.plan_file import NAMES as NOTES
from station.files.campaign_folder.plan_file import WantedRecord, read_note
from station.guide.options import AskedSigmas
from station.guide.planned_bench import bench_of
from station.guide.resumed_campaign import NO_ACCEPTED_STEPS, AcceptedSteps
from station.guide.sequential_campaign import SequentialCampaign
from station.results.planning.hand_times import hand_times
from station.results.planning.known_noise import noise_in_database, noise_of
from station.results.planning.wanted_by_limits import last_values, limits_named, wanted_by, wanted_by_name
from station.stream.connected_unit import Unit


def wanted_record(database: Database, unit: Unit, asked: AskedSigmas) -> tuple[WantedRecord, list[str]]:
    """Return what is asked of a unit's campaign, and what no campaign can do about some of it.

    Raises
    ------
    DataRefused
        If nothing is known of the limits, or they ask for nothing.
    """
    _, rows = limits_named(database, unit.model if asked.limits else None)
    by_limits, remarks = wanted_by(rows, last_values(database, unit.model, unit.serial))
    sigmas = wanted_by_name(asked.sigma).and_also(by_limits).sigma
    named = {name: float(one) for name, one in zip(NAMES, sigmas, strict=True) if np.isfinite(one)}
    if not named:
        found = f"limits of {unit.model} that define no standard uncertainty"
        raise DataRefused(
            "limits",
            None,
            found,
            "limits with a lower and an upper end",
            "state the standard uncertainty that you want: --sigma NAME=VALUE",
        )
    known = noise_of(asked.noise) if asked.noise else noise_in_database(database, unit.model, unit.serial)
    hands, _ = hand_times(database)
    record = WantedRecord(sigmas=named, placing_s=hands.placing, move_s=hands.move)
    if known is None:
        return record, remarks
    noise = known.noise
    return record.model_copy(
        update={
            "accel_white": tuple(noise.accel_white.tolist()), "gyro_white": tuple(noise.gyro_white.tolist()),
            "accel_scale": _counted(noise.accel_scale), "gyro_scale": _counted(noise.gyro_scale),
            "wander": noise.wander,
        }
    ), remarks  # fmt: skip


def sequel_of(
    folder: Path, site: SiteTable | None, care: ProcedureTable, fixture: Fixture,
    done: AcceptedSteps = NO_ACCEPTED_STEPS, *, counts: bool = True,
) -> SequentialCampaign | None:  # fmt: skip
    """Return what says how a folder's campaign goes on, None of one whose steps are fixed.

    ``counts`` says whether the unit counts.

    Raises
    ------
    DataRefused
        If the folder's note of what is wanted cannot be read.
    """
    record = read_note(folder, WantedRecord)
    if record is None or site is None:
        return None
    if unknown := sorted(record.sigmas.keys() - set(NAMES)):
        raise DataRefused(
            folder / NOTES[WantedRecord], None, f"a sigma of {unknown[0]}", "parameters of a solution"
        )
    return SequentialCampaign(bench_of(site, care, fixture), record, done.placements, counts=counts)


def limits_of(
    database: Database, unit: Unit, site: SiteTable | None, care: ProcedureTable, fixture: Fixture,
    done: AcceptedSteps = NO_ACCEPTED_STEPS, *, counts: bool = True,
) -> SequentialCampaign | None:  # fmt: skip
    """Return what says of a fixed plan how far what the unit's model limits is; None where nothing is limited.

    It reckons by what the campaign's own dwells scatter by: nobody waits for older ones.
    """
    try:
        _, rows = limits_named(database, unit.model)
    except DataRefused:
        return None
    sigmas = wanted_by(rows, last_values(database, unit.model, unit.serial))[0].sigma
    named = {name: float(one) for name, one in zip(NAMES, sigmas, strict=True) if np.isfinite(one)}
    if not named or site is None:
        return None
    hands = HandTimes()
    record = WantedRecord(sigmas=named, placing_s=hands.placing, move_s=hands.move)
    return SequentialCampaign(bench_of(site, care, fixture), record, done.placements, counts=counts, is_fixed=True)


def _counted(scale: FloatArray) -> tuple[float, ...] | None:
    return tuple(scale.tolist()) if np.all(np.isfinite(scale)) else None
