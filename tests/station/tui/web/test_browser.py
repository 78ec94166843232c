"""The screen in a real browser: what is drawn, what keys do, what a tab's end does."""

from urllib.parse import urlsplit

from station.tui.screens.framed_screen import PHONE_SIZE
from tests.station.tui.web.chromium import Chromium
from tests.station.tui.web.engine import Engine, WebServer, has_ended


def test_keys_reach_the_program_and_its_picture_reaches_the_page(
    browser: Chromium, engine: Engine, web: WebServer
) -> None:
    page = browser.open(web.url)
    process = engine.new_screen()
    page.until_colour("#102030")
    page.press("a")
    page.press("ArrowDown", 40)
    page.press("Escape", 27)
    assert [engine.next() for _ in range(3)] == [(process, "a"), (process, "down"), (process, "escape")]
    engine.say("#c02060")
    page.until_colour("#c02060")
    asked = [urlsplit(url) for url in page.requested() if not url.startswith("data:")]
    assert {url.netloc for url in asked} == {urlsplit(web.url).netloc}
    assert {url.path.rpartition("/")[2] for url in asked} >= {"textual.js", "xterm.css", "ws"}
    page.close()
    assert engine.next() == (process, "ended")  # told to, not killed
    assert has_ended(process)


def test_a_second_tab_sees_the_same_engine_and_a_closed_one_takes_nothing_with_it(
    browser: Chromium, engine: Engine, web: WebServer
) -> None:
    first = browser.open(web.url)
    one = engine.new_screen()
    engine.say("#206020")
    second = browser.open(web.url)
    two = engine.new_screen()
    assert one != two
    for page in (first, second):
        page.until_colour("#206020")
    first.close()
    assert has_ended(one)
    assert engine.next() == (one, "ended")
    second.press("n")
    assert engine.next() == (two, "n")
    engine.say("#2060c0")
    second.until_colour("#2060c0")
    second.close()
    assert has_ended(two)


def test_a_program_that_dies_is_reported_and_can_be_opened_again(
    browser: Chromium, engine: Engine, web: WebServer
) -> None:
    page = browser.open(web.url)
    process = engine.new_screen()
    page.until_colour("#102030")
    page.press("x")
    assert engine.next() == (process, "x")
    page.until("getComputedStyle(document.querySelector('#ended')).display == 'flex'")
    page.value("document.querySelector('#ended button').click()")
    assert engine.new_screen() != process
    page.close()


def test_a_telephone_gets_letters_that_can_be_read_and_the_columns_that_its_layout_needs(
    browser: Chromium, engine: Engine, web: WebServer
) -> None:
    page = browser.open("about:blank")
    page.ask("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    page.ask("Page.navigate", url=web.url)
    engine.new_screen()
    page.until_colour("#102030")
    assert page.value("window.innerWidth") == 390  # not the 980 of a page that says nothing of telephones
    letter = float(page.value("document.getElementById('terminal').dataset.fontSize"))
    assert letter >= 13
    assert 390 / (0.6 * letter) >= PHONE_SIZE[0]
    page.close()
