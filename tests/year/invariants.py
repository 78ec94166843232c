"""What must hold of a campaign after it has ended, whatever went wrong in it."""

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from math import hypot, radians
from pathlib import Path
from typing import Any

import numpy as np

from fixtures_db.campaigns import known_campaign
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import history
from fixtures_db.verification import alterations
from procedures.arrays import IntArray
from procedures.positions import face_normal, face_of
from procedures.uncertainty.sources import UNEXPLAINED
from procedures.units import PPM_PER_ONE, UG_PER_G
from station.commands.verify import verify
from station.demo.comparison import compared, truth_values
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.mcap_files import read_step
from station.guide.view import Verdict
from station.results.certificate.issuing import copy_of
from station.results.parameters_by_name import parameters, shown, title_of
from station.stream.recorder.accepted_step_writer import step_of
from tests.year.campaign import Finding, YearCampaign
from tests.year.undetectable_tilts import MOST_SIGMAS, unreported_by_heading, unreported_by_size, unreported_values

ROW_UNITS = {"1": PPM_PER_ONE, "g": UG_PER_G}  # of what `compared` shows otherwise than it is stored
Sent = tuple[IntArray, list[float]]  # of a power-on: its counts (n, 6), what its clock was off by [s]


@dataclass(frozen=True, slots=True)
class Errors:
    """Stored values less truth, in their own sigmas, by parameter; ``excused``: why they prove nothing.

    ``unreported``: why some are not among them, as the program said itself (`tests.year.undetectable_tilts`).
    """

    sigmas: dict[str, float]
    excused: str
    unreported: str = ""


def look(campaign: YearCampaign) -> Errors:
    """Look at all that a campaign left; raise `Finding` for the first that must not be."""
    with campaign.machine.running(campaign.drawn.zone), redirect_stdout(StringIO()):
        for finding in _findings(campaign):
            raise Finding(finding)
        return _errors(campaign)


def _findings(campaign: YearCampaign) -> Iterator[str]:
    yield from _once(campaign)
    yield from _of_the_other(campaign)
    if not (campaign.folder / "campaign.toml").exists():
        return
    yield from _recorded(campaign)
    yield from _verified(campaign)
    verdict = campaign.tally.verdict
    if verdict is not None and verdict.stored_sha256:
        yield from _stored_as_shown(campaign, verdict)
        yield from _certified(campaign, verdict)


def _of_the_other(campaign: YearCampaign) -> Iterator[str]:
    """What another station stored meanwhile is whole, its own, and within its sigma."""
    if (other := campaign.other) is None or other.verdict is None:
        return
    with open_db(campaign.database_file) as database, database.read() as session:
        rows = history(session, other.truth.serial)
        row = known_campaign(session, str(other.folder))
        steps = 0 if row is None else len({step.name for step in row.steps if not step.superseded})
    if [each.sha256 for each in rows] != [other.verdict.stored_sha256] or steps != other.shown:
        yield f"the other station: {len(rows)} calibrations, {steps} steps of {other.shown}"
        return
    verify(other.folder, db=str(campaign.database_file))
    errors = compared(json.loads(rows[0].document), truth_values(other.truth, is_certified=True))
    if far := {one.title: round(one.sigmas, 1) for one in errors if abs(one.sigmas) > MOST_SIGMAS}:
        yield f"the other station, beyond {MOST_SIGMAS:g} sigma: {far}"


def _once(campaign: YearCampaign) -> Iterator[str]:
    """What was said to be accepted is in the database, each recording once, one of each step in force."""
    with open_db(campaign.database_file) as database, database.read() as session:
        row = known_campaign(session, str(campaign.folder))
        steps = [] if row is None else [(step.name, step.file, step.superseded) for step in row.steps]
    tally, there = campaign.tally.shown, Counter(name for name, _, _ in steps)
    if lost := tally - there:
        yield f"accepted and not in the database: {dict(lost)}"
    if (more := there - tally).total() > campaign.tally.kills:
        yield f"in the database and never said to be accepted: {dict(more)}"
    files = Counter(file for _, file, _ in steps)
    if twice := [file for file, count in files.items() if count > 1]:
        yield f"accepted twice: {twice}"
    in_force = Counter(name for name, _, superseded in steps if not superseded)
    if wrong := {name for name in there if in_force[name] != 1}:
        yield f"not one recording in force: {sorted(wrong)}"


def _recorded(campaign: YearCampaign) -> Iterator[str]:
    """Every recorded sample is one that the unit put out, in its order, and on the face that is named."""
    tables = read_campaign_toml(campaign.folder)[0]
    sent = [(power.counts(), power.clock_off) for power in campaign.machine.bench.power_ons]
    for table in tables.steps():
        step = step_of(table)
        contents = read_step(campaign.folder / table.file)
        assert contents.gyro is not None
        assert contents.accel is not None
        counts = np.hstack((contents.gyro, contents.accel)).astype(np.int64)
        period = campaign.truth.sample_period_s
        if not _found(sent, counts, contents.device_ns, period):
            yield f"{table.file}: samples that the unit did not put out so"
        position = getattr(step, "position", 0)
        if position and not _is_up(counts[:, 3:].mean(axis=0), position, campaign):
            yield f"{table.file}: accepted as position {position} with another face up"


def _found(power_ons: list[Sent], counts: Any, device_ns: Any, period: float) -> bool:
    """Say whether a power-on put out just these rows in this order; its clock may be set back in between."""
    for sent, clock_off in (each for each in power_ons if len(each[0])):
        same, index = [], []
        for off in clock_off:
            at = np.round((device_ns * 1e-9 + off) / period).astype(np.int64) - 1
            is_there = (at >= 0) & (at < len(sent))
            same.append(is_there & (sent[np.clip(at, 0, len(sent) - 1)] == counts).all(axis=1))
            index.append(at)
        if any(_goes_on(np.array(same), np.array(index), off, 0) for off in range(len(same))):
            return True
    return False


