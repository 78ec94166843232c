"""The life of the server and of the programs behind it, without a browser."""

import asyncio
import signal
from urllib.parse import urlsplit

import aiohttp
import pytest

from tests.station.web.engine import Engine, WebServer, has_ended

KEY = '["stdin", "{}"]'


async def tab_of(client: aiohttp.ClientSession, web: WebServer) -> aiohttp.ClientWebSocketResponse:
    return await client.ws_connect(web.url + "ws?width=100&height=30")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_every_tab_and_the_server(engine: Engine, web: WebServer, number: signal.Signals) -> None:
    async def run() -> list[int]:
        async with aiohttp.ClientSession() as client:
            tabs = [await tab_of(client, web) for _ in range(2)]
            processes = [await asyncio.to_thread(engine.new_screen) for _ in tabs]
            web.process.send_signal(number)
            for tab in tabs:
                async for _ in tab:
                    pass
                assert tab.close_code == aiohttp.WSCloseCode.GOING_AWAY
            return processes

    assert all(has_ended(process) for process in asyncio.run(run()))
    assert web.said() == ("", "")
    assert web.process.returncode == 0


def test_a_killed_server_leaves_programs_only_until_the_engine_is_gone_too(engine: Engine, web: WebServer) -> None:
    async def run() -> int:
        async with aiohttp.ClientSession() as client:
            async with await tab_of(client, web) as tab:
                process = await asyncio.to_thread(engine.new_screen)
                web.process.kill()
                async for _ in tab:
                    pass
        return process

    process = asyncio.run(run())
    engine.hang_up()
    assert has_ended(process)


def test_a_frozen_program_ends_with_its_tab(engine: Engine, web: WebServer) -> None:
    async def run() -> int:
        async with aiohttp.ClientSession() as client:
            async with await tab_of(client, web) as tab:
                process = await asyncio.to_thread(engine.new_screen)
                await tab.send_str(KEY.format("w"))
                assert await asyncio.to_thread(engine.next) == (process, "w")
        return process

    assert has_ended(asyncio.run(run()))


@pytest.mark.parametrize("key", ["q", "x"])
def test_a_program_that_ends_closes_its_tab(engine: Engine, web: WebServer, key: str) -> None:
    async def run() -> None:
        async with aiohttp.ClientSession() as client:
            async with await tab_of(client, web) as tab:
                await asyncio.to_thread(engine.new_screen)
                await tab.send_str(KEY.format(key))
                async for _ in tab:
                    pass

    asyncio.run(run())


def test_a_file_is_handed_out_once(engine: Engine, web: WebServer) -> None:
    async def run() -> None:
        own = urlsplit(web.url)
        async with aiohttp.ClientSession(f"http://{own.netloc}") as client:
            async with await tab_of(client, web) as tab:
                await tab.send_str(KEY.format("d"))
                async for message in tab:
                    if message.type is aiohttp.WSMsgType.TEXT:
                        kind, key = message.json()
                        break
                assert kind == "deliver_file_start"
                assert (
                    await client.get(f"/download/{key}", headers={"Origin": "http://evil.example"})
                ).status == 403
                assert await (await client.get(f"/download/{key}")).text() == "the report"
                assert (await client.get(f"/download/{key}")).status == 404

    asyncio.run(run())
