"""Draw the README's animation, docs/screens/guided.svg: `python -m tests.station.tui.animation` (two minutes).

`station calibrate --headless` runs with a simulated device, 19 steps up to the stored result. Views of it are
drawn on the real screen and shown one after the other in 15 s, without a script.
"""

import asyncio
import re
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from station.demo.example_bench import GRAVITY_STD, add_example
from station.files.campaign_setup import Setup
from station.guide.headless import run_headless
from station.guide.options import EngineOptions
from station.guide.view import CalibrationView, OperatorCommand
from tests.station.tui.screenshots import FOLDER, portable
from tests.station.tui.session import SMALL, screens

SEED, SPEED = 1, 20.0
SECONDS, LAST_S = 15.0, 3.0  # of the animation, and of the result in it
IN_DETAIL = ("dwell_01", "dwell_02", "turn_x_plus")  # steps that are shown from place to accepted
MOMENTS = (0.0, 0.25, 0.5, 0.75, 0.95)  # of a dwell that is shown in detail
MIDDLE = 0.6  # of another dwell


def recorded(folder: Path) -> list[CalibrationView]:
    """Calibrate a simulated unit in ``folder``, and return the views of it that differ."""
    views = list[CalibrationView]()

    def keep(view: CalibrationView) -> None:
        if not views or views[-1] != view:
            views.append(view)

    database = str(folder / "station.db")
    with SimulatedDevice(Truth.example(SEED), SEED, "counts", SPEED) as device, open_db(database) as opened:
        with opened.write() as session:
            bench = add_example(session, SEED)
        truth = bench.truth
        setup = Setup(
            url=device.url, folder=str(folder / "campaign"), dwell_s=60.0, revolutions=2,
            cube=bench.cube, slab=bench.slab, operator="A. Weber", latitude_deg=truth.latitude_deg,
            longitude_deg=truth.longitude_deg, gravity_m_s2=truth.local_gravity, gravity_std_m_s2=GRAVITY_STD,
            heading_std_deg=truth.heading_std_deg, closure_std_deg=truth.closure_std_deg,
        )  # fmt: skip
        options = EngineOptions(
            root=folder, database=database, setup=setup, hands=device.control, move_s=15.0, asks=False,
            warms_up=False, first=OperatorCommand(verb="begin", setup=setup),
        )  # fmt: skip
        run_headless(options, opened, keep, stores=True)
    return views


def shown(views: Sequence[CalibrationView]) -> list[CalibrationView]:
    """Return the views that the animation shows: of every step one or more, then the result."""
    found, last = list[CalibrationView](), None
    for view in views:
        if view.stage in ("place", "settle", "dwell", "turn"):
            step = view.live or view.wanted
            share = view.accepted_s / view.wanted_s if view.stage == "dwell" and view.wanted_s else 0.0
            is_detailed = step in IN_DETAIL
            moments = MOMENTS if is_detailed else (MIDDLE,)
            passed = sum(share >= each for each in moments) if view.stage == "dwell" else 1
            turned = _turned(view, 4 if is_detailed else 1)
            moment = (step, view.stage, passed, turned)
            if moment != last and (is_detailed or (view.stage == "dwell" and passed) or turned == 1):
                found.append(view)
            last = moment
        elif view.stage == "verdict" and (not found or found[-1].stage != "verdict"):
            found.append(view)
    return found


def _turned(view: CalibrationView, parts: int) -> int:
    return 0 if view.turn is None else int(parts * abs(view.turn.revolutions) + 0.1)


async def drawn(views: Sequence[CalibrationView]) -> list[str]:
    """Return each view as SVG."""
    pictures = list[str]()
    async with screens(views[0], SMALL) as seen:
        for view in views:
            await seen.show(view)
            await seen.pilot.pause()
            pictures.append(portable(seen.app.export_screenshot(simplify=True)))
    return pictures


_RULE = re.compile(r"\.(terminal-r\d+) \{ (.*?) \}")
_PART = re.compile(r"<rect fill=[^>]*shape-rendering[^>]*/>|<text class=\"terminal-r\d+\".*?</text>", re.DOTALL)


def _parts(picture: str) -> Iterator[str]:
    """Yield a picture's rectangles and texts, each with its own look."""
    looks = {name: re.sub(r"\s*([:;])\s*", r"\1", look) for name, look in _RULE.findall(picture)}
    for part in _PART.findall(picture):
        styled = re.sub(r'class="(terminal-r\d+)"', lambda found: f'style="{looks[found[1]]}"', part)
        yield re.sub(r' (?:clip-path="[^"]*"|shape-rendering="[^"]*")', "", styled)


def animated(pictures: Sequence[str]) -> str:
    """Return pictures of one size as one SVG that shows them in turn; what several have in common stands once."""
    frames = [list(_parts(picture)) for picture in pictures]
    at = dict[str, list[int]]()
    for number, frame in enumerate(frames):
        for part in dict.fromkeys(frame):
            at.setdefault(part, []).append(number)
    groups = dict[tuple[bool, tuple[int, ...]], list[str]]()  # rectangles lie below texts
    for part, numbers in at.items():
        groups.setdefault((part.startswith("<text"), tuple(numbers)), []).append(part)
    style, body = list[str](), list[str]()
    for number, ((_, numbers), parts) in enumerate(sorted(groups.items())):
        name = ""
        if len(numbers) < len(frames):
            name = f' class="g{number}"'
            style.append(f".g{number}{{animation:k{number} {SECONDS:g}s step-end infinite}}")
            style.append(f"@keyframes k{number}{{{_keyframes(numbers, len(frames))}}}")
        body.append(f"<g{name}>{''.join(parts)}</g>")
    head, _, rest = pictures[0].partition("</style>")
    frame = re.search(r"<rect fill=\"#\w+\" stroke=.*?</g>", rest, re.DOTALL)
    moved = re.search(r"<g transform=\"translate\(9, 41\)\"", rest)
    assert frame is not None
    assert moved is not None
    head = _RULE.sub("", head)
    return (
        f"{head}{''.join(style)}</style>\n{frame[0]}\n"
        f'<g transform="translate(9, 41)" class="terminal-matrix">{"".join(body)}</g>\n</svg>\n'
    )


def _keyframes(numbers: Sequence[int], count: int) -> str:
    each = (SECONDS - LAST_S) / (count - 1) / SECONDS * 100  # percent of the time
    seen = set(numbers)
    changes = [n for n in range(count) if n == 0 or (n in seen) != (n - 1 in seen)]
    return "".join(f"{n * each:.4g}%{{visibility:{'visible' if n in seen else 'hidden'}}}" for n in changes)


def main() -> None:
    """Run the campaign and write the animation."""
    with tempfile.TemporaryDirectory() as folder:
        views = shown(recorded(Path(folder)))
    (FOLDER / "guided.svg").write_text(animated(asyncio.run(drawn(views))), encoding="utf-8")


if __name__ == "__main__":
    main()
