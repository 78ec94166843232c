"""How ready a set-up is, found out aside: the form waits neither for the database nor for what that imports."""

from concurrent.futures import Executor, Future
from typing import TYPE_CHECKING

from fixtures_db.database import Database
from fixtures_db.errors import DatabaseError
from station.files.campaign_setup import Setup
from station.guide.options import CalibrationOptions
from station.guide.setup_view import PortCheck, Readiness

if TYPE_CHECKING:
    from station.guide.finished_campaign import GuidedCampaign

Asked = tuple[Setup, PortCheck | None, PortCheck | None]  # set-up, the looks at its port and at its receiver


class ReadinessInBackground:
    """Answers the newest of what it was asked; what was asked meanwhile is left out."""

    def __init__(self, database: Database, options: CalibrationOptions, aside: Executor) -> None:
        self._database, self._options, self._aside = database, options, aside
        self._answer: Future[Readiness] | None = None
        self._next: Asked | None = None

    def ask(self, setup: Setup, check: PortCheck | None, receiver: PortCheck | None) -> None:
        """Ask how ready a set-up is."""
        self._next = (setup, check, receiver)
        self._begin()

    def answered(self) -> Readiness | None:
        """Return an answer once, None while there is no new one."""
        if self._answer is None or not self._answer.done():
            return None
        answer, self._answer = self._answer, None
        self._begin()
        return None if isinstance(answer.exception(), DatabaseError) else answer.result()

    def _begin(self) -> None:
        if self._answer is None and self._next is not None:
            asked, self._next = self._next, None
            self._answer = self._aside.submit(current_readiness, self._database, self._options, *asked)


def current_readiness(
    database: Database,
    options: CalibrationOptions,
    setup: Setup,
    check: PortCheck | None,
    receiver: PortCheck | None,
) -> Readiness:
    """Return how ready a set-up is now; a look at another port than the set-up's says nothing."""
    from station.guide.live_campaign import usual_steps
    from station.guide.prior_knowledge import read_prior_knowledge
    from station.guide.readiness import readiness

    check = check if check is not None and check.url == setup.url else None
    steps, rate = tuple(options.steps), None if check is None else check.rate_hz
    facts = read_prior_knowledge(database, options.root, steps or usual_steps(setup), rate, usual=not steps)
    return readiness(setup, facts, check, receiver)


def announce_readiness(
    campaign: "GuidedCampaign", database: Database, options: CalibrationOptions
) -> Readiness | None:
    """Tell the operator how a campaign can end whose unit has answered, before anything is recorded."""
    from station.files.campaign_folder.plan_file import read_note

    if (unit := campaign.as_checked()) is None:
        return None
    setup = (read_note(campaign.folder, Setup) or Setup()).model_copy(update={"url": unit.url})
    ready = current_readiness(
        database, options, setup, unit, PortCheck(url=setup.gnss, is_good=True, text="connected")
    )
    campaign.say("", "this run " + ", ".join(ready.said))
    return ready
