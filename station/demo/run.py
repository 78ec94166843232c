"""The demo from beginning to end: device, campaign, check of the recording, results, comparison."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from drivers.errors import LinkLost
from drivers.simulated.bench_control import BenchControl
from drivers.wire import FORMATS
from fixtures_db.database import Database, open_db
from procedures.campaign.plan_steps import Dwell
from procedures.positions import ATTITUDES
from station.demo.comparison import truth_values
from station.demo.device import demo_truth
from station.demo.example_bench import GRAVITY_STD, ExampleBench, add_example
from station.errors import CannotWrite, Incomplete, cannot_write
from station.files.atomic_file import replace_file
from station.files.campaign_setup import Setup
from station.guide.headless import record_headless
from station.guide.options import CalibrationOptions
from station.guide.simulated_operator import HandlingStyle, SimulatedOperator
from station.guide.view import CalibrationView
from station.results.campaign_results import CampaignResults, make_results, store
from station.results.certificate.issuing import issue
from station.results.certificate.laboratory import Laboratory
from station.stream.recorder.sample_stream import check_raw_bytes
from station.stream.stream_events import NewEvents

MARK = ".station-demo"
CERTIFICATE_FILE = "certificate.html"
SIMULATED_MOVE_S = 15.0  # device time of a move; a person takes about 45 s
FLIP_S = 8.0  # s, of a flip by trembling hands
FLIPS = tuple(
    ATTITUDES.index(axes) + 1 for axes in "ENU ESD USE DSW SUW NDW NWU SWD UWS DES EUS EDN".split()
)  # halves and quarters of a turn by turns, each face up twice


@dataclass(frozen=True, slots=True)
class DemoRequest:
    """Where the demo goes, which unit, how fast (device seconds per second), dwell [s] and revolutions.

    Not ``has_turns``: the cube is flipped among its 24 positions by trembling hands, and no turn is made.
    """

    folder: Path
    seed: int
    speed: float
    dwell_s: float
    revolutions: int
    database: str | None = None
    has_turns: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class DemoOutcome:
    """What the demo made; ``samples`` were decoded a second time from the recorded bytes, equal to the counts.

    ``sha256`` is the stored calibration's, ``certificate`` says where its certificate is, or what that lacks.
    """

    results: CampaignResults
    truth: dict[str, float]
    campaign: Path
    samples: int
    sha256: str
    certificate: str


def run_demo(
    request: DemoRequest,
    show: Callable[[CalibrationView], None],
    recorded: Callable[[], None],
) -> DemoOutcome:
    """Run the demo.

    Raises
    ------
    CannotWrite
        If the folder is there already and is not a demo's.
    """
    folder, truth, today = request.folder, demo_truth(request.seed), date.today()
    clear(folder)
    values = truth_values(truth, is_certified=True)
    (folder / "truth.json").write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
    # a name that a database which outlives the folder does not know yet
    name = "campaign" if request.database is None else f"campaign_{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    campaign = folder / name
    with (
        _device(request, folder / "imu") as (url, control),
        open_db(request.database or folder / "station.db") as db,
    ):
        flips = () if request.has_turns else tuple(Dwell(p, request.dwell_s) for p in FLIPS)
        options = CalibrationOptions(folder, steps=flips, asks=False, warms_up=False, is_patient=False)
        with db.write() as session:
            bench = add_example(session, request.seed)
        setup = _setup(bench, url, campaign, request)
        operator = SimulatedOperator(BenchControl(control), SIMULATED_MOVE_S)
        if not request.has_turns:
            operator = SimulatedOperator(BenchControl(control), FLIP_S, HandlingStyle(request.seed))
        record_headless(setup, options, db, operator, show)
        recorded()
        steps = sorted(path for kind in ("dwell", "turn", "move") for path in campaign.glob(f"{kind}_*.mcap"))
        samples = sum(check_raw_bytes(path, FORMATS["counts"]) for path in steps)
        results = make_results(campaign, db, folder, truth=values)
        sha256 = store(results, db)  # nobody is there to be asked
        certificate = certify(db, sha256, today, folder / CERTIFICATE_FILE)
    return DemoOutcome(results, values, campaign, samples, sha256, certificate)


def clear(folder: Path) -> None:
    """Make the folder, or empty that of an earlier demo; raise `CannotWrite` if it is anything else."""
    try:
        if folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not (folder / MARK).is_file())):
            raise CannotWrite(folder, "it is there already and was not made by a demo")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / MARK).touch()
        for campaign in folder.glob("campaign*"):
            shutil.rmtree(campaign)
        for name in ("imu", "station.db", "station.db-wal", "station.db-shm", "truth.json", "solution.json",
                     "calibration.json", "diagnosis.json", "report.html", CERTIFICATE_FILE):  # fmt: skip
            (folder / name).unlink(missing_ok=True)
    except CannotWrite:
        raise
    except OSError as error:
        raise cannot_write(folder, error) from error


@contextmanager
def _device(request: DemoRequest, link: Path) -> Iterator[tuple[str, str]]:
    command = [sys.executable, "-P", "-m", "station.demo.device", str(request.seed), str(request.speed), str(link)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        start_new_session=True,  # Ctrl-C is for the demo
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            url, control = process.stdout.readline().strip(), process.stdout.readline().strip()
            if not control:
                raise LinkLost("the simulated device", "it did not start")
            yield url, control
        finally:
            process.stdin.close()


def _setup(bench: ExampleBench, url: str, campaign: Path, request: DemoRequest) -> Setup:
    truth = bench.truth
    return Setup(
        url=url, folder=str(campaign), dwell_s=request.dwell_s, revolutions=request.revolutions,
        cube=bench.cube, slab=bench.slab, operator="station demo",
        latitude_deg=truth.latitude_deg, longitude_deg=truth.longitude_deg,
        gravity_m_s2=truth.local_gravity, gravity_std_m_s2=GRAVITY_STD,
        heading_std_deg=truth.heading_std_deg, closure_std_deg=truth.closure_std_deg,
    )  # fmt: skip


def certify(database: Database, sha256: str, received: date, path: Path) -> str:
    """Issue the certificate of a stored calibration into a file; return its path, or what it lacks."""
    try:
        row = issue(database, sha256, demo_laboratory(received))
    except Incomplete as error:
        return "none: it lacks " + ", ".join(field for field, _ in error.missing)
    replace_file(path, row.html.encode())
    return str(path)


def demo_laboratory(received: date) -> Laboratory:
    """Return what a demo says of a laboratory: that there is none."""
    nobody = {"name": "DEMO: nobody", "address": "a demonstration on simulated devices"}
    return Laboratory.model_validate(
        {
            "format": "laboratory/1",
            "laboratory": {**nobody, "name": "DEMO: no laboratory", "number_prefix": "DEMO-"},
            "authorised": {"name": "DEMO: nobody", "function": "none: a simulated unit was measured"},
            "customer": nobody,
            "item": {"received": received, "condition": "simulated: there is no hardware"},
            "traceability": {"time_base": "the simulator's own time"},
        }
    )


class DemoProgress:
    """Shows the views of a campaign while the ``with`` block lasts."""

    def __init__(self, console: Console) -> None:
        self._console, self._events = console, NewEvents()
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
        self._progress = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._task = self._progress.add_task("connecting", total=None)

    def show(self, view: CalibrationView) -> None:
        """Print what was accepted or rejected, and move the bar."""
        for event in self._events.of(view.events):
            if event.sound in {"accepted", "rejected"}:
                self._console.print(event.text, highlight=False, markup=False)
        line = view.line[: self._console.width // 2]
        self._progress.update(self._task, description=line, total=len(view.steps) or None, completed=view.done)

    def busy(self, text: str) -> None:
        """Say what goes on after the campaign: next to the bar, or in a line where there is no terminal."""
        if not self._console.is_terminal:
            self._console.print(text, highlight=False, markup=False)
        self._progress.update(self._task, description=text, total=None)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._progress.stop()
