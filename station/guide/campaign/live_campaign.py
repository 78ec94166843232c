"""A campaign on a live device (reader, stream, guide, folder), or one that is complete and needs no device."""

from contextlib import ExitStack

from drivers.errors import DeadChannel, DriverError, LinkLost
from procedures.campaign.plan_steps import Turn
from station.files.campaign_folder.plan_file import WantedRecord, read_note
from station.guide.campaign.checklist import Checklist
from station.guide.campaign.folder_recorder import DiskSpace, disk_for
from station.guide.campaign.port_check import SampleRateWatch
from station.guide.checks.transfers import DEAD
from station.guide.options import CalibrationOptions
from station.guide.setup_view import PortCheck
from station.guide.stages.guide import Guide
from station.guide.stages.stage_context import StageContext
from station.guide.view import CalibrationView, OperatorCommand
from station.stream.connected_unit import Unit, UnitChanged
from station.stream.gnss_feed import GnssFeed
from station.stream.live.live_feed import LiveFeed, RestartableReader
from station.stream.recorder.accepted_step_writer import CampaignRecorder
from station.stream.stream_events import EventLog


class LiveCampaign:
    """One campaign being recorded; made by `begin` and `resume`, to be closed."""

    has_device = True

    def __init__(
        self, reader: RestartableReader, feed: LiveFeed, unit: Unit, guide: Guide, recorder: CampaignRecorder,
        options: CalibrationOptions, stack: ExitStack, gnss: GnssFeed | None = None,
    ) -> None:  # fmt: skip
        self._reader, self._feed, self._stack, self._is_patient = reader, feed, stack, options.is_patient
        self.unit, self.guide, self.recorder, self.folder = unit, guide, recorder, recorder.folder
        self.say, self.execute = guide.context.event_log.say, guide.execute
        self._rate_watch = SampleRateWatch(feed, guide.context.event_log, gnss)
        recorder.utc = None if gnss is None else gnss.utc
        recorder.pulse = feed.wire.pulse

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to record."""
        return self.guide.is_complete

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
        self.guide.show_newest(self._feed.newest())

    def view(self, base: CalibrationView) -> CalibrationView:
        """Return ``base`` with everything filled in."""
        unit = f"{self.unit.model} {self.unit.serial}"
        return self.guide.view(base.model_copy(update={"unit": unit, "folder": str(self.folder)}))

    def unit_check(self) -> PortCheck:
        """Return what a look at its port says of the unit."""
        imu, rate = self.recorder.tables.imu, 1 / self.unit.period
        unit = PortCheck(url=self._reader.reader.address.text, is_good=True, rate_hz=rate, output=imu.output)
        return unit.model_copy(update={"model": imu.model, "serial": imu.serial})

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


class FinishedCampaign:
    """Holds the folder of a complete campaign; to be closed. A step is done again on a `LiveCampaign` only."""

    is_complete, has_device = True, False

    def __init__(self, recorder: CampaignRecorder, checklist: Checklist, stack: ExitStack) -> None:
        self._recorder, self._checklist, self._stack = recorder, checklist, stack
        self.folder, self._event_log = recorder.folder, EventLog()
        self.say = self._event_log.say

    @property
    def disk(self) -> DiskSpace:
        """The room that its results need, and what there is."""
        return disk_for(self.folder, (), 0.0)

    def round(self) -> None:
        """Do nothing: nothing comes."""

    def execute(self, command: OperatorCommand) -> None:
        """Do nothing: what needs the device needs a `LiveCampaign`."""

    def view(self, base: CalibrationView) -> CalibrationView:
        """Return ``base`` with everything filled in."""
        imu = self._recorder.tables.imu
        return base.model_copy(
            update={
                "stage": "solving", "line": "all steps are recorded", "unit": f"{imu.model} {imu.serial}",
                "folder": str(self.folder), "steps": self._checklist.views(""), "can_redo": self._checklist.latest,
                "can_do_more": read_note(self.folder, WantedRecord) is not None,
                "events": self._event_log.events,
            }
        )  # fmt: skip

    def unit_check(self) -> None:
        """Say nothing of a unit: none is read."""

    def close(self) -> None:
        """Let the folder go; may be called twice."""
        self._stack.close()


GuidedCampaign = LiveCampaign | FinishedCampaign  # under way, or complete and without a device
