"""More of what is cut: guided steps, a receiver's fixes, effects of one's own, the journal's own migration."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

from fixtures_db.database import open_db
from procedures.campaign.plan_steps import Step
from procedures.earth.gnss_records import FixType, GnssFix, TimeMark
from station.files.effect_file import effect_in
from station.files.mcap_files import fix_writer
from station.files.new_folder import new_folder
from station.guide.folder_lock import folder_lock
from station.guide.folder_recorder import FolderRecorder
from station.stream.live.live_feed import open_feed
from station.stream.recorder.accepted_step_writer import open_campaign
from tests.benchmarks.edited_databases.honest_databases import of_version
from tests.benchmarks.kills import STEPS, TRUTH, record
from tests.benchmarks.power_cuts.saying import CAMPAIGN, DATABASE, say, sha256, station, written
from tests.station.stream.live.bench_in_memory import SITE, Source

BEFORE_JOURNAL = "0010"
GUIDED, FIXES, EFFECTS, CARRIED = 4, 300, 6, 55
EFFECT = """format = "effect/1"
name = "law_{number}"
triad = "gyroscope"
term = "-u * exp(-(u / w)**4)"
unit = "1"
plausible = 1.0
source = "a power cut"
shape.w = {{unit = "deg/h", low = 1, high = {high}}}
"""


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


def gnss(home: Path) -> None:
    """Record fixes and times of a receiver, synced every few of them."""
    fix_writer.FLUSH_PERIOD_S = 0.0
    with new_folder(home / "records" / "drive", "gnss.mcap") as folder:
        writer = fix_writer.FixWriter(folder / "gnss.mcap")
        for number in range(FIXES):
            ns = number * 200_000_000
            east = 0.2 + 1e-7 * number
            writer.write(GnssFix("HEARD", 1, ns, FixType.FIX_3D, device_ns=ns, latitude=0.8, longitude=east))
            writer.write(TimeMark(ns, ns, None))
        writer.close()
        written(writer.path)


def effects(home: Path) -> None:
    """Adopt effects from a diagnosis, put them into force, withdraw some."""
    with open_db(home / DATABASE):
        pass
    for number in range(EFFECTS):
        text = EFFECT.format(number=number, high=100 + number)
        known = effect_in(text.encode(), home / "x.toml")
        entry = {"effect": known.name, "definition": known.text, "sha256": known.sha256}
        (home / f"diagnosis_{number}.json").write_text(json.dumps({"format": "diagnosis/1", "findings": [entry]}))
    say(settled=1)
    rows = 0
    for number in range(EFFECTS):
        out = home / f"law_{number}.toml"
        station("effects", "adopt", home / f"diagnosis_{number}.json", "--out", out)
        written(out)
        station("effects", "add", out, "--model", "FOG-3", "--db", home / DATABASE)
        say(rows={"effect_events": (rows := rows + 1)})
        if number % 3 == 2:
            station("effects", "withdraw", f"gyroscope.law_{number}", "--model", "FOG-3", "--db", home / DATABASE)
            say(rows={"effect_events": (rows := rows + 1)})


def journal_begun(home: Path) -> None:
    """Open a filled database from before the journal."""
    (home / DATABASE).parent.mkdir()
    with TemporaryDirectory() as made:
        (home / DATABASE).write_bytes(of_version(BEFORE_JOURNAL, Path(made)).read_bytes())
    say(settled=1)
    open_db(home / DATABASE).close()
    say(rows={"calibrations": 2, "journal": CARRIED}, upgraded=1)
