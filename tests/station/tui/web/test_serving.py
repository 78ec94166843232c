"""The life of the server and of the programs behind it, without a browser."""

import asyncio
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import urlsplit

import aiohttp
import pytest

from tests.station.tui.web.engine import Engine, WebServer, has_ended

KEY = '["stdin", "{}"]'


@asynccontextmanager
async def opened(engine: Engine, web: WebServer) -> AsyncIterator[tuple[aiohttp.ClientWebSocketResponse, int]]:
    """Open a tab; with it comes the number of its process."""
    async with aiohttp.ClientSession() as client, client.ws_connect(web.url + "ws?width=100&height=30") as tab:
        yield tab, await asyncio.to_thread(engine.new_screen)


async def until_closed(tab: aiohttp.ClientWebSocketResponse) -> None:
    async for _ in tab:
        pass


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_every_tab_and_the_server(engine: Engine, web: WebServer, number: signal.Signals) -> None:
    async def run() -> tuple[int, int]:
        async with opened(engine, web) as (one, first), opened(engine, web) as (two, second):
            web.process.send_signal(number)
            for tab in (one, two):
                await until_closed(tab)
                assert tab.close_code == aiohttp.WSCloseCode.GOING_AWAY
            return first, second

    assert all(has_ended(process) for process in asyncio.run(run()))
    assert web.reported() == ("", "")
    assert web.process.returncode == 0


def test_a_killed_server_leaves_programs_only_until_the_engine_is_gone_too(engine: Engine, web: WebServer) -> None:
    async def run() -> int:
        async with opened(engine, web) as (tab, process):
            web.process.kill()
            await until_closed(tab)
            return process

    process = asyncio.run(run())
    engine.hang_up()
    assert has_ended(process)


def test_a_frozen_program_ends_with_its_tab(engine: Engine, web: WebServer) -> None:
    async def run() -> int:
        async with opened(engine, web) as (tab, process):
            await tab.send_str(KEY.format("w"))
            assert await asyncio.to_thread(engine.next) == (process, "w")
            return process

    assert has_ended(asyncio.run(run()))


@pytest.mark.parametrize("key", ["q", "x"])
def test_a_program_that_ends_closes_its_tab(engine: Engine, web: WebServer, key: str) -> None:
    async def run() -> None:
        async with opened(engine, web) as (tab, _):
            await tab.send_str(KEY.format(key))
            await until_closed(tab)

    asyncio.run(run())


async def text_of(tab: aiohttp.ClientWebSocketResponse) -> list[str]:
    """Return the next message that is not a picture."""
    while (message := await tab.receive(60)).type is aiohttp.WSMsgType.BINARY:
        pass
    reported: list[str] = message.json()
    return reported


def test_a_file_is_handed_out_once_and_to_its_own_page(engine: Engine, web: WebServer) -> None:
    async def run() -> None:
        own = f"http://{urlsplit(web.url).netloc}"
        async with opened(engine, web) as (tab, _), aiohttp.ClientSession(own) as client:
            await tab.send_str(KEY.format("d"))
            kind, key = await text_of(tab)
            assert kind == "deliver_file_start"
            assert (await client.get(f"/download/{key}", headers={"Origin": "http://evil.example"})).status == 403
            assert await (await client.get(f"/download/{key}")).text() == "the report"
            assert (await client.get(f"/download/{key}")).status == 404

    asyncio.run(run())
