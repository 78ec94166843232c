"""More of what is cut: guided steps, and the migration that begins the journal."""

from pathlib import Path
from tempfile import TemporaryDirectory

from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Step
from station.files.atomic_file import new_folder
from station.guide.campaign.folder_lock import folder_lock
from station.guide.campaign.folder_recorder import FolderRecorder
from station.stream.live.live_feed import open_feed
from station.stream.recorder.accepted_step_writer import open_campaign
from tests.benchmarks.edited_databases.honest_databases import of_version
from tests.benchmarks.kills import STEPS, TRUTH, record
from tests.benchmarks.power_cuts.saying import CAMPAIGN, DATABASE, say, sha256
from tests.station.stream.live.bench_in_memory import SITE, Source

BEFORE_JOURNAL = "0010"
GUIDED, CARRIED = 4, 55


class _Saying(FolderRecorder):
    """Says what it has accepted."""

    def accept(self, step: Step, *args: object, **notes: object) -> str:  # type: ignore[override]
        name = super().accept(step, *args, **notes)  # type: ignore[arg-type]
        say(step=step.name, file=name, sha256=sha256(self._recorder.folder / name))
        return name


def guided(home: Path) -> None:
    """Let the guide itself see steps and accept them, from a device in memory."""
    folder = home / CAMPAIGN
    with open_db(home / DATABASE) as database, new_folder(folder, "campaign.toml"), folder_lock(folder):
        recorder = open_campaign(folder, open_feed(Source(TRUTH)).identify(), SITE, database)
        say(begun=1)
        for number, step in enumerate(STEPS[:GUIDED]):
            record(number, step, recorder, _Saying)
        recorder.finish()
        say(finished=1)


def journal_begun(home: Path) -> None:
    """Open a filled database from before the journal."""
    (home / DATABASE).parent.mkdir()
    with TemporaryDirectory() as made:
        (home / DATABASE).write_bytes(of_version(BEFORE_JOURNAL, Path(made)).read_bytes())
    say(settled=1)
    open_db(home / DATABASE).close()
    say(rows={"calibrations": 2, "journal": CARRIED}, upgraded=1)
