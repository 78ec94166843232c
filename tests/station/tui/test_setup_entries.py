"""What is wrong in an entry of the set-up's form is said in words."""

import pytest

from station.files.setup import Setup
from station.tui.setup_entries import ENTRIES, problems, texts_of
from tests.station.tui import start_views

SETUP = start_views.START.start.setup


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("url", "", "is needed"),
        ("latitude_deg", "", "is needed: a number from -90 to 90 deg"),
        ("latitude_deg", "north", "'north' is not a number"),
        ("latitude_deg", "nan", "out of range"),
        ("latitude_deg", "-90.01", "out of range"),
        ("longitude_deg", "400", "out of range"),
        ("gravity_m_s2", "9.4", "expected a number from 9.5 to 10.1 m/s2"),
        ("gravity_m_s2", "", "is needed where its sigma is given"),
        ("gravity_std_m_s2", "0", "out of range"),
        ("dwell_s", "", "is needed"),
        ("dwell_s", "-1", "out of range"),
        ("revolutions", "2.5", "expected a whole number from 1 to 100"),
        ("revolutions", "0", "out of range"),
        ("gnss", "mavlink:udp:0.0.0.0:14550", "is no receiver, expected mavlink:udpin:0.0.0.0:14550"),
        ("gnss", "mavlink:udpin:0.0.0.0", "is no receiver"),
    ],
)
def test_each_field_says_what_is_wrong_in_words(name: str, text: str, words: str) -> None:
    assert words in problems(texts_of(SETUP) | {name: text})[name]


def test_a_dwell_from_the_noise_needs_the_sigma_wanted() -> None:
    assert "is needed" in problems(texts_of(SETUP) | {"dwell_s": "0"})["bias_ug"]


def test_every_entry_is_a_field_of_the_set_up() -> None:
    assert {entry.name for entry in ENTRIES} <= set(Setup.model_fields)


@pytest.mark.parametrize("typed", ["udp:14550", "/dev/ttyACM0", "ttyACM0", "drone.local:5760"])
def test_a_receivers_address_may_be_typed_bare(typed: str) -> None:
    assert "gnss" not in problems(texts_of(SETUP) | {"gnss": typed})
