"""How a guided campaign begins, and how an interrupted one is resumed."""

import time
from contextlib import ExitStack
from datetime import datetime
from functools import partial
from pathlib import Path

import numpy as np

from drivers.wire import ALL_CHANNELS
from fixtures_db.database import Database
from procedures.campaign.campaign import Fixture
from procedures.campaign.plan_steps import Step, as_repeats, dwell_steps, turn_steps
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.atomic_file import new_folder
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.files.campaign_folder.plan_file import (
    UnitRecord,
    keep_plan,
    kept_plan,
    read_no_moves,
    read_note,
    write_note,
)
from station.files.campaign_setup import Setup
from station.guide.campaign.accepted_steps import AcceptedSteps, after_pause, read_accepted_steps
from station.guide.campaign.campaign_tables import copy_effects, cube_fixture, procedure_table, site_table
from station.guide.campaign.checklist import Checklist
from station.guide.campaign.folder_lock import folder_lock
from station.guide.campaign.folder_recorder import WARM_UP_S, FolderRecorder, refuse_full
from station.guide.campaign.interrupted_campaigns import clear_unfinished, has_row, is_unfinished, reopen
from station.guide.campaign.live_campaign import FinishedCampaign, LiveCampaign
from station.guide.campaign.port_check import RECORD_INSTEAD, reopen_receiver, setup_with_site, site_text, utc_now
from station.guide.campaign.sequential_campaign import target_record, targets_of
from station.guide.options import CalibrationOptions, from_anywhere
from station.guide.stages.guide import Guide
from station.guide.stages.stage_context import POWER_CYCLED, BenchFacts, StageContext
from station.stream.connected_unit import Unit
from station.stream.gnss_feed import open_gnss
from station.stream.live.live_feed import LiveFeed, RestartableReader, open_feed
from station.stream.recorder.accepted_step_writer import TOML, CampaignRecorder, open_campaign

TURN_REST_S = 5.0


def begin(setup: Setup, database: Database, options: CalibrationOptions) -> LiveCampaign:
    """Begin a new campaign.

    Raises
    ------
    DriverError, CannotWrite, NotInDatabase, DataRefused
        What port, disk, database or set-up refuse; nothing is left behind.
    """
    if setup.latitude_deg is None and not setup.gnss:
        raise DataRefused("set-up", None, "no latitude", "the latitude of the surface plate in deg", "enter it")
    setup = from_anywhere(setup)
    steps = tuple(options.steps) or usual_steps(setup)
    fixture, table = cube_fixture(database, setup.cube or None, options.imu_axes)
    with ExitStack() as stack:
        wanted = Path(setup.folder) if setup.folder else options.root / f"{datetime.now():%Y-%m-%d_%H%M%S}"
        is_free = partial(is_unfinished, has_row=has_row(database, wanted))
        folder = stack.enter_context(new_folder(wanted, TOML, is_free))
        stack.enter_context(folder_lock(folder))
        clear_unfinished(folder)
        reader, feed = _opened(setup.url, folder, stack)
        gnss = stack.enter_context(open_gnss(setup.gnss, folder)) if setup.gnss else None
        unit = feed.identify(setup.model or None, setup.serial or None)
        if missing := sorted(ALL_CHANNELS - feed.stream.decoder.kind.channels):
            found = f"{feed.wire.name} without {', '.join(missing)}"
            raise DataRefused(
                feed.address.name, None, found, "an IMU with six channels", RECORD_INSTEAD, ErrorCode.CHANNELS
            )
        refuse_full(folder, steps, 1 / unit.period, WARM_UP_S if options.warms_up else 0.0)
        given, setup = setup, setup if gnss is None else setup_with_site(setup, gnss, folder)
        write_note(folder, setup)
        write_note(folder, _record(feed, unit))
        remarks = list[str]()  # what no campaign can do about the targets
        if options.wanted is None:
            keep_plan(folder, steps)
        else:
            record, remarks = target_record(database, unit, options.wanted)
            write_note(folder, record)
        recorder = open_campaign(
            folder, unit, site_table(setup), database, output=feed.wire.output, fixture=table,
            procedure=procedure_table(setup), effects=copy_effects(database, unit.model, unit.serial, folder),
            cube_id=setup.cube or None, slab_id=setup.slab or None,
            started_utc=None if gnss is None else utc_now(gnss),
        )  # fmt: skip
        facts = _facts(recorder.tables, fixture, setup, options)
        targets = targets_of(folder, database, unit, recorder.tables, fixture)
        context = StageContext(feed, Checklist(steps), facts, FolderRecorder(recorder), targets=targets)
        guide = Guide(context, warms_up=options.warms_up)
        for remark in [*remarks, *([] if gnss is None else [site_text(given, gnss)])]:
            context.event_log.say("", remark)
        return LiveCampaign(reader, feed, unit, guide, recorder, options, stack.pop_all(), gnss)
    raise AssertionError("unreachable")


