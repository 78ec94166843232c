"""A guide on a simulated device polled in memory, in device time: no process, no port, no waiting."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import ALL_CHANNELS
from procedures.campaign.campaign import Fixture
from procedures.campaign.plan_steps import Dwell, Step
from station.files.campaign_folder.plan_file import WantedRecord, read_no_moves, write_note
from station.guide.campaign.accepted_steps import NO_ACCEPTED_STEPS, AcceptedSteps, read_accepted_steps
from station.guide.campaign.checklist import Checklist
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.campaign.interrupted_campaigns import reopen
from station.guide.campaign.sequential_campaign import SequentialCampaign, targets_of
from station.guide.stages.guide import Guide
from station.guide.stages.stage_context import BenchFacts, StageContext
from station.guide.view import CalibrationView, OperatorCommand
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.recorder.accepted_step_writer import open_campaign
from tests.empty_database import empty_db
from tests.station.stream.live.bench_in_memory import SITE, Source

Watch = Callable[[CalibrationView], None]


def ignore(_: CalibrationView) -> None:
    pass


def plain_guide(source: Source, steps: Sequence[Step], recorder: FolderRecorder) -> tuple[LiveFeed, Guide]:
    """Return the feed of a device that is known by now, and a guide that asks nothing and knows no folder."""
    feed = open_feed(source)
    feed.identify()
    facts = BenchFacts(float(np.radians(SITE.latitude_deg)), 1e-3, 2e-4, Fixture(), asks=False)
    return feed, Guide(StageContext(feed, Checklist(steps), facts, recorder), warms_up=False)


class GuideRig:
    """A guide with everything around it, in a folder; ``hands`` moves the cube of the device."""

    def __init__(
        self,
        folder: Path,
        steps: Sequence[Step],
        truth: Truth | None = None,
        faults: Iterable[Fault] = (),
        *,
        warms_up: bool = False,
        asks: bool = True,
        bias_std: float | None = None,
        format: str = "counts",
        wanted: WantedRecord | None = None,
    ) -> None:
        self.folder = folder / "campaign"
        self.folder.mkdir()
        self.truth = Truth.example(1) if truth is None else truth
        self.source = Source(self.truth, faults, format)
        self.feed = open_feed(self.source)
        self.unit = self.feed.identify() if format == "counts" else self.feed.identify("FOG", "1")
        missing = ALL_CHANNELS - self.feed.stream.decoder.kind.channels
        assert not missing, f"a guide needs six channels, as `begin` does: {format} has no {sorted(missing)}"
        self.database = empty_db(folder / "station.db")
        self.recorder = open_campaign(self.folder, self.unit, SITE, self.database, output=self.feed.wire.output)
        self.facts = BenchFacts(
            float(np.radians(self.truth.latitude_deg)), 1e-3, 2e-4, Fixture(), bias_std=bias_std, asks=asks
        )
        if wanted is not None:
            write_note(self.folder, wanted)
        self.context = StageContext(
            self.feed, Checklist(steps), self.facts, FolderRecorder(self.recorder), targets=self._targets()
        )
        self.guide = Guide(self.context, warms_up=warms_up)
        self.seen: list[CalibrationView] = []
        self.reported: dict[int, str] = {}

    def resume(self) -> None:
        """Go on as after a kill: all that is known comes from the folder and the database."""
        self.recorder = reopen(self.folder, self.database)
        done, steps = read_accepted_steps(self.folder), self.context.checklist.steps
        checklist = Checklist(steps, self.recorder.accepted, done.seconds, read_no_moves(self.folder))
        recorder = FolderRecorder(self.recorder)
        self.context = StageContext(self.feed, checklist, self.facts, recorder, done, self._targets(done))
        self.guide = Guide(self.context, warms_up=False)
        self.reported.clear()

    def _targets(self, done: AcceptedSteps = NO_ACCEPTED_STEPS) -> SequentialCampaign | None:
        tables, fixture = self.recorder.tables, self.facts.fixture
        return targets_of(self.folder, self.database, self.unit, tables, fixture, done)

    def hands(self, command: str) -> None:
        answer = self.source.device.execute(command)
        assert answer.startswith("ok"), answer

    def execute(self, verb: str, **what: str) -> None:
        self.guide.execute(OperatorCommand.model_validate({"verb": verb, **what}))

    @property
    def view(self) -> CalibrationView:
        return self.guide.view(CalibrationView())

    @property
    def texts(self) -> list[str]:
        return [self.reported[number] for number in sorted(self.reported)]

    def run(
        self, until: Callable[[CalibrationView], bool], watch: Watch = ignore, seconds: float = 2000.0
    ) -> CalibrationView:
        """Let device time pass until a view shows what is waited for; fail after ``seconds`` of it."""
        end = self.source.device.imu.time + seconds
        while self.source.device.imu.time < end:
            self.feed.advance()
            for block in self.feed.ready():
                self.guide.take(block)
                view = self.view
                self.seen.append(view)
                self.reported |= {event.number: f"{event.sound}: {event.text}" for event in view.events}
                watch(view)
                if until(view):
                    return view
        raise AssertionError(f"not within {seconds} s: {self.view.line}; {self.view.hint}; {self.texts[-5:]}")

    def rest(self, seconds: float) -> CalibrationView:
        """Let device time pass."""
        end = self.source.device.imu.time + seconds
        return self.run(lambda _: self.source.device.imu.time >= end, seconds=seconds + 10)

    def done(self, count: int) -> Callable[[CalibrationView], bool]:
        return lambda view: view.done >= count


def dwells(*positions: int, seconds: float = 10.0) -> list[Step]:
    return [Dwell(position, seconds) for position in positions]
