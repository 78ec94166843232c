"""A database in which there is something of everything: units, campaigns in every state, limits, certificates."""

from dataclasses import replace
from datetime import timedelta

from sqlalchemy.orm import Session

from fixtures_db.campaigns import accept_step, remove_campaign, set_state, start_campaign
from fixtures_db.imu_models import Limit, add_effect, set_limits, withdraw_effect
from fixtures_db.issued_certificates import next_number, record_issue, record_signed
from fixtures_db.schema import CalibrationRow, IssuedCertificateRow
from fixtures_db.stored_calibrations import accept_calibration
from tests.fixtures_db.factory import LATER, NOON, facts, fill_fixtures, solution

WIDE = (Limit("accelerometer.bias.x", -2e-3, 2e-3, "g"), Limit("accelerometer.bias.y", None, 3e-3, "g"))
JUDGED = tuple(
    {"parameter": f"accelerometer.bias.{axis}", "verdict": "PASS", "value": value, "unit": "g", "std": 8e-8}
    for axis, value in (("x", 1e-3), ("y", 2e-3))
)


def fill(session: Session, *, digital: bool = True) -> None:
    """Add it: limits set twice, steps done again, a campaign cancelled, an effect withdrawn.

    ``digital`` certificates have an XML, which databases before version 9 cannot hold.
    """
    fill_fixtures(session)
    set_limits(session, "FOG-3", WIDE[:1])
    set_limits(session, "FOG-3", WIDE)
    set_limits(session, "FOG-5", WIDE[1:])
    for name in ("pull", "push"):
        add_effect(session, name, f"title = '{name}'", "FOG-3", None)
    withdraw_effect(session, "push", "FOG-3", None)
    for folder, serial in (("c1", "S1"), ("c2", "S2"), ("c3", "S3"), ("c4", "S1")):
        record(session, folder, serial)
    first = _accept(session, "c1", "S1")
    _accept(session, "c2", "S2")
    set_state(session, "c3", "recorded")
    remove_campaign(session, "c4")
    for replaces in (None, "EX-2026-0001"):
        _issue(session, first, replaces, digital=digital)
    for kind in ("xml", "pdf"):
        record_signed(session, "EX-2026-0001", kind, f"{kind[0].encode().hex()}" * 32, "cd" * 32)
    record(session, "c5", "S3")


def record(session: Session, folder: str, serial: str) -> None:
    """Add a campaign of three accepted steps, of which one was done again."""
    start_campaign(session, folder, model="FOG-3", serial=serial, started_utc=NOON, cube_id="CUBE-7",
                   slab_id="SLAB-1", site_id="SITE-1", effects_sha256=("ef" * 32,))  # fmt: skip
    for minutes, name in enumerate(("dwell_01", "dwell_02", "dwell_01")):
        moment = NOON + timedelta(minutes=minutes)
        sha256 = f"{minutes + 1}{serial[1]}" * 32
        accept_step(session, folder, name=name, file=f"{name}_{minutes}", sha256=sha256, accepted_utc=moment)


def _accept(session: Session, folder: str, serial: str) -> CalibrationRow:
    reported = replace(facts(serial), verdict="PASS", limits=WIDE, judged=JUDGED)
    row = accept_calibration(session, solution(), reported, campaign_folder=folder)
    set_state(session, folder, "accepted")
    return row


def _issue(session: Session, of: CalibrationRow, replaces: str | None, *, digital: bool) -> None:
    number = next_number(session, "EX-", 2026)
    record_issue(session, IssuedCertificateRow(
        number=number, replaces=replaces, calibration_sha256=of.sha256, issued_utc=LATER, laboratory="{}",
        html=f"<html>{number}</html>", dcc=f"<dcc>{number}</dcc>" if digital else None,
    ))  # fmt: skip
