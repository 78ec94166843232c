"""The engine of a guided calibration: from the start screen through a campaign to a verdict, one view at a time.

It owns the device, the folder and the database; screens only show views and send commands. Refusals are shown in
the view and nothing is lost: accepted steps are on the disk.

The modules of a campaign, numerics among them, are imported where one begins: the start screen needs none of them.
"""

import contextlib
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import DriverError, LinkSilent, PortNotFound
from fixtures_db.database import Database
from fixtures_db.errors import DatabaseError
from procedures.errors import ProcedureError
from station.errors import CannotWrite, DataRefused, DiskFull, StationError, exit_code
from station.files.campaign_setup import Setup
from station.guide.options import CalibrationOptions, save_setup
from station.guide.setup_view import PortCheck, Readiness, StartView
from station.guide.start_screen import ReadinessInBackground, announce_readiness, start_view
from station.guide.step_names import without_file_names
from station.guide.view import ENDED_STAGES, CalibrationView, OperatorCommand, StageName, Verdict

if TYPE_CHECKING:
    from station.guide.campaign.live_campaign import GuidedCampaign
    from station.guide.simulated_operator import SimulatedOperator
    from station.results.campaign_results import CampaignResults

REFUSALS = (StationError, DriverError, DatabaseError, ProcedureError)
FOR_UNIT = "waiting for the unit's model and serial number"
THEN_SEARCHED = "; then the shortest plan is computed, some seconds"
WHOLE = "all steps are recorded: leave, and diagnose this campaign together with the first one"
ELSEWHERE = "; if the unit is at another port now, use `station resume --device URL`"
DEVICE_VERBS = frozenset({"redo", "choose", "more"})  # what needs the device of a campaign that is complete
LOOK_VERBS = {"check": ("check", "is_checking"), "listen": ("receiver", "is_listening")}  # fields of `StartView`


