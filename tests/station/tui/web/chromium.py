"""A headless Chromium, driven over its DevTools protocol."""

import asyncio
import base64
import io
import shutil
import subprocess
import time
from collections.abc import Coroutine
from pathlib import Path
from typing import Any, Self, TypeVar

import aiohttp
from PIL import Image

from tests.patience import HANG_S

PROGRAM = shutil.which("chromium")
OPTIONS = (
    "--headless=new",
    "--no-sandbox",  # a test may run as root
    "--no-first-run",
    "--disable-background-networking",
    "--disable-dev-shm-usage",
    "--enable-unsafe-swiftshader",
    "--force-color-profile=srgb",
    "--window-size=1280,800",
    "--disable-renderer-backgrounding",
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--remote-debugging-port=0",
    "about:blank",
)
BETWEEN_LOOKS_S = 0.2  # a look draws the whole page; the program that is waited for needs the processor, too
TO_WAIT = "new Promise(done => {{ const look = () => ({0}) ? done(true) : setTimeout(look, 20); look() }})"
Json = dict[str, Any]
T = TypeVar("T")


class Chromium:
    """One browser with pages; everything it says meanwhile is kept in ``events``."""

    def __init__(self, profile: Path) -> None:
        self._profile = profile
        self._runner = asyncio.Runner()
        self._number = 0
        self.events: list[Json] = []

    def __enter__(self) -> Self:
        assert PROGRAM is not None
        self._process = subprocess.Popen(
            [PROGRAM, f"--user-data-dir={self._profile}", *OPTIONS],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self._process.stderr is not None
        line = next(line for line in self._process.stderr if "DevTools listening on" in line)
        self._run(self._connect(line.split()[-1]))
        return self

    def __exit__(self, *_: object) -> None:
        self.ask("Browser.close")
        self._run(self._session.close())
        self._runner.close()
        self._process.communicate(timeout=HANG_S)

    def open(self, url: str) -> "Page":
        """Open a page in a tab of its own."""
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        page = Page(self, target, self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"])
        for domain in ("Page", "Network", "Runtime"):
            page.ask(f"{domain}.enable")
        page.ask("Page.navigate", url=url)
        self._run(self._hear("Page.loadEventFired", page.session))
        return page

    def ask(self, method: str, session: str = "", **parameters: Any) -> Json:
        """Return the answer to a command."""
        return self._run(self._ask(method, session, parameters))

    async def _connect(self, url: str) -> None:
        self._session = aiohttp.ClientSession()
        self._socket = await self._session.ws_connect(url, max_msg_size=0)

    async def _ask(self, method: str, session: str, parameters: Json) -> Json:
        self._number += 1
        request: Json = {"id": self._number, "method": method, "params": parameters}
        await self._socket.send_json(request | ({"sessionId": session} if session else {}))
        while (message := await self._receive()).get("id") != self._number:
            self.events.append(message)
        assert "error" not in message, f"{method}: {message['error']}"
        answer: Json = message["result"]
        return answer

    async def _hear(self, method: str, session: str) -> None:
        while (method, session) not in {(e["method"], e.get("sessionId")) for e in self.events}:
            self.events.append(await self._receive())

    async def _receive(self) -> Json:
        message: Json = await self._socket.receive_json(timeout=HANG_S)
        return message

    def _run(self, work: Coroutine[Any, Any, T]) -> T:
        return self._runner.run(work)


class Page:
    """A tab."""

    def __init__(self, browser: Chromium, target: str, session: str) -> None:
        self._browser, self._target, self.session = browser, target, session

    def ask(self, method: str, **parameters: Any) -> Json:
        return self._browser.ask(method, self.session, **parameters)

    def value(self, script: str) -> Any:
        """Return what a script comes to; a promise is waited for."""
        answer = self.ask("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, condition: str) -> None:
        """Wait until a script is true."""
        self.value(TO_WAIT.format(condition))

    def press(self, key: str, code: int = 0) -> None:
        """Press a key by its name; a key that gives no character needs its code."""
        text = {} if code else {"text": key}
        self.ask("Input.dispatchKeyEvent", type="keyDown", key=key, windowsVirtualKeyCode=code, **text)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)

    def colour(self) -> str:
        """Return the colour of most of what is seen, as #rrggbb."""
        self.ask("Page.bringToFront")  # a page in the back is drawn at leisure
        shot = base64.b64decode(self.ask("Page.captureScreenshot")["data"])
        seen = Image.open(io.BytesIO(shot)).convert("RGB")
        # every fourth pixel tells what most of them are
        colours = seen.resize((seen.width // 4, seen.height // 4), Image.Resampling.NEAREST).getcolors(2**24)
        assert colours is not None
        return "#{:02x}{:02x}{:02x}".format(*max(colours)[1])

    def until_colour(self, colour: str) -> None:
        """Wait until most of what is seen has a colour; the test's own time-out ends it."""
        while self.colour() != colour:
            time.sleep(BETWEEN_LOOKS_S)

    def requested(self) -> list[str]:
        """Return the address of everything that the page asked for so far."""
        mine = [event for event in self._browser.events if event.get("sessionId") == self.session]
        asked = [e["params"]["request"]["url"] for e in mine if e["method"] == "Network.requestWillBeSent"]
        return asked + [e["params"]["url"] for e in mine if e["method"] == "Network.webSocketCreated"]

    def close(self) -> None:
        self._browser.ask("Target.closeTarget", targetId=self._target)
