"""The terminal's screens over an engine in this process: each view is drawn, and keys become commands."""

import asyncio
import time
from collections.abc import Iterable

from station.guide.view import CalibrationView, OperatorCommand
from tests.station.tui.session import screens

REAL_MONOTONIC = time.monotonic
Asked = tuple[CalibrationView, tuple[str, ...]]
WAIT_S = 60.0  # of real time, for one view to be drawn


class RealTimeLoop(asyncio.SelectorEventLoop):
    """Waits by the real clock, whatever the station's says."""

    def time(self) -> float:
        """Return the real clock's time [s]."""
        return REAL_MONOTONIC()


class DrawnScreen:
    """One application that lives as long as the ``with`` lasts."""

    def __init__(self, view: CalibrationView) -> None:
        self._loop = RealTimeLoop()
        self._asked: asyncio.Queue[Asked | None] = asyncio.Queue()
        self._lines: asyncio.Queue[list[str]] = asyncio.Queue()
        self.sent: list[OperatorCommand] = []
        self._task = self._loop.create_task(self._live(view))

    def __enter__(self) -> "DrawnScreen":
        return self

    def __exit__(self, *_: object) -> None:
        self._asked.put_nowait(None)
        self._loop.run_until_complete(asyncio.wait([self._task], timeout=WAIT_S))
        self._loop.close()

    def show(self, view: CalibrationView, keys: Iterable[str] = ()) -> list[str]:
        """Draw a view, press keys; return the lines that then stand in the terminal."""
        self._asked.put_nowait((view, tuple(keys)))
        waiting = self._loop.create_task(self._lines.get())
        self._loop.run_until_complete(
            asyncio.wait([waiting, self._task], timeout=WAIT_S, return_when=asyncio.FIRST_COMPLETED)
        )
        if not waiting.done():
            self._task.result()  # raises what the screens raised
            raise TimeoutError(f"not drawn within {WAIT_S:g} s: {view.stage}, {view.line}")
        return waiting.result()

    async def _live(self, view: CalibrationView) -> None:
        async with screens(view, (120, 40)) as drawn:
            while (asked := await self._asked.get()) is not None:
                await drawn.show(asked[0])
                if asked[1]:
                    await drawn.press(*asked[1])
                self.sent += drawn.sent
                drawn.sent.clear()
                self._lines.put_nowait(drawn.lines())