class CalibrationEngine:
    """At most one campaign; ``publish`` is called with each view that is worth showing before something slow."""

    def __init__(
        self, database: Database, options: CalibrationOptions, publish: Callable[[CalibrationView], None]
    ) -> None:
        self._database, self._options, self._publish = database, options, publish
        self._campaign: GuidedCampaign | None = None
        self._aside = ThreadPoolExecutor(len(LOOK_VERBS) + 1, "look")
        self._looks: dict[str, Future[PortCheck]] = {}  # under way, by verb
        self._results: CampaignResults | None = None
        self._verdict: Verdict | None = None  # of the results
        self._refused = ""  # why what is complete could not be solved
        self._view = CalibrationView()
        planned = {"is_planned_on_the_way": options.wanted is not None}
        start = start_view(database, options.setup).model_copy(update=planned)
        self.view = CalibrationView(stage="start", start=start)
        self._readiness: Readiness | None = None  # of the campaign
        self._considering = ReadinessInBackground(database, options, self._aside)
        self._considered = options.setup

    @property
    def view(self) -> CalibrationView:
        """What is shown; no text of it names a file of a step."""
        return self._view

    @view.setter
    def view(self, view: CalibrationView) -> None:
        self._view = without_file_names(view)

    def round(self) -> None:
        """Let the campaign go on for a moment, or do nothing."""
        for verb in [verb for verb, look in self._looks.items() if look.done()]:
            result, is_under_way = LOOK_VERBS[verb]
            self._show_start(**{result: self._looks.pop(verb).result(), is_under_way: False})
            self._consider(self._considered)
        if (ready := self._considering.answered()) is not None and self._campaign is None:
            self._show_start(readiness=ready)
        campaign = self._campaign
        if campaign is None or self.view.stage in ENDED_STAGES:
            return
        with self._ended_by_refusals():
            campaign.round()
            self._show(campaign)
            if not campaign.is_complete:
                self._refused = ""
            elif self._verdict is None and not self._refused:
                self._finish(campaign)

    @property
    def is_busy(self) -> bool:
        """Whether there is a stream to follow."""
        is_over = self.view.stage in ENDED_STAGES
        return self._campaign is not None and self._campaign.has_device and not is_over

    @property
    def _is_stored(self) -> bool:
        return self._verdict is not None and bool(self._verdict.stored_sha256)

    def execute(self, command: OperatorCommand) -> None:
        """Execute a command; a refusal is shown in the view."""
        with self._ended_by_refusals():
            self._execute(command)

    @contextlib.contextmanager
    def _ended_by_refusals(self) -> Iterator[None]:
        """End the campaign where disk, database, GNSS time or the operator's answer say that it cannot go on."""
        try:
            yield
        except (CannotWrite, DatabaseError) as error:
            self._fail(error)
        except (DataRefused, DriverError) as error:  # all it records is wrong, or this is another unit
            if not self._options.is_patient:
                raise
            self._end("left", str(error), exit_code(error) or 0)

    def move_cube_by(self, operator: "SimulatedOperator") -> None:
        """Show the view to the simulated operator; wait for hands that do not answer, end if hands refuse."""
        lost = operator.lost
        try:
            operator.look(self.view)
        except DriverError as error:
            self._fail(error)
        if operator.lost != lost and self._campaign is not None:
            if operator.lost:
                text = f"the simulated hands do not answer ({operator.lost}); the station tries again"
                self._campaign.say("rejected", text)
            else:
                self._campaign.say("", "the simulated hands answer again")

    def close(self) -> None:
        """Let everything go; a campaign can be resumed."""
        self._aside.shutdown()
        if self._campaign is not None:
            self._campaign.close()

    def _execute(self, command: OperatorCommand) -> None:
        campaign = self._campaign
        if campaign is None:
            self._execute_at_start(command)
        elif command.verb == "cancel":
            self._cancel(campaign)
        elif command.verb == "leave":
            what = "left" if self._is_stored or self._verdict is None else "left, not stored"
            after = "" if self._is_stored else f"; continue later with `station resume {campaign.folder}`"
            self._end("left", what + after)
        elif command.verb == "finish":
            self._finish(campaign)
        elif command.verb == "store":
            self._store()
        elif command.verb in DEVICE_VERBS and not campaign.has_device:
            self._do_again(campaign, command)
        else:
            self._verdict = None if command.verb in {"redo", "more"} else self._verdict
            campaign.execute(command)
            self._show(campaign)

    def _do_again(self, campaign: "GuidedCampaign", command: OperatorCommand) -> None:
        """Open the device of a campaign that is complete, to do a step again; what refuses changes nothing."""
        from station.guide.campaign.campaign_start import finished, resume

        folder = campaign.folder
        self._publish(self.view.model_copy(update={"stage": "connecting", "line": "connecting", "hint": FOR_UNIT}))
        campaign.close()
        try:
            self._campaign = resume(folder, self._database, self._options)
        except REFUSALS as error:
            self._campaign = again = finished(folder, self._database)
            assert again is not None  # it was, and nobody else held it meanwhile
            again.say("rejected", f"not repeated: {error}")
            self._show(again)
        else:
            self._execute(command)

    def _execute_at_start(self, command: OperatorCommand) -> None:
        if command.verb in LOOK_VERBS:
            if command.verb not in self._looks:
                self._looks[command.verb] = self._aside.submit(_look, command.verb, command.url)
                self._show_start(**{LOOK_VERBS[command.verb][1]: True})
        elif command.verb == "consider" and command.setup is not None:
            self._consider(command.setup)
        elif command.verb == "begin" and command.setup is not None:
            if self._options.asks:
                with contextlib.suppress(CannotWrite):  # to be remembered is a courtesy, not a condition
                    save_setup(command.setup)
            self._considered = setup = command.setup
            hint = _awaited(setup) + (THEN_SEARCHED if self._options.wanted else "")
            self._start(lambda: _begun(setup, self._database, self._options), hint)
        elif command.verb == "resume":
            folder, options = Path(command.folder), self._options
            if command.url:
                options = replace(options, setup=options.setup.model_copy(update={"url": command.url}))
            if not self._considered.url:
                self._considered = self._considered.model_copy(update={"url": _port_of(folder)})
            hint = FOR_UNIT + (THEN_SEARCHED if _is_planned_on_the_way(folder) else "")
            self._start(lambda: _resumed(folder, self._database, options), hint, is_to_go_on=True)
        elif command.verb in {"cancel", "leave"}:
            self._end("cancelled", "nothing was started; the database is unchanged")

    def _consider(self, setup: Setup) -> None:
        """Ask how ready the set-up in the form is."""
        start = self.view.start or StartView()
        self._considered = setup
        self._considering.ask(setup, start.check, start.receiver)

    def _start(self, make: "Callable[[], GuidedCampaign]", hint: str, *, is_to_go_on: bool = False) -> None:
        start = (self.view.start or StartView()).model_copy(update={"setup": self._considered})
        self._publish(CalibrationView(stage="connecting", line="connecting", hint=hint))
        wait(self._looks.values())  # they hold the ports
        try:
            self._campaign = make()
        except REFUSALS as error:
            if not self._options.is_patient:
                raise
            self.view = CalibrationView(stage="start", start=start)
            is_moved = is_to_go_on and isinstance(error, PortNotFound | LinkSilent)
            text, code = f"{error}{ELSEWHERE if is_moved else ''}", exit_code(error) or 0
            self._show_start(refused=text, refused_code=code, refusals=start.refusals + 1)
        else:
            self._readiness = announce_readiness(self._campaign, self._database, self._options)
            self._show(self._campaign)

    def _show(self, campaign: "GuidedCampaign") -> None:
        view = campaign.view(CalibrationView(readiness=self._readiness))
        if self._verdict is not None:
            view = _with_verdict(view, self._verdict)
        elif self._refused and campaign.is_complete:
            view = view.model_copy(update={"line": WHOLE, "hint": self._refused})
        self.view = view

    def _show_start(self, **changes: object) -> None:
        start = self.view.start or StartView()
        self.view = self.view.model_copy(update={"start": start.model_copy(update=changes)})

    def _finish(self, campaign: "GuidedCampaign") -> None:
        from station.guide.campaign.verdict import verdict_view
        from station.results.campaign_results import make_results  # scipy and matplotlib: only where wanted

        self._publish(self.view.model_copy(update={"stage": "solving", "line": "solving"}))
        try:
            self._results = make_results(campaign.folder, self._database)
            self._verdict = verdict_view(self._results, self._database)
        except REFUSALS as error:
            if isinstance(error, CannotWrite) or not self._options.is_patient:
                raise
            self._refused = f"this campaign alone cannot be solved: {error}"
            campaign.say("rejected", self._refused)
        self._show(campaign)

    def _store(self) -> None:
        from station.results.campaign_results import store

        if self._results is None or self._verdict is None or self._is_stored:
            return
        try:
            sha256 = store(self._results, self._database)
        except REFUSALS as error:
            if isinstance(error, CannotWrite) or not self._options.is_patient:
                raise
            self.view = self.view.model_copy(update={"hint": f"not stored: {error}"})
        else:
            self._verdict = self._verdict.model_copy(update={"stored_sha256": sha256})
            self.view = _with_verdict(self.view, self._verdict)

    def _cancel(self, campaign: "GuidedCampaign") -> None:
        if self._is_stored:
            self._end("left", "the calibration is stored; there is nothing to cancel")
            return
        from station.guide.campaign.interrupted_campaigns import cancel_campaign

        campaign.close()
        cancel_campaign(campaign.folder, self._database)
        self._end("cancelled", f"cancelled; the database is unchanged, the recordings stay in {campaign.folder}")

    def _fail(self, error: CannotWrite | DatabaseError | DriverError) -> None:
        if isinstance(error, DiskFull) and self._campaign is not None:  # what it failed on is the smallest part
            error = DiskFull(error.path, self._campaign.disk.needed, self._campaign.disk.free)
        if not self._options.is_patient:
            raise error
        if self._campaign is not None:
            with contextlib.suppress(CannotWrite):  # a full disk refuses the end of a receiver's file as well
                self._campaign.close()
        done = f"{self.view.done} accepted steps are safe; `station resume` continues"
        self._end("failed", "the campaign has stopped", exit_code(error) or 0, hint=done, error=str(error))

    def _end(self, stage: StageName, line: str, code: int = 0, hint: str = "", error: str = "") -> None:
        if self._campaign is not None:
            self._campaign.close()
        ended = {"stage": stage, "line": line, "hint": hint, "error": error, "question": None, "code": code}
        self.view = self.view.model_copy(update=ended)


