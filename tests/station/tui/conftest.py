"""The screens' tests wait until nothing is left to be done, on a machine however busy.

Textual waits until its process takes little of a core for 20 ms, which one that gets little of it always does.
"""

import asyncio

import pytest
from textual import app, pilot

from tests.patience import HANG_S

SOON_S = 0.02  # what is due by then is waited for; a screen is drawn 60 times a second
ROUNDS = 3  # of the loop in which nothing was to be done


async def nothing_left_to_do(min_sleep: float = 0.0, max_sleep: float = 0.0) -> None:
    """Wait until the loop has neither something to do nor something due at once."""
    loop, quiet = asyncio.get_running_loop(), 0
    ready = loop._ready  # type: ignore[attr-defined]  # noqa: SLF001
    deadline = loop.time() + HANG_S
    await asyncio.sleep(SOON_S / 2)  # what another thread hands over is neither
    while quiet < ROUNDS and loop.time() < deadline:
        now, timers = loop.time(), loop._scheduled  # type: ignore[attr-defined]  # noqa: SLF001
        due = [timer.when() for timer in timers if timer.when() < now + SOON_S and not timer.cancelled()]
        quiet = 0 if ready or due else quiet + 1
        await asyncio.sleep(max(min(due) - now, 0) if due and not ready else 0)


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (app, pilot):
        monkeypatch.setattr(module, "wait_for_idle", nothing_left_to_do)
    monkeypatch.setattr(pilot.Pilot._wait_for_screen, "__defaults__", (HANG_S,))  # noqa: SLF001