def _goes_on(same: Any, index: Any, off: int, first: int) -> bool:
    """Say whether all rows from ``first`` on are there, at this offset of the clock or, further on, at later ones.

    ``same`` (m, n) says of each offset and row whether it is, ``index`` (m, n) which sample of the unit.
    """
    wrong = np.flatnonzero(~same[off, first:])
    end = first + int(wrong[0]) if len(wrong) else same.shape[1]
    if (np.diff(index[off, first:end]) <= 0).any() or (end == first and first > 0):
        return False
    return end == same.shape[1] or any(
        _goes_on(same, index, later, end)
        for later in range(off + 1, len(same))
        if end == 0 or index[later, end] > index[off, end - 1]
    )


def _is_up(accel: Any, position: int, campaign: YearCampaign) -> bool:
    """Say whether mean accelerometer counts (3,) belong to a position's face."""
    per_g = campaign.truth.accel_k * campaign.truth.sample_period_s
    return bool((accel / per_g) @ face_normal(face_of(position)) > 0.9)


def _verified(campaign: YearCampaign) -> Iterator[str]:
    """``station verify`` finds nothing altered."""
    with open_db(campaign.database_file) as database, database.read() as session:
        for fault in alterations(session):
            yield f"verify: {fault}"
    if campaign.tally.shown:
        verify(campaign.folder, db=str(campaign.database_file))


def _stored_as_shown(campaign: YearCampaign, verdict: Verdict) -> Iterator[str]:
    document = _stored(campaign)
    if not (campaign.folder / "calibration.json").exists() and not campaign.tally.kills:
        yield "calibration.json is not there"
    found = parameters(document)
    titles = {title_of(name): one for name, one in found.items()}
    for row in verdict.rows:
        if (one := titles.get(row.name)) is not None and row.value != "not measured":
            if (row.value, row.unit) != shown(one):
                yield f"{row.name}: shown {row.value} {row.unit}, stored {shown(one)}"
    for name in ("verdict", "status"):
        if document[name] != {"verdict": verdict.word, "status": verdict.status}[name]:
            yield f"{name}: stored {document[name]}, shown {verdict.word} {verdict.status}"


def _stored(campaign: YearCampaign) -> Mapping[str, Any]:
    with open_db(campaign.database_file) as database, database.read() as session:
        rows = history(session, campaign.truth.serial)
    if len(rows) != 1:
        raise Finding(f"{len(rows)} stored calibrations, expected one")
    document: Mapping[str, Any] = json.loads(rows[0].document)
    return document


def _certified(campaign: YearCampaign, verdict: Verdict) -> Iterator[str]:
    """A certificate is there where all that it needs was there, and is read back as it was issued."""
    reported, what = campaign.tally.certificate, campaign.drawn.references
    if reported.startswith("lacks "):
        if campaign.is_usual and what != "no operator" and "confirmation" not in reported:
            yield f"no certificate: it {reported}"
        return
    with open_db(campaign.database_file) as database:
        row = copy_of(database, verdict.stored_sha256)
    file = Path(campaign.folder.parent / "certificate.html")
    file.write_bytes(row.html.encode())
    verify(file, db=str(campaign.database_file))
    if campaign.truth.serial not in row.html:
        yield "a certificate of another unit"


def _errors(campaign: YearCampaign) -> Errors:
    verdict = campaign.tally.verdict
    if verdict is None or not verdict.stored_sha256:
        return Errors({}, "nothing stored")
    document = _stored(campaign)
    rows = compared(document, _truth(campaign, document))
    unexplained = _unexplained(document)
    sigmas = {row.title: row.sigmas * row.std / hypot(row.std, unexplained.get(row.title, 0.0)) for row in rows}
    unreported = unreported_by_heading(campaign.tally.turned, radians(campaign.truth.heading_std_deg))
    unreported |= unreported_values(verdict.warnings, campaign.tally.tilts)
    solution = json.loads((campaign.folder / "solution.json").read_text())
    unreported |= unreported_by_size(solution.get("unnoticed_leans", ()), campaign.tally.tilts, sigmas)
    excused = "the operator answered wrongly" if campaign.person.lies else verdict.doubt
    counted = {title: one for title, one in sigmas.items() if title not in unreported}
    return Errors(counted, excused, "; ".join(dict.fromkeys(unreported.values())))


def _unexplained(document: Mapping[str, Any]) -> dict[str, float]:
    """Return the scatter that the uncertainty holds for what no effect explains, by title, in its row's unit."""
    found = dict[str, float]()
    for each in document["uncertainty"]["parameters"]:
        title = title_of(each["name"])
        std = sum(part["std"] for part in each["contributions"] if part["source"] == UNEXPLAINED)
        found[title] = std * ROW_UNITS.get(each["unit"], 1.0)
    return found


def _truth(campaign: YearCampaign, document: Mapping[str, Any]) -> dict[str, float]:
    """Return the truth by name, in the unit's seconds, and in true ones where the rate of its clock was found.

    A unit counts by its own clock, which goes ``ppm`` fast: so much more in a second of UTC.
    """
    values = truth_values(campaign.truth, is_certified=True)
    found = [each["effect"] for each in document["diagnosis"]["findings"] if each["confidence"] != "possible"]
    faster = 1 + 1e-6 * campaign.drawn.ppm if "clock.rate" in found else 1.0
    of_time = "accelerometer.scale_factor"
    return {name: value * (faster if name.startswith(of_time) else 1.0) for name, value in values.items()}
