"""What is wrong in an entry of the set-up's form is said in words."""

import pytest

from station.files.setup import Setup
from station.tui.setup_entries import ENTRIES, problems, texts_of
from tests.station.tui import start_views

SETUP = start_views.START.start.setup


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("url", "", ""),
        ("latitude_deg", "", "-90 to 90 deg"),
        ("latitude_deg", "north", "'north'"),
        ("latitude_deg", "nan", "nan"),
        ("latitude_deg", "-90.01", "-90.01"),
        ("longitude_deg", "400", "400"),
        ("gravity_m_s2", "9.4", "9.5 to 10.1 m/s2"),
        ("gravity_m_s2", "", "sigma"),
        ("gravity_std_m_s2", "0", "0"),
        ("dwell_s", "", ""),
        ("dwell_s", "-1", "-1"),
        ("revolutions", "2.5", "1 to 100"),
        ("gnss", "mavlink:udp:0.0.0.0:14550", "udpin"),
        ("gnss", "mavlink:udpin:0.0.0.0", "udpin"),
    ],
)
def test_each_field_says_what_is_wrong_in_words(name: str, text: str, words: str) -> None:
    assert words in problems(texts_of(SETUP) | {name: text})[name]


def test_a_dwell_from_the_noise_needs_the_sigma_wanted() -> None:
    assert "is needed" in problems(texts_of(SETUP) | {"dwell_s": "0"})["bias_ug"]


def test_every_entry_is_a_field_of_the_set_up() -> None:
    assert {entry.name for entry in ENTRIES} <= set(Setup.model_fields)
