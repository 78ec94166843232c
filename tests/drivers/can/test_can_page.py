"""The page on CAN says what the code does."""

import re
from pathlib import Path

import pytest

from drivers.can.can_format import OWN_DBC, can_format
from drivers.can.dbc_signals import load_dbc
from drivers.can.mapping_file import CHECKS, KEYS
from tests.drivers.can.frames import DBC, needs_captures
from tests.paths import ROOT

PAGE = (ROOT / "docs/how-to/can.md").read_text(encoding="utf-8")


@needs_captures
def test_the_example_reads_a_foreign_dbc(tmp_path: Path) -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "sbg.toml").write_text(text)
    wire = can_format(str(DBC / "sbgCan.dbc"), str(tmp_path / "sbg.toml"))
    assert (wire.name, wire.output) == ("sbg", "rate")
    assert {"temperature", "device_time", "status"} <= wire.carries


@pytest.mark.parametrize("word", sorted([*KEYS, *CHECKS]))
def test_every_key_and_check_is_explained(word: str) -> None:
    assert re.search(rf"\b{word}\b", PAGE), word


def test_the_table_of_our_frames_is_that_of_the_dbc() -> None:
    for message in load_dbc(OWN_DBC).messages:
        assert f"{message.frame_id:X}" in PAGE
        assert [signal.start // 8 for signal in message.signals] == [0, 4, 6, 7]