def resume(folder: Path, database: Database, options: CalibrationOptions) -> LiveCampaign:
    """Resume an unfinished campaign, on the same unit and, unless the options name another, the same port.

    Raises
    ------
    UnitChanged
        If another unit is connected.
    DriverError, CannotWrite, NotInDatabase, DataRefused
        What port, disk, database or folder refuse.
    """
    setup = read_note(folder, Setup) or Setup()
    with ExitStack() as stack:
        stack.enter_context(folder_lock(folder))
        recorder = reopen(folder, database)
        steps = kept_plan(folder) or usual_steps(setup)
        reader, feed = _opened(options.setup.url or setup.url, folder, stack)
        gnss, missed = reopen_receiver(stack, setup, folder)
        imu = recorder.tables.imu
        unit = feed.identify(imu.model, imu.serial, has_begun=True)
        fixture, _ = cube_fixture(database, recorder.tables.fixture.id, recorder.tables.fixture.imu_axes)
        recorded = read_accepted_steps(folder) if recorder.accepted else AcceptedSteps()
        done = _after_power_cycle(recorded, recorder, feed)
        checklist = Checklist(steps, recorder.accepted, done.seconds, read_no_moves(folder))
        refuse_full(folder, checklist.open_steps, 1 / unit.period, WARM_UP_S if options.warms_up else 0.0)
        facts = _facts(recorder.tables, fixture, setup, options)
        targets = targets_of(folder, database, unit, recorder.tables, fixture, recorded)
        context = StageContext(feed, checklist, facts, FolderRecorder(recorder), done, targets)
        record = read_note(folder, UnitRecord)
        unsure = record if record is not None and not record.serial_from_wire else None
        guide = Guide(context, warms_up=options.warms_up, unsure=unsure)
        for trouble in (POWER_CYCLED if done.turn_on > recorded.turn_on else "", missed):
            if trouble:
                context.event_log.say("rejected", trouble)
        return LiveCampaign(reader, feed, unit, guide, recorder, options, stack.pop_all(), gnss)
    raise AssertionError("unreachable")


def _opened(url: str, folder: Path, stack: ExitStack) -> tuple[RestartableReader, LiveFeed]:
    reader = RestartableReader(url, folder)
    stack.callback(reader.close)
    reader.feed = open_feed(reader.reader)
    return reader, reader.feed


def _after_power_cycle(done: AcceptedSteps, recorder: CampaignRecorder, feed: LiveFeed) -> AcceptedSteps:
    """Return what the steps so far leave, the unit perhaps switched off and on since the last of them."""
    files = [recorder.folder / table.file for table in recorder.tables.steps()]
    if not files or not feed.gives_time or feed.stamp is None:
        return done
    return after_pause(done, feed.stamp[1], time.time() - max(file.stat().st_mtime for file in files))


def usual_steps(setup: Setup) -> tuple[Step, ...]:
    """Return twelve positions, six turns, the first position again; no dwell length yet is taken for 100 s."""
    dwells = dwell_steps(setup.dwell_s or 100.0)
    again = dwells[:1] * setup.repeats
    return as_repeats((*dwells, *turn_steps(setup.revolutions, TURN_REST_S), *again))


def _record(feed: LiveFeed, unit: Unit) -> UnitRecord:
    identity = feed.stream.decoder.identity
    from_wire = bool(identity and identity.serial)
    return UnitRecord(model=unit.model, serial=unit.serial, serial_from_wire=from_wire, period=unit.period)


def _facts(tables: CampaignTable, fixture: Fixture, setup: Setup, options: CalibrationOptions) -> BenchFacts:
    care = tables.procedure
    assert tables.site is not None  # of a guided campaign
    return BenchFacts(
        float(np.radians(tables.site.latitude_deg)), float(np.radians(care.heading_std_deg)),
        float(np.radians(care.closure_std_deg)), fixture,
        None if setup.dwell_s or setup.bias_ug is None else setup.bias_ug * 1e-6, options.asks,
    )  # fmt: skip


def finished(folder: Path, database: Database) -> FinishedCampaign | None:
    """Return the campaign in ``folder`` if all of its steps are accepted, else None.

    Raises
    ------
    CannotWrite, NotInDatabase, CampaignInUse, DataRefused
        What folder or database refuse.
    """
    with ExitStack() as stack:
        stack.enter_context(folder_lock(folder))
        recorder = reopen(folder, database)
        steps = kept_plan(folder) or usual_steps(read_note(folder, Setup) or Setup())
        checklist = Checklist(steps, recorder.accepted)
        if checklist.wanted is not None:
            return None
        return FinishedCampaign(recorder, checklist, stack.pop_all())
    raise AssertionError("unreachable")
