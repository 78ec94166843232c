"""The process behind one tab."""

import asyncio
from asyncio.subprocess import Process

from aiohttp import web
from textual_serve.app_service import AppService
from textual_serve.download_manager import DownloadManager

STOP_S = 3.0  # for a program to end when it is told to


class Tab(AppService):
    """Ends with its tab, whatever its program does; the tab ends with its program, however that ends."""

    def __init__(self, command: str, websocket: web.WebSocketResponse, downloads: DownloadManager) -> None:
        self._websocket = websocket
        super().__init__(
            command,
            write_bytes=websocket.send_bytes,
            write_str=websocket.send_str,
            close=self._close,
            download_manager=downloads,
        )

    async def run(self) -> None:
        """Hand on what the program draws until it has ended."""
        try:
            await super().run()
        finally:
            await self._close()

    async def stop(self) -> None:
        """Tell the program to end, and end it if it does not."""
        if self._process is None:
            return
        ending = asyncio.create_task(self._end(self._process))
        try:
            await asyncio.wait({ending}, timeout=STOP_S)
        finally:  # also where the server is in a hurry itself
            if self._process.returncode is None:
                self._process.kill()
        await ending

    async def _end(self, process: Process) -> None:
        await super().stop()
        await process.wait()

    async def _close(self) -> None:
        await self._websocket.close()
