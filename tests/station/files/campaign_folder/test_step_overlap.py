"""Resets of the device's clock in a campaign are one counted remark; an overlap that none explains is refused."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from station.errors import DataRefused
from station.files.campaign_folder.step_overlap import refuse_overlap


def step(name: str, begin: float, host: float | None, turn_on: int = 1) -> Any:
    span = None if host is None else (host, host + 10.0)
    data = SimpleNamespace(span=(begin, begin + 10.0), host_span=span)
    return SimpleNamespace(table=SimpleNamespace(file=name, turn_on=turn_on), data=data)


def test_any_number_of_resets_is_one_remark() -> None:
    steps = [step(f"move_{i}.mcap", 5.0 * i, 100.0 * i) for i in range(5)]
    remarks = refuse_overlap(Path("campaign"), steps)
    assert len(remarks) == 1
    assert "4 steps" in remarks[0]
    assert all(f"move_{i}.mcap" in remarks[0] for i in range(1, 5))


def test_steps_apart_leave_no_remark() -> None:
    assert refuse_overlap(Path("campaign"), [step("a", 0.0, None), step("b", 20.0, None)]) == []
    assert refuse_overlap(Path("campaign"), [step("a", 0.0, None, 1), step("b", 5.0, None, 2)]) == []


def test_an_overlap_that_nothing_explains_is_refused() -> None:
    with pytest.raises(DataRefused):
        refuse_overlap(Path("campaign"), [step("a", 0.0, None), step("b", 5.0, None)])
