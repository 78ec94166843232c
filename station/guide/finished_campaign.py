"""A campaign whose steps are all accepted, resumed for its verdict: that needs no device."""

from contextlib import ExitStack
from pathlib import Path

from fixtures_db.database import Database
from station.files.campaign_folder.plan_file import WantedRecord, kept_plan, read_note
from station.files.campaign_setup import Setup
from station.guide.command import OperatorCommand
from station.guide.disk_space import DiskSpace, disk_for
from station.guide.folder_lock import folder_lock
from station.guide.interrupted_campaigns import reopen
from station.guide.live_campaign import LiveCampaign, usual_steps
from station.guide.step_checklist import Checklist
from station.guide.view import CalibrationView
from station.stream.recorder.accepted_step_writer import CampaignRecorder
from station.stream.stream_events import EventLog, Sound


class FinishedCampaign:
    """Holds the folder of a complete campaign; to be closed. A step is done again on a `LiveCampaign` only."""

    is_complete, has_device = True, False

    def __init__(self, recorder: CampaignRecorder, checklist: Checklist, stack: ExitStack) -> None:
        self._recorder, self._checklist, self._stack = recorder, checklist, stack
        self._event_log = EventLog()

    @property
    def folder(self) -> Path:
        """Where it was recorded."""
        return self._recorder.folder

    @property
    def disk(self) -> DiskSpace:
        """The room that its results need, and what there is."""
        return disk_for(self.folder, (), 0.0)

    def round(self) -> None:
        """Do nothing: nothing comes."""

    def obey(self, command: OperatorCommand) -> None:
        """Do nothing: what needs the device needs a `LiveCampaign`."""

    def say(self, sound: Sound, text: str) -> None:
        """Tell the operator."""
        self._event_log.say(sound, text)

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

    def as_checked(self) -> None:
        """Say nothing of a unit: none is read."""

    def close(self) -> None:
        """Let the folder go; may be called twice."""
        self._stack.close()


GuidedCampaign = LiveCampaign | FinishedCampaign  # under way, or complete and without a device


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
