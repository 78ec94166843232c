"""What a guided campaign takes from its receiver at its beginning, and does without when it must."""

import json
from contextlib import ExitStack
from pathlib import Path

import pytest

from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.truth import Truth
from station.files.setup import Setup
from station.guide import gnss_in_campaign
from station.guide.gnss_in_campaign import NoFix, reopened, sited, utc_now
from station.stream.gnss.gnss_feed import open_gnss

TRUTH = Truth(latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)


def test_what_is_stated_stands_and_is_compared_and_the_rest_is_taken(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, speed=20.0) as gnss, open_gnss(gnss.url, tmp_path) as feed:
        setup = sited(Setup(gnss=gnss.url, latitude_deg=48.3), feed, tmp_path)
        began = utc_now(feed)
    assert setup.latitude_deg == 48.3
    assert setup.longitude_deg == pytest.approx(11.5, abs=1e-4)
    assert setup.height_m == pytest.approx(520.0, abs=10.0)
    assert began is not None
    assert began.year == 2026
    noted = json.loads((tmp_path / "gnss.json").read_text())
    assert noted["latitude_deg"] == pytest.approx(48.1, abs=1e-4)
    assert noted["height_above"] == "ellipsoid"
    assert "latitude_deg 48.3 is stated, GNSS says 48.1" in noted["warnings"][0]


def test_without_a_fix_a_site_that_nobody_states_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gnss_in_campaign, "MAX_SITE_WAIT_S", 0.8)
    monkeypatch.setattr(gnss_in_campaign, "SHORT_WAIT_S", 0.2)
    with SimulatedGnss(TRUTH) as gnss, open_gnss(gnss.url, tmp_path) as feed:
        gnss.plant("no_fix", 1e6)
        stated = Setup(gnss=gnss.url, latitude_deg=48.1)
        assert sited(stated, feed, tmp_path) == stated
        with pytest.raises(NoFix):
            sited(Setup(gnss=gnss.url), feed, tmp_path)


def test_a_campaign_is_gone_on_with_although_its_receiver_is_gone(tmp_path: Path) -> None:
    with ExitStack() as stack:
        assert reopened(stack, Setup(), tmp_path) == (None, "")
        feed, said = reopened(stack, Setup(gnss="mavlink:tcp:127.0.0.1:9"), tmp_path)
    assert feed is None
    assert "going on without GNSS: 127.0.0.1:9" in said
