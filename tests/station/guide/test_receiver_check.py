"""The receiver of a set-up: what it says before a campaign, and what the campaign says that it took from it."""

import time
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from station.files.setup import Setup
from station.guide.command import OperatorCommand
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions
from station.guide.port_check import check_receiver
from station.guide.view import CalibrationView
from tests.patience import HANG_S, paced

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
SPEED = 60.0


def test_a_receiver_says_where_it_stands_with_sigma() -> None:
    with SimulatedGnss(TRUTH, speed=10.0) as gnss:
        check = check_receiver(gnss.url)
    assert check.is_good
    words = check.text.replace(",", "").split()
    assert float(words[0]) == pytest.approx(48.1, abs=1e-4)
    assert float(words[1]) == pytest.approx(11.5, abs=1e-4)
    assert float(words[3]) == pytest.approx(520.0, abs=12.0)
    assert 0.1 < float(words[7]) < 10.0


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("mavlink:serial:/dev/ttyNONE", "no such port"),
        ("mavlink:udpin:127.0.0.1:0", "expected mavlink:udpin:HOST:PORT"),
        ("tcp://127.0.0.1:1", "expected a GNSS source: mavlink:LINK:WHERE"),
        ("mavlink:udpin:127.0.0.1:14999?key=/no/file", "/no/file"),
    ],
)
def test_what_cannot_be_listened_to_is_words(url: str, said: str) -> None:
    check = check_receiver(url, 0.1)
    assert (check.is_good, check.url) == (False, url)
    assert said in check.text


def test_the_campaign_waits_for_looks_and_says_the_site_that_it_took(tmp_path: Path) -> None:
    shown: list[CalibrationView] = []
    with (
        SimulatedDevice(TRUTH, 5, speed=paced(SPEED)) as device,
        SimulatedGnss(device.truth, beside=device) as gnss,
        open_db(tmp_path / "s.db") as database,
    ):
        engine = CalibrationEngine(
            database, CalibrationOptions(tmp_path, asks=False, warms_up=False), shown.append
        )
        try:
            engine.obey(OperatorCommand(verb="listen", url=gnss.url))
            assert engine.view.start is not None
            assert engine.view.start.is_listening
            engine.obey(OperatorCommand(verb="check", url=device.url))
            setup = Setup(url=device.url, gnss=gnss.url, longitude_deg=12.5, folder=str(tmp_path / "c"))
            engine.obey(OperatorCommand(verb="begin", setup=setup))  # both ports are still being looked at
            until = time.monotonic() + HANG_S
            while not engine.view.gates:
                assert time.monotonic() < until, (engine.view.stage, engine.view.start)
                engine.round()
            [said] = [event.text for event in engine.view.events if "GNSS" in event.text]
        finally:
            engine.close()
    assert "for 20 positions of the receiver" in shown[0].hint
    assert said.startswith("site by GNSS: 48.")
    assert "1 sigma" in said
    assert said.endswith("longitude_deg 12.5 is stated, GNSS says 11.5")
