"""Another station on the same database: it tries what the first has taken, and has a campaign of its own."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.schema import CubeRow, SlabRow
from procedures.campaign.plan_steps import Dwell
from station.demo.example_bench import add_example
from station.files.campaign_setup import Setup
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions
from station.guide.view import ENDED_STAGES, OperatorCommand, Verdict
from tests.year.bench import Bench
from tests.year.findings import Finding, expect
from tests.year.machine import Machine
from tests.year.person import Manner, Person

OTHER_ADDRESS = "serial:///dev/ttyOTHER?format=counts"
UNITS = 1000  # of other stations from here on
POSITIONS = (1, 2, 3, 5, 7, 9, 11)
LONGEST_S = 3000.0  # of its campaign


def writes_concurrently(database_file: Path, number: int) -> None:
    """Write a slab and a cube, which no campaign uses, to the same database."""
    with open_db(database_file) as database, database.write() as session:
        session.add(SlabRow(id=f"OTHER-{number}"))
        session.add(CubeRow(id=f"OTHER-{number}", side_mm=100.0))


def tries_what_is_taken(database_file: Path, machine: Machine, setup: Setup, folder: Path) -> None:
    """Try to resume a campaign that is under way in ``folder``, and to begin one on its port; raise `Finding`."""
    elsewhere = machine.root / "elsewhere"
    with open_db(database_file) as database:
        other = CalibrationEngine(database, CalibrationOptions(machine.root), lambda _: None)
        assert other.view.start is not None
        states = [one.state for one in other.view.start.unfinished if one.folder == str(folder)]
        expect(states == ["in use"], f"a campaign under way is offered to another station as {states}")
        other.execute(OperatorCommand(verb="resume", folder=str(folder)))
        refused = [other.view.start and other.view.start.refused]
        other.execute(OperatorCommand(verb="begin", setup=setup.model_copy(update={"folder": str(elsewhere)})))
        refused.append(other.view.start and other.view.start.refused)
        other.close()
    machine.say(f"another station is refused: {refused}")
    expect(all(refused), f"another station may do what this one does: {refused}")
    expect(not elsewhere.exists(), "a campaign that could not begin left a folder")


class OtherStation:
    """A whole campaign on a unit of its own, begun and stored on the same database while the first one runs.

    Its disk is its own: what is full or dead of the first's is not.
    """

    def __init__(self, first: Machine, database_file: Path, unit: int) -> None:
        self._first, self._file, self.unit = first, database_file, UNITS + unit
        self.truth = replace(Truth.example(self.unit), sample_period_s=0.05)
        self.machine = first.next_to(OTHER_ADDRESS)
        self.machine.bench = Bench(first.clock, self.truth, self.unit, 10.0)
        self.person = Person(self.machine, Manner(), np.random.default_rng(self.unit), OTHER_ADDRESS)
        self.verdict: Verdict | None
        self.folder, self.verdict, self.shown = self.machine.root / "other", None, 0
        with first.disk.aside(), open_db(database_file) as database, database.write() as session:
            self._example = add_example(session, self.unit)
        self._begin()

    def _begin(self) -> None:
        truth = self.truth
        setup = Setup(
            url=OTHER_ADDRESS, folder=str(self.folder), dwell_s=6.0, revolutions=1, repeats=0,
            cube=self._example.cube, slab=self._example.slab, latitude_deg=truth.latitude_deg,
            longitude_deg=truth.longitude_deg, gravity_m_s2=truth.local_gravity, gravity_std_m_s2=1e-5,
            heading_std_deg=truth.heading_std_deg, closure_std_deg=truth.closure_std_deg, operator="A. Weber",
        )  # fmt: skip
        options = CalibrationOptions(
            self.machine.root, steps=[Dwell(position, 6.0) for position in POSITIONS], warms_up=False
        )
        self._began = self._first.clock.now
        with self._first.disk.aside():
            self._database = open_db(self._file)
            self._engine = CalibrationEngine(self._database, options, lambda _: None)
            self._engine.execute(OperatorCommand(verb="check", url=OTHER_ADDRESS))
            self._engine.round()
            self._engine.execute(OperatorCommand(verb="begin", setup=setup))
        start = self._engine.view.start
        expect(self._engine.view.stage != "start", f"the other station cannot begin: {start and start.refused}")

    def round(self) -> None:
        """Go on a little."""
        if self.is_over:
            return
        with self._first.disk.aside():
            engine = self._engine
            engine.round()
            self.shown = max(self.shown, engine.view.done)
            if engine.view.verdict is not None:
                self._store()
            elif engine.view.stage in ENDED_STAGES or self._first.clock.now - self._began > LONGEST_S:
                view = engine.view
                raise Finding(f"the other station came to {view.stage}: {view.line} {view.error} {view.hint}")
            else:
                self.person.look(engine)

    @property
    def is_over(self) -> bool:
        """Whether its calibration is stored."""
        return self.verdict is not None

    def finish(self) -> None:
        """Go on to its end."""
        while not self.is_over:
            self.round()

    def _store(self) -> None:
        self._engine.execute(OperatorCommand(verb="store"))
        view = self._engine.view
        if view.verdict is None or not view.verdict.stored_sha256:
            raise Finding(f"the other station did not store: {view.stage} {view.hint} {view.error}")
        self.verdict = view.verdict
        self._engine.execute(OperatorCommand(verb="leave"))
        self._engine.close()
        self._database.close()
        self._first.others.clear()
        self._first.say(f"the other station stored {self.verdict.stored_sha256}")
