"""Kill a campaign again and again, at random instants and inside its commits; nothing accepted may be lost.

A child process records from a simulated device in memory, whose counts depend on the step alone: however often it
is killed and the campaign resumed, the solution must be that of an uninterrupted campaign, bit for bit. Half of
the kills come a random moment after the child begins to accept a step.
"""

import json
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from signal import SIGKILL

from sqlalchemy import text

from drivers.simulated.truth import Truth
from fixtures_db.campaigns import campaign
from fixtures_db.database import open_db
from procedures.calibration.joint_calibration import solve
from procedures.campaign.plan_steps import Dwell, Step, Turn, dwell_steps, turn_steps
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import read_hashes, verify_folder
from station.guide.campaign.folder_lock import folder_lock
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.campaign.interrupted_campaigns import reopen
from station.guide.view import CalibrationView
from station.results.result_formats import document_of
from station.results.solution_json import solution_document
from station.stream.live.live_feed import open_feed
from station.stream.recorder.accepted_step_writer import CampaignRecorder, open_campaign
from tests.paths import ROOT
from tests.proof.evidence import Figure, zero
from tests.station.guide.rig import plain_guide
from tests.station.stream.live.bench_in_memory import SITE, Source

TRUTH = Truth.example(1)
STEPS = (*dwell_steps(12.0), *turn_steps(1))
COMMIT_S = 0.06  # about what accepting a step takes
STEP_S = 1000.0  # of device time between two steps
CHILD = (
    f"import sys; sys.path.insert(0, {str(ROOT)!r}); from pathlib import Path; "
    "from tests.benchmarks.kills import STEPS, child; child(Path(sys.argv[1]), STEPS[: int(sys.argv[2])])"
)


class Announced(FolderRecorder):
    """Says when it begins to accept a step and when it has."""

    def accept(self, step: Step, *args: object, **notes: object) -> None:
        print(f"accepting {step.name}", flush=True)
        super().accept(step, *args, **notes)
        print(f"accepted {step.name}", flush=True)


def child(folder: Path, steps: Sequence[Step]) -> None:
    """Record what is left of the campaign in ``folder``, then solve it, or hash what was recorded of a part."""
    target = folder / "campaign"
    with open_db(folder / "station.db") as database:
        target.mkdir(exist_ok=True)
        with folder_lock(target):
            if (target / "campaign.toml").exists() and _is_known(folder):
                recorder = reopen(target, database)
            else:
                (target / "campaign.toml").unlink(missing_ok=True)
                recorder = open_campaign(target, open_feed(Source(TRUTH)).identify(), SITE, database)
            for number, step in enumerate(steps):
                if not recorder.accepted[step.name]:
                    record(number, step, recorder)
    recorded = sorted(sha256 for file, (sha256, _) in read_hashes(target).items() if file.endswith(".mcap"))
    document = {"files": sorted(set(recorded))} if len(steps) < len(STEPS) else solved(target)
    (folder / "solution.json").write_text(json.dumps(document, sort_keys=True))


def solved(target: Path) -> dict[str, object]:
    """Return the solution, with the hashes of what it was solved from but not their names.

    A file that a kill orphaned keeps its name, so that the step has another one.
    """
    loaded = read_campaign(target)
    document = document_of(solution_document(solve([loaded.campaign]), [loaded]))
    files = document["provenance"]["files"]
    recorded = sorted(sha256 for file, sha256 in files.items() if file.endswith(".mcap"))
    document["provenance"] = {"files": recorded}
    return document


def record(number: int, step: Step, recorder: CampaignRecorder, kind: type[FolderRecorder] = Announced) -> None:
    """Guide one step; the device's counts depend on its number alone."""
    source = Source(TRUTH, seed=number + 1)
    source.device.imu.index = round(number * STEP_S / TRUTH.sample_period_s)
    feed, guide = plain_guide(source, [step], kind(recorder))
    start = step.position if isinstance(step, Dwell) else step.start_position
    source.device.execute(f"place {start} 5")
    has_turned = False
    while not guide.is_complete:
        feed.advance()
        for block in feed.ready():
            guide.take(block)
            turn = guide.view(CalibrationView()).turn
            is_at_rest = turn is not None and turn.rest_s >= turn.rest_wanted_s
            if is_at_rest and not has_turned and isinstance(step, Turn):
                has_turned = True
                source.device.execute(f"turn {step.axis} {step.direction} {step.revolutions} 2")