def _with_verdict(view: CalibrationView, verdict: Verdict) -> CalibrationView:
    """Return a view of the end; nothing of what led to it is shown any more."""
    stage, ended = "stored" if verdict.stored_sha256 else "verdict", {"hint": "", "live": "", "wanted": ""}
    return view.model_copy(update={"stage": stage, "line": verdict.sentence, "verdict": verdict} | ended)


def _look(verb: str, url: str) -> PortCheck:
    from station.guide.campaign.port_check import check_port, check_receiver

    return check_port(url) if verb == "check" else check_receiver(url)


def _begun(setup: Setup, database: Database, options: CalibrationOptions) -> "GuidedCampaign":
    from station.guide.campaign.campaign_start import begin

    return begin(setup, database, options)


def _resumed(folder: Path, database: Database, options: CalibrationOptions) -> "GuidedCampaign":
    from station.guide.campaign.campaign_start import finished, resume

    return finished(folder, database) or resume(folder, database, options)


def _port_of(folder: Path) -> str:
    """Return the port that a campaign had, empty if that is not known."""
    from station.files.campaign_folder.plan_file import read_note

    with contextlib.suppress(DataRefused, OSError):
        return (read_note(folder, Setup) or Setup()).url
    return ""


def _is_planned_on_the_way(folder: Path) -> bool:
    from station.files.campaign_folder.plan_file import NAMES, WantedRecord

    return (folder / NAMES[WantedRecord]).is_file()


def _awaited(setup: Setup) -> str:
    if not setup.gnss:
        return FOR_UNIT
    from station.guide.campaign.port_check import MAX_SITE_WAIT_S, SITE_FIXES

    return f"waiting for the unit, and up to {MAX_SITE_WAIT_S:g} s for {SITE_FIXES} positions of the receiver"
