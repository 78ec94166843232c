"""How, where and with what a campaign was measured, for its calibration to say; the unknown is left out.

A certificate is made from the stored calibration alone; whatever it needs and nobody can know later stands here.
"""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.campaigns import campaign, last_accepted, references
from fixtures_db.hash_chain import utc_text
from fixtures_db.schema import CampaignRow, SiteRow
from procedures.campaign.campaign import Campaign, clock_rate
from procedures.positions import ATTITUDES, POSITIONS
from procedures.units import UG_PER_G
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.files.campaign_folder.plan_file import UnitRecord, read_note
from station.results.verdict import JudgedLimit
from station.text import plural

NORMAL_GRAVITY = "normal gravity of WGS 84 at this latitude and height"


def circumstances(
    session: Session, folder: str, measured: Campaign, tables: CampaignTable, document: Mapping[str, Any]
) -> dict[str, Any]:
    """Return ``procedure``, ``site`` and ``references`` of a calibration; ``document`` is its solution/1.

    Raise `NotInDatabase` if the database does not know the campaign.
    """
    row, used = campaign(session, folder), references(session, folder)
    survey = next((one.get("source") for one in used if one["kind"] == "site"), None)
    return {
        "procedure": _procedure(row, measured, tables, document),
        "site": _site(session, row, measured, tables, survey),
        "references": used,
    }


def judged_values(judged: tuple[JudgedLimit, ...]) -> tuple[dict[str, Any], ...]:
    """Return what each limit was held against."""
    return tuple(
        {
            "parameter": one.limit.parameter,
            "verdict": one.word,
            **({} if one.parameter is None else {"value": one.parameter.value, "unit": one.parameter.unit}),
            **({} if one.parameter is None or one.parameter.std is None else {"std": one.parameter.std}),
        }
        for one in judged
    )


KEPT = ("effect", "confidence", "aliases")  # what a calibration keeps of a finding


def diagnosis_kept(diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a calibration keeps of a `diagnosis/2`: verdict, findings, what each could be instead."""
    findings = [{name: one[name] for name in KEPT} for one in diagnosis["findings"]]
    return {"verdict": diagnosis["verdict"], "findings": findings}


def procedure_name(measured: Campaign) -> str:
    """Return in words what was done."""
    positions = {dwell.position for dwell in measured.dwells}
    if positions == set(range(1, len(POSITIONS) + 1)):
        dwells = "twelve-position calibration on a level surface plate"
    elif not positions:
        dwells = "calibration"
    else:
        of = len(POSITIONS if max(positions) <= len(POSITIONS) else ATTITUDES)
        dwells = f"calibration from {len(positions)} of {of} positions on a level surface plate"
    repeats = len(measured.dwells) - len(positions)
    counted = (
        (repeats, "repeated position", ""),
        (len(measured.turns), "manual rotation", " of whole revolutions"),
        (len(measured.moves), "manual transfer", " between positions"),
        (len(measured.rests) + len(measured.sequences), "recording", " in free positions"),
    )
    also = [plural(count, noun) + more for count, noun, more in counted if count]
    return f"{dwells} with {' and '.join(also)}" if also else dwells


def _procedure(
    row: CampaignRow, measured: Campaign, tables: CampaignTable, document: Mapping[str, Any]
) -> dict[str, Any]:
    table = tables.procedure
    stated: dict[str, Any] = {
        "name": procedure_name(measured),
        "steps": list(dict.fromkeys(step.name for step in row.steps)),
        "started_utc": utc_text(row.started_utc),
        "ended_utc": utc_text(last_accepted(row)),
        "heading_std_deg": table.heading_std_deg,
        "closure_std_deg": table.closure_std_deg,
    }
    if (clock := clock_rate(measured)) is not None:
        stated["clock"] = {"rate_ppm": clock.ppm, "std_ppm": clock.std}
    lists = {"deviations": _deviations(row, tables, document)}
    lists |= {name: list(document.get(name, ())) for name in ("warnings", "not_observable")}
    return stated | {name: texts for name, texts in lists.items() if texts}


def _deviations(row: CampaignRow, tables: CampaignTable, document: Mapping[str, Any]) -> list[str]:
    table, stated = tables.procedure, list[str]()
    if (unit := read_note(Path(row.folder), UnitRecord)) is not None and not unit.serial_from_wire:
        stated.append("the serial number was typed in: the unit does not send one")
    if table.unsettled_gyro_deg_h or table.unsettled_accelerometer_g:
        gyro, accel = table.unsettled_gyro_deg_h or 0.0, (table.unsettled_accelerometer_g or 0.0) * UG_PER_G
        stated.append(
            f"warm-up was skipped: biases may drift by {gyro:.2g} deg/h and {accel:.2g} ug (standard uncertainty)"
        )
    if table.closure_widened_from_deg is not None:
        stated.append(
            f"the closure error of manual rotations was increased from {table.closure_widened_from_deg:.3g} to "
            f"{table.closure_std_deg:.3g} deg, because the rotations did not meet it"
        )
    stated += [
        f"position {dwell.position} was kept although the cube was tilted by "
        f"{np.degrees(np.linalg.norm(dwell.kept_seat_rad)):.2g} deg"
        for dwell in tables.dwell
        if dwell.kept_seat_rad is not None
    ]
    stated += [f"{step} was not used" for step in document.get("unused_steps", ())]
    times = Counter(step.name for step in row.steps)
    stated += [f"{name} was recorded {n} times, the last one is used" for name, n in times.items() if n > 1]
    return stated


def _site(
    session: Session, row: CampaignRow, measured: Campaign, tables: CampaignTable, survey: str | None
) -> dict[str, Any]:
    known = None if row.site_id is None else session.get(SiteRow, row.site_id)
    assert tables.site is not None  # of a campaign that was solved
    surveyed = None if known is None else known.height_m
    source = survey if tables.site.gravity_m_s2 is not None else NORMAL_GRAVITY
    return {
        **({} if row.site_id is None else {"id": row.site_id}),
        "latitude_deg": float(np.degrees(measured.site.latitude)),
        "height_m": tables.site.height_m if surveyed is None else surveyed,
        "gravity_m_s2": measured.site.gravity,
        "gravity_std_m_s2": measured.site.gravity_std,
        **({} if source is None else {"gravity_source": source}),
    }