def _is_known(folder: Path) -> bool:
    with open_db(folder / "station.db") as database, database.read() as session:
        return bool(session.execute(text("SELECT count(*) FROM campaigns")).scalar())


def killed_once(folder: Path, steps: int, rng: random.Random, longest_s: float) -> tuple[bool, list[str]]:
    """Run the child until a random instant; return whether it came to its end, and what it said it accepted."""
    command = [sys.executable, "-P", "-c", CHILD, str(folder), str(steps)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        accepted, in_commit = list[str](), rng.random() < 0.5
        wait_for = rng.randint(1, 4)
        if not in_commit:
            time.sleep(rng.uniform(0, longest_s))
            process.kill()
        for line in process.stdout:
            word, name = line.split()
            if word == "accepted":
                accepted.append(name)
            elif in_commit and (wait_for := wait_for - 1) == 0:
                time.sleep(rng.uniform(0, COMMIT_S))
                process.kill()
        if (code := process.wait()) not in {0, -SIGKILL}:
            raise ChildProcessError(f"the campaign ended by itself, with {code}")
        return code == 0, accepted


def faults(folder: Path, accepted: list[str]) -> list[str]:
    """Say what is wrong with a killed campaign; ``accepted`` are the steps that were said to be."""
    found = list[str]()
    if not (folder / "station.db").exists():
        return [f"no database, but {accepted} were accepted"] if accepted else []
    with open_db(folder / "station.db") as database, database.read() as session:
        if session.execute(text("PRAGMA integrity_check")).scalar() != "ok":
            found.append("integrity_check")
        if not session.execute(text("SELECT count(*) FROM campaigns")).scalar():
            return [*found, *(f"{name} lost" for name in accepted)]
        rows = [step.name for step in campaign(session, str((folder / "campaign").resolve())).steps]
    found += [f"{name} lost" for name in accepted if name not in rows]
    found += [f"{name} doubled" for name in set(rows) if rows.count(name) > 1]
    if accepted:
        named = {dwell.name for dwell in read_campaign(folder / "campaign").campaign.dwells}
        if not named <= set(verify_folder(folder / "campaign")):
            found.append("a step without a hash")
    return found


def reference(steps: int) -> tuple[str, float]:
    """Return the solution of an uninterrupted campaign, and how long it took [s]."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        command = [sys.executable, "-P", "-c", CHILD, folder, str(steps)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return (Path(folder) / "solution.json").read_text(), time.monotonic() - began


def run(kills: int, seed: int, steps: int = len(STEPS)) -> Counter[str]:
    """Kill ``kills`` times, over as many campaigns as that takes; return what was counted."""
    rng, (expected, seconds) = random.Random(seed), reference(steps)
    tally = Counter[str]()
    while tally["kills"] < kills:
        tally["campaigns"] += 1
        with tempfile.TemporaryDirectory() as name:
            folder, accepted, is_done = Path(name), list[str](), False
            while not is_done:
                is_done, more = killed_once(folder, steps, rng, seconds / 3)
                tally["kills"] += not is_done
                accepted += more
                for fault in faults(folder, accepted):
                    print("FAULT", fault)
                    tally["faults"] += 1
            tally["other_solutions"] += (folder / "solution.json").read_text() != expected
    return tally


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` kills, over as many campaigns as that takes, did."""
    tally = run(size, seed)
    return {
        "kills": Figure(tally["kills"]),
        "campaigns": Figure(tally["campaigns"]),
        "accepted steps lost or doubled, broken databases": zero(tally["faults"]),
        "solutions that differ in a bit from the uninterrupted campaign's": zero(tally["other_solutions"]),
    }
