"""The page on GNSS says what the code does."""

from drivers.device_url_parser import LINKS
from drivers.simulated.timed_faults import GNSS_KINDS
from tests.paths import ROOT

PAGE = (ROOT / "docs/gnss.md").read_text(encoding="utf-8")


def test_every_fault_and_link_has_its_row() -> None:
    for name, text in GNSS_KINDS.items():
        assert f"| `{name}` | {text} |" in PAGE
    assert all(f"`mavlink:{link}:" in PAGE for link in LINKS)
