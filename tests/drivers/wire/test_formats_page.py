"""The page on wire formats has a row for each, and says of it what the code says."""

import re

from drivers.wire import FORMATS, WireFormat
from tests.drivers.wire.blocks import each_format
from tests.paths import ROOT

PAGE = (ROOT / "docs/reference/wire-formats.md").read_text(encoding="utf-8")
TABLE = [row.split("|")[1:-1] for row in PAGE.splitlines() if row.startswith("| `")]
ROWS = {name: row for row in TABLE for name in re.findall("`(.*?)`", row[0])}


@each_format()
def test_every_format_has_its_row(wire: WireFormat) -> None:
    assert wire.name in ROWS, f"docs/reference/wire-formats.md has no row for {wire.name}"
    _, _, sample, sequence, besides, line = ROWS[wire.name]
    assert (wire.output == "rate") == ("rate" in sample)
    assert ("counter" in wire.carries) == ("counter" in sequence)
    assert wire.imu.has_time or "host" in sequence
    assert ("temperature" in wire.carries) == ("temperature" in besides)
    assert (wire.identity is not None and bool(wire.encode_identity)) == ("identity" in besides)
    assert f"{wire.baud} 8{wire.parity}1" in line.replace("*", "") or wire.name == "triad"


def test_every_row_is_of_a_format() -> None:
    assert ROWS.keys() == FORMATS.keys()
