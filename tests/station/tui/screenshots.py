"""Draw the pictures of docs/how-to/guided-calibration.md: `python -m tests.station.tui.screenshots`."""

import asyncio
import re

from station.guide.view import CalibrationView
from tests.paths import ROOT
from tests.station.tui import start_views, views
from tests.station.tui.session import SMALL, screens

FOLDER = ROOT / "docs" / "screens"
PICTURES = {
    "setup": start_views.START,
    "placing": views.PLACEMENT,
    "holding": views.HOLDING,
    "turning": views.TURNING,
    "verdict": views.PASSED,
}


async def picture(view: CalibrationView) -> str:
    """Return a screen as SVG that asks for no font from elsewhere and is the same each time."""
    async with screens(view, SMALL) as seen:
        await seen.pilot.pause()
        return portable(seen.app.export_screenshot(simplify=True))


def portable(svg: str) -> str:
    """Return an exported screen without fonts from elsewhere, the same each time."""
    svg = re.sub(r"@font-face \{.*?\}", "", svg, flags=re.DOTALL)
    svg = svg.replace("Fira Code", "DejaVu Sans Mono, Menlo, Consolas")
    svg = re.sub(r"terminal-\d+-", "terminal-", svg)
    return "\n".join(line.rstrip() for line in svg.splitlines() if line.strip()) + "\n"


async def main() -> None:
    """Write all of them."""
    FOLDER.mkdir(exist_ok=True)
    for name, view in PICTURES.items():
        (FOLDER / f"{name}.svg").write_text(await picture(view), encoding="utf-8")


if __name__ == "__main__":
    asyncio.run(main())
