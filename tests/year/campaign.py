"""One campaign from the start screen to a stored certificate, by as many starts of the program as it takes."""

import re
import traceback
from collections import Counter
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from drivers.simulated.truth import Truth
from fixtures_db.campaigns import known_campaign
from fixtures_db.database import Database, open_db
from procedures.campaign.plan_steps import Step
from station.demo.example_bench import ExampleBench, add_example
from station.demo.run import demo_laboratory
from station.errors import Incomplete
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.campaign_setup import Setup
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions
from station.guide.view import ENDED_STAGES, CalibrationView, OperatorCommand
from station.results.certificate.issuing import issue
from station.stream.stream_events import NewEvents
from tests.year.bench import ADDRESS, Bench
from tests.year.clock import HostDate
from tests.year.disk import Killed
from tests.year.findings import Finding, expect
from tests.year.machine import Machine
from tests.year.older_database import older_database, take_back
from tests.year.person import Person
from tests.year.plans import drawn_plan
from tests.year.receiver import ADDRESS as RECEIVER_ADDRESS
from tests.year.receiver import Receiver
from tests.year.screen import DrawnScreen
from tests.year.second_station import OtherStation, tries_what_is_taken, writes_concurrently
from tests.year.shown_on_screens import Reported
from tests.year.troubles import TROUBLES, Drawn, Session, draw, withdraw_limits

IDLE_S = 900.0  # of the machine's time without anything accepted or said: a hang
LONGEST_S = 5000.0  # of a session
LAST = Session((), "", 0.0, 5.0, powers=False, older=False, pace_s=1.0)
MOST_SESSIONS = 9
NEIGHBOUR_AFTER = 4  # accepted steps


