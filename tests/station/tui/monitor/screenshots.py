"""Draw the pictures of docs/how-to/monitor.md: `python -m tests.station.tui.monitor.screenshots`."""

import asyncio

from station.monitor.view import MonitorView
from tests.station.monitor import views
from tests.station.tui.monitor.session import LARGE, SMALL, shown
from tests.station.tui.screenshots import FOLDER, portable

PICTURES = {
    "monitor": (views.RESTING, SMALL),
    "monitor_moving": (views.AIDED, LARGE),
    "monitor_filters": (views.SIDE_BY_SIDE, SMALL),
    "monitor_map": (views.LOCATED, SMALL),
    "monitor_camera": (views.SEEING, SMALL),
}


async def picture(view: MonitorView, size: tuple[int, int]) -> str:
    """Return the monitor's screen as SVG."""
    async with shown(view, size) as seen:
        await seen.pilot.pause()
        return portable(seen.app.export_screenshot(simplify=True))


async def main() -> None:
    """Write all of them."""
    for name, (view, size) in PICTURES.items():
        (FOLDER / f"{name}.svg").write_text(await picture(view, size), encoding="utf-8")


if __name__ == "__main__":
    asyncio.run(main())
