"""A campaign on a live device: the reader, the stream, the guide, and the folder that everything goes to."""

import time
from contextlib import ExitStack
from datetime import datetime
from functools import partial
from pathlib import Path

import numpy as np

from drivers.errors import DeadChannel, DriverError, LinkLost
from drivers.wire import ALL_CHANNELS
from fixtures_db.database import Database
from procedures.campaign.campaign import Fixture
from procedures.campaign.plan_steps import Step, Turn, as_repeats, dwell_steps, turn_steps
from procedures.error_codes import ErrorCode
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
from station.guide.asked_sigmas import limits_of, sequel_of, wanted_record
from station.guide.campaign_tables import cube_fixture, procedure_table, site_table
from station.guide.command import OperatorCommand
from station.guide.copied_effects import copy_effects
from station.guide.disk_space import WARM_UP_S, DiskSpace, disk_for, refuse_full
from station.guide.folder_lock import folder_lock
from station.guide.folder_recorder import FolderRecorder
from station.guide.gnss_in_campaign import SampleRateWatch, reopened, said_of_site, sited, utc_now
from station.guide.guide import Guide
from station.guide.interrupted_campaigns import reopen
from station.guide.last_setup import from_anywhere
from station.guide.move_chain import DEAD
from station.guide.options import CalibrationOptions
from station.guide.port_check import RECORD_INSTEAD
from station.guide.resumed_campaign import AcceptedSteps, after_pause, read_accepted_steps
from station.guide.setup_view import PortCheck
from station.guide.stage_context import POWER_CYCLED, BenchFacts, StageContext
from station.guide.step_checklist import Checklist
from station.guide.unfinished_beginning import clear_unfinished, has_row, is_unfinished
from station.guide.view import CalibrationView
from station.stream.connected_unit import Unit, UnitChanged
from station.stream.gnss_feed import GnssFeed, open_gnss
from station.stream.live.live_feed import LiveFeed, RestartableReader, open_feed
from station.stream.recorder.accepted_step_writer import TOML, CampaignRecorder, open_campaign
from station.stream.stream_events import Sound

TURN_REST_S = 5.0