class YearCampaign:
    """Campaign ``number`` of a year ``seed``, in ``root``; its plan is drawn, if it is not ``steps`` or whole."""

    def __init__(
        self, root: Path, seed: int, number: int, steps: Sequence[Step] = (), *, is_whole: bool = False
    ) -> None:
        self.rng = np.random.default_rng([seed, number])
        self.drawn: Drawn = draw(self.rng)
        self._steps = steps
        if not steps and not is_whole:
            self._steps = drawn_plan(np.random.default_rng([seed, number, 1]), self.drawn.dwell_s)
        self.is_usual = not self._steps
        self.machine = Machine(root, self.drawn.start_utc)
        self.machine.renders = self.drawn.screen
        self.tally = Reported()
        self.truth = replace(Truth.example(self.drawn.unit), sample_period_s=self.drawn.period_s)
        self.machine.bench = Bench(self.machine.clock, self.truth, self.drawn.unit, self.drawn.ppm)
        self.database_file, self.folder = root / "station.db", root / "c"
        self.person = Person(self.machine, self.drawn.manner, self.rng)
        self.other: OtherStation | None = None
        self._has_withdrawn = False
        self._stood = 0.0  # how far off its seat [rad] the cube stood when the program was killed
        if self.drawn.receiver:
            self.machine.receiver = Receiver(self.machine, self.truth, self.drawn.unit)
        self.example: ExampleBench

    def run(self) -> None:
        """Run it; raise `Finding` for what must not be."""
        with self.machine.running(self.drawn.zone):
            self.machine.say(f"{self.drawn}")
            self._received_on = HostDate.today()
            self._furnish()
            sessions = iter([*self.drawn.sessions, *[LAST] * (MOST_SESSIONS - len(self.drawn.sessions))])
            for session in sessions:
                self.tally.sessions += 1
                if self._session(session):
                    break
                self._between(session)
            else:
                if not self.tally.unsolved:
                    raise Finding("it came to no end")
            if self.other is not None:
                self.other.finish()
            self._certify()
            for file in sorted(self.folder.glob("SHA256SUMS")):
                self.machine.say(file.read_text())

    def _furnish(self) -> None:
        """Make the database and the bench in it."""
        if self.drawn.older:
            older_database(self.database_file)
        what = self.drawn.references
        with open_db(self.database_file) as database:
            if what in {"expired", "expires soon"}:  # a year and a day before: add_example's hold for 365 days
                ahead, late = self.machine.clock.ahead, 365 * 86400.0
                self.machine.clock.ahead -= late + (86400.0 if what == "expired" else -3600.0)
            with database.write() as session:
                self.example = add_example(session, self.drawn.unit)
            if what in {"expired", "expires soon"}:
                self.machine.clock.ahead = ahead
            if what == "no limits":
                withdraw_limits(database, self.truth.model)

    @property
    def _setup(self) -> Setup:
        truth, by_receiver = self.truth, self.drawn.receiver == "site"
        return Setup(
            url=ADDRESS, folder=str(self.folder), dwell_s=self.drawn.dwell_s, revolutions=1, repeats=1,
            gnss=RECEIVER_ADDRESS if self.drawn.receiver else "", cube=self.example.cube, slab=self.example.slab,
            latitude_deg=None if by_receiver else truth.latitude_deg,
            longitude_deg=None if by_receiver else truth.longitude_deg,
            gravity_m_s2=truth.local_gravity, gravity_std_m_s2=1e-5,
            heading_std_deg=truth.heading_std_deg, closure_std_deg=truth.closure_std_deg,
            operator="" if self.drawn.references == "no operator" else "M. Huber",
        )  # fmt: skip

    def _session(self, session: Session) -> bool:
        """Start the program once; return whether the campaign is over."""
        machine, disk = self.machine, self.machine.disk
        machine.pace_s = session.pace_s
        disk.begin(int(session.at) if session.end == "kill_write" else None)
        machine.say(f"session {session}")
        engine: CalibrationEngine | None = None
        database: Database | None = None
        try:
            database = open_db(self.database_file)
            engine = CalibrationEngine(
                database, CalibrationOptions(machine.root, steps=self._steps, warms_up=False), self._published
            )
            return self._guided(engine, session)
        except Killed as killed:
            disk.is_dead = True
            self.tally.kills += 1
            self._stood = machine.bench.tilt
            where = re.sub(r"\.[0-9a-f]{12}\.tmp", ".tmp", str(killed))  # a name of its own each time
            machine.say(f"killed at write {disk.writes}: {where}")
            return False
        except Finding:
            raise
        except Exception as error:
            machine.say("".join(traceback.format_exception(error)))
            raise Finding(f"a traceback: {type(error).__name__}: {error}") from error
        finally:
            with suppress(Killed):
                if engine is not None:
                    engine.close()
            if database is not None:
                database.close()
            disk.begin(None)
            disk.is_full = False
            machine.bench.close()

    def _published(self, view: CalibrationView) -> None:
        self.machine.say(f"[{view.stage}] {view.line}")

    def _guided(self, engine: CalibrationEngine, session: Session) -> bool:
        """Begin or resume at the start screen, then follow the views to an end."""
        if not self._begun(engine):
            return bool(self.tally.verdict and self.tally.verdict.stored_sha256)
        self.person.comes()
        with DrawnScreen(engine.view) if self.drawn.screen else nullcontext() as screen:
            return self._followed(engine, session, screen)

    def _followed(self, engine: CalibrationEngine, session: Session, screen: DrawnScreen | None) -> bool:
        machine, began = self.machine, self.machine.clock.now
        troubles, events, stage = list(session.troubles), NewEvents(), ""
        alive = began
        if self.drawn.other and self.other is None:
            self.other = OtherStation(machine, self.database_file, self.drawn.unit)
        while engine.view.stage not in ENDED_STAGES:
            before = machine.clock.now
            engine.round()
            if machine.clock.now == before:
                machine.sleep(machine.pace_s)  # nobody read
            if self.other is not None:
                self.other.round()
            view = engine.view
            for event in events.of(view.events):
                machine.say(f"{event.sound}: {event.text}")
                alive = machine.clock.now
            if view.stage != stage:
                stage, alive = view.stage, machine.clock.now
                machine.say(f"<{stage}> {view.line}")
                if screen is not None:
                    screen.show(view)
            if self._accepted(view):
                alive = machine.clock.now
                if self.drawn.neighbour and view.done == NEIGHBOUR_AFTER:
                    tries_what_is_taken(self.database_file, machine, self._setup, self.folder)
            now = machine.clock.now
            if now - alive > IDLE_S or now - began > LONGEST_S:
                raise Finding(f"a hang: nothing for {now - alive:.0f} s at {view.stage}: {view.line}; {view.hint}")
            while troubles and troubles[0][0] <= now - began:
                machine.say(f"trouble: {TROUBLES[troubles.pop(0)[1]](machine, self.rng)}")
            self._end(engine, session, now - began)
            if view.verdict is not None or view.line.startswith("all steps are recorded"):
                return self._concluded(engine, session, screen)
            self.person.look(engine)
        return self._ended(engine.view)

    def _begun(self, engine: CalibrationEngine) -> bool:
        """Begin the campaign, or resume it; return whether it is under way."""
        start = engine.view.start
        assert start is not None
        there = [one for one in start.unfinished if one.folder == str(self.folder)]
        with open_db(self.database_file) as database, database.read() as session:
            row = known_campaign(session, str(self.folder))
        self.machine.say(f"unfinished: {[one.title for one in there]}, {row and row.state}")
        if row is not None and row.state == "accepted":
            self._stored_before_kill()
            return False
        if self.tally.shown.total() and not there:
            raise Finding(
                f"a campaign with {self.tally.shown.total()} accepted steps is not offered to be resumed"
            )
        tries = 0
        while True:
            tries += 1
            if there:
                engine.execute(OperatorCommand(verb="resume", folder=str(self.folder)))
            else:
                engine.execute(OperatorCommand(verb="check", url=ADDRESS))
                engine.round()
                engine.execute(OperatorCommand(verb="consider", setup=self._setup))
                engine.round()
                engine.execute(OperatorCommand(verb="begin", setup=self._setup))
            if engine.view.stage != "start":
                return engine.view.stage not in ENDED_STAGES or self._ended(engine.view)
            assert engine.view.start is not None
            self.machine.say(f"refused: {engine.view.start.refused}")
            self.tally.refused.append(engine.view.start.refused)
            # killed between campaign.toml and its row: nothing is accepted, and nothing of it is taken away
            if "it is not empty" in engine.view.start.refused and (self.folder / "campaign.toml").exists():
                self.folder = self.machine.root / f"{self.folder.name}-{tries}"
            if tries > 5:
                raise Finding(f"it cannot begin: {engine.view.start.refused}")
            self.machine.sleep(30.0)

    def _stored_before_kill(self) -> None:
        """Take it from the database that the calibration was stored though nobody saw it said."""
        from fixtures_db.stored_calibrations import newest_calibration

        with open_db(self.database_file) as database, database.read() as session:
            row = newest_calibration(session, str(self.folder))
        if row is None or self.tally.verdict is None:
            raise Finding("an accepted campaign without a calibration, or one whose verdict nobody saw")
        self.tally.verdict = self.tally.verdict.model_copy(update={"stored_sha256": row.sha256})

    def _accepted(self, view: CalibrationView) -> bool:
        """Take in what the view says is accepted; what was accepted must stand where the cube did."""
        now = Counter({step.name: step.attempts for step in view.steps if step.attempts})
        if not view.steps:
            return False
        stood, self._stood = self._stood, 0.0  # what the first view shows was accepted before the kill
        if now == self.tally.shown:
            return False
        for name, count in (now - self.tally.shown).items():
            step = view.step(name)
            assert step is not None
            stands = self.machine.bench.device.imu.position
            self.machine.say(f"accepted {name} ({count}), the cube is in {stands}")
            self.tally.tilts[name] = max(self.machine.bench.tilt, stood)
            self.tally.turned[name] = self.machine.bench.turned
            is_right = step.position in {0, stands} or self.person.lies
            expect(bool(is_right), f"{name} is accepted, the cube is in position {stands}")
        if lost := self.tally.shown - now:
            raise Finding(f"accepted and gone: {dict(lost)}")
        self.tally.shown = now
        return True

    def _end(self, engine: CalibrationEngine, session: Session, seconds: float) -> None:
        """End the session as it was drawn, if it is time."""
        if not session.end or seconds < session.at or session.end in {"kill_write", "kill_end"}:
            return
        if session.end == "kill_time":
            self.machine.disk.die()
        if session.end == "cancel" and engine.view.stage not in ENDED_STAGES:
            engine.execute(OperatorCommand(verb="cancel"))
        if session.end == "leave":
            engine.execute(OperatorCommand(verb="leave"))
        if session.end == "full_disk":
            self.machine.disk.is_full = True

    def _ended(self, view: CalibrationView) -> bool:
        self.machine.say(f"<{view.stage}> {view.line} {view.error} {view.hint} code {view.code}")
        if view.stage == "failed" and "disk full" not in view.error:
            raise Finding(f"it stopped: {view.error}")
        if view.stage == "cancelled":
            self._cancelled()
        return False

    def _cancelled(self) -> None:
        """The database must not know it any more, the recordings must be there; another one is begun elsewhere."""
        with open_db(self.database_file) as database, database.read() as session:
            expect(known_campaign(session, str(self.folder)) is None, "a cancelled campaign is in the database")
        tables = read_campaign_toml(self.folder)[0]
        recorded = len(tables.dwell) + len(tables.turn)
        expect(recorded == len(self.tally.shown), f"cancelled with {recorded} steps of {dict(self.tally.shown)}")
        self.folder = self.machine.root / f"{self.folder.name}-again"
        self.tally.shown, self.tally.verdict = Counter(), None

    def _concluded(self, engine: CalibrationEngine, session: Session, screen: DrawnScreen | None) -> bool:
        """Look at the verdict, and store."""
        view = engine.view
        if view.verdict is None:
            self.tally.unsolved = view.hint
            self.machine.say(f"unsolved: {view.hint}")
            engine.execute(OperatorCommand(verb="leave"))
            return True
        self.tally.verdict = view.verdict
        self.machine.say(f"verdict: {view.verdict.sentence}; {view.verdict.status} {view.verdict.status_reason}")
        if session.end == "kill_end":
            self.machine.disk.kill_at = self.machine.disk.writes + int(session.at)
        withdraws = self.drawn.references == "withdrawn" and not self._has_withdrawn
        if withdraws:
            self._has_withdrawn = True
            with open_db(self.database_file) as database:
                withdraw_limits(database, self.truth.model)
        self._store(engine, screen)
        stored = engine.view.verdict
        if withdraws:  # a verdict by limits that no longer hold is not stored: it is solved again
            expect("limits of" in engine.view.hint, f"stored though its limits were withdrawn: {engine.view.hint}")
            engine.execute(OperatorCommand(verb="leave"))
            return False
        if stored is None or not stored.stored_sha256:
            if "disk full" in f"{engine.view.error}{engine.view.hint}":
                return False
            if engine.view.stage == "cancelled":  # the operator's last word, said while it was being solved
                self._cancelled()
                return False
            raise Finding(f"not stored: {engine.view.stage} {engine.view.hint} {engine.view.error}")
        self.tally.verdict = stored
        self.machine.say(f"stored {stored.stored_sha256}")
        engine.execute(OperatorCommand(verb="leave"))
        return True

    def _store(self, engine: CalibrationEngine, screen: DrawnScreen | None) -> None:
        """Store by a command, or by the keys of a screen that shows the verdict."""
        if screen is None:
            engine.execute(OperatorCommand(verb="store"))
            return
        assert engine.view.verdict is not None
        lines = screen.show(engine.view)
        for row in engine.view.verdict.rows:  # of the table: the verdict's sentence names a row as well
            if shown := [line for line in lines if line.strip().startswith(f"{row.name}  ")]:
                expect(any(row.value in line for line in shown), f"{row.name}: {row.value} is not on {shown}")
        screen.sent.clear()
        screen.show(engine.view, ("s", "y"))
        expect([one.verb for one in screen.sent] == ["store"], f"s and y sent {screen.sent}")
        engine.execute(screen.sent[0])
        screen.show(engine.view)

    def _between(self, session: Session) -> None:
        """Let time go by while the program is not running."""
        machine, position = self.machine, self.machine.bench.device.imu.position
        if self.other is not None:
            self.other.finish()
        if self.drawn.neighbour:
            writes_concurrently(self.database_file, self.tally.sessions)
        if session.powers or session.pause_s > 200.0:
            machine.clock.now += session.pause_s
            machine.bench.switch_on(position or 1)
        else:
            machine.sleep(session.pause_s)
        if session.older and take_back(self.database_file):
            machine.say("the database is one of an older program")

    def _certify(self) -> None:
        """Have the certificate issued."""
        if self.tally.unsolved or self.tally.verdict is None:
            return
        received_on = min(self._received_on, HostDate.today())  # the clock may have been set back over midnight
        with open_db(self.database_file) as database:
            try:
                row = issue(database, self.tally.verdict.stored_sha256, demo_laboratory(received_on))
            except Incomplete as error:
                self.tally.certificate = "lacks " + ", ".join(name for name, _ in error.missing)
            else:
                self.tally.certificate = row.sha256
        self.machine.say(f"certificate: {self.tally.certificate}")