class LiveCampaign:
    """One campaign being recorded; made by `begin` and `resume`, to be closed."""

    has_device = True

    def __init__(
        self, reader: RestartableReader, feed: LiveFeed, unit: Unit, guide: Guide, recorder: CampaignRecorder,
        options: CalibrationOptions, stack: ExitStack, gnss: GnssFeed | None = None,
    ) -> None:  # fmt: skip
        self._reader, self._feed, self._stack, self._is_patient = reader, feed, stack, options.is_patient
        self.unit, self.guide, self.recorder = unit, guide, recorder
        self._rate_watch = SampleRateWatch(feed, guide.context.event_log, gnss)
        recorder.utc = None if gnss is None else gnss.utc
        recorder.pulse = feed.wire.pulse

    @property
    def folder(self) -> Path:
        """Where it is recorded."""
        return self.recorder.folder

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to record."""
        return self.guide.is_complete

    def say(self, sound: Sound, text: str) -> None:
        """Tell the operator."""
        self.guide.context.event_log.say(sound, text)

    def round(self) -> None:
        """Take what has come, waiting for it a moment.

        Raises
        ------
        CannotWrite
            If the disk refuses; what was accepted before is whole.
        DriverError
            What is wrong with the stream, if this campaign does not wait for it to come back.
        DataRefused
            If GNSS time, else this machine's, shows that the device's rate is not the one it declares.
        """
        self._rate_watch.round()
        try:
            self._feed.advance()
            if self._feed.lost:
                raise LinkLost(self._feed.address.name, self._feed.lost)
            refuse_dead(self._feed, self.guide.context)
        except DriverError as error:
            if not self._is_patient:
                raise
            self.guide.stream_failed(error)
            if isinstance(error, UnitChanged):
                self._feed.reset()
            else:
                self._reader.restart()
            return
        self.guide.stream_is_back()
        for block in self._feed.ready():
            self.guide.take(block)
        self.guide.glance(self._feed.newest())

    def view(self, base: CalibrationView) -> CalibrationView:
        """Return ``base`` with everything filled in."""
        unit = f"{self.unit.model} {self.unit.serial}"
        return self.guide.view(base.model_copy(update={"unit": unit, "folder": str(self.folder)}))

    def as_checked(self) -> PortCheck:
        """Return what a look at its port says of the unit."""
        imu, rate = self.recorder.tables.imu, 1 / self.unit.period
        unit = PortCheck(url=self._reader.reader.address.text, is_good=True, rate_hz=rate, output=imu.output)
        return unit.model_copy(update={"model": imu.model, "serial": imu.serial})

    def obey(self, command: OperatorCommand) -> None:
        """Do as the operator says."""
        self.guide.obey(command)

    @property
    def disk(self) -> DiskSpace:
        """The room that the open steps need, and what there is."""
        return disk_for(self.folder, self.guide.context.checklist.open_steps, 1 / self.unit.period, 0.0)

    def close(self) -> None:
        """Let the device and the folder go; may be called twice."""
        self._reader.close()
        self._stack.close()


def refuse_dead(feed: LiveFeed, context: StageContext) -> None:
    """Raise `DeadChannel` for one that the open steps need: turns need gyroscopes, all need accelerometers.

    Nothing of what came is used, and no move leads over it.
    """
    silent = feed.silent
    has_turns = any(isinstance(step, Turn) for step in context.checklist.open_steps)
    if silent and (has_turns or "accelerometer" in silent):
        context.chain.broken(DEAD)
        for block in feed.ready():
            feed.buffer.forget_before(block.first)
        raise DeadChannel(feed.address.name, silent)


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
        given, setup = setup, setup if gnss is None else sited(setup, gnss, folder)
        write_note(folder, setup)
        write_note(folder, _record(feed, unit))
        remarks = _keep_wanted(folder, database, unit, options)
        if options.wanted is None:
            keep_plan(folder, steps)
        recorder = open_campaign(
            folder, unit, site_table(setup), database, output=feed.wire.output, fixture=table,
            procedure=procedure_table(setup), effects=copy_effects(database, unit.model, unit.serial, folder),
            cube_id=setup.cube or None, slab_id=setup.slab or None,
            started_utc=None if gnss is None else utc_now(gnss),
        )  # fmt: skip
        facts, tables = _facts(recorder.tables, fixture, setup, options), recorder.tables
        counts = tables.imu.output != "rate"
        sequel = sequel_of(folder, tables.site, tables.procedure, fixture, counts=counts)
        limits = limits_of(database, unit, tables.site, tables.procedure, fixture, counts=counts)
        context = StageContext(
            feed, Checklist(steps), facts, FolderRecorder(recorder), sequel=sequel, limits=limits
        )
        guide = Guide(context, warms_up=options.warms_up)
        for remark in remarks:
            context.event_log.say("", remark)
        if gnss is not None:
            context.event_log.say("", said_of_site(given, gnss))
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
        gnss, missed = reopened(stack, setup, folder)
        imu = recorder.tables.imu
        unit = feed.identify(imu.model, imu.serial, has_begun=True)
        fixture, _ = cube_fixture(database, recorder.tables.fixture.id, recorder.tables.fixture.imu_axes)
        recorded = read_accepted_steps(folder) if recorder.accepted else AcceptedSteps()
        done = _as_it_runs(recorded, recorder, feed)
        checklist = Checklist(steps, recorder.accepted, done.seconds, read_no_moves(folder))
        refuse_full(folder, checklist.open_steps, 1 / unit.period, WARM_UP_S if options.warms_up else 0.0)
        facts = _facts(recorder.tables, fixture, setup, options)
        counts = imu.output != "rate"
        sequel = sequel_of(
            folder, recorder.tables.site, recorder.tables.procedure, fixture, recorded, counts=counts
        )
        of_bench = recorder.tables.site, recorder.tables.procedure, fixture
        limits = limits_of(database, unit, *of_bench, recorded, counts=counts)
        context = StageContext(feed, checklist, facts, FolderRecorder(recorder), done, sequel, limits)
        record = read_note(folder, UnitRecord)
        unsure = record if record is not None and not record.serial_from_wire else None
        guide = Guide(context, warms_up=options.warms_up, unsure=unsure)
        if done.turn_on > recorded.turn_on:
            context.event_log.say("rejected", POWER_CYCLED)
        if missed:
            context.event_log.say("rejected", missed)
        return LiveCampaign(reader, feed, unit, guide, recorder, options, stack.pop_all(), gnss)
    raise AssertionError("unreachable")


def _keep_wanted(folder: Path, database: Database, unit: Unit, options: CalibrationOptions) -> list[str]:
    """Keep what the campaign is to go on for, if its steps are not fixed; return what no campaign can do."""
    if options.wanted is None:
        return []
    record, remarks = wanted_record(database, unit, options.wanted)
    write_note(folder, record)
    return remarks


def _opened(url: str, folder: Path, stack: ExitStack) -> tuple[RestartableReader, LiveFeed]:
    reader = RestartableReader(url, folder)
    stack.callback(reader.close)
    reader.feed = open_feed(reader.reader)
    return reader, reader.feed


def _as_it_runs(done: AcceptedSteps, recorder: CampaignRecorder, feed: LiveFeed) -> AcceptedSteps:
    """Return what the steps so far leave, the unit perhaps switched off and on since the last of them."""
    files = [recorder.folder / table.file for table in recorder.tables.steps()]
    if not files or not feed.tells_time or feed.stamp is None:
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
