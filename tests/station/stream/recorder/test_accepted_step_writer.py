"""A step that was accepted is known again by what `campaign.toml` says of it."""

from dataclasses import replace

import pytest

from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn
from procedures.positions import TURN_START
from station.files.campaign_folder.campaign_schema import DwellTable, MonitorTable, SoakTable
from station.stream.recorder import accepted_step_writer
from station.stream.recorder.accepted_step_writer import step_of

STEPS = [
    Dwell(3, 100.0), Dwell(12, 100.0, 1), Dwell(3, 100.0, 2), FreePosition(4, 60.0), Soak(2, 900.0, 5),
    Soak(11, 900.0), Soak(1, 900.0, 0, "z_up"), Monitor(2, 30.0, 7), Turn("y", "-", 2, TURN_START["y"], 30.0),
]  # fmt: skip


@pytest.mark.parametrize("again", ["", "_2"])
@pytest.mark.parametrize("step", STEPS, ids=[step.name for step in STEPS])
def test_a_table_names_the_step_whose_file_it_is(step: Step, again: str) -> None:
    _, table = accepted_step_writer._table(step, f"{step.name}{again}.mcap")  # noqa: SLF001
    timeless = replace(step, rest_s=0.0) if isinstance(step, Turn) else replace(step, seconds=0.0)
    assert step_of(table) == timeless


@pytest.mark.parametrize(
    "table",
    [
        DwellTable(attitude="free", file="by_hand.mcap"),
        DwellTable(attitude="free", file="soak_1.mcap"),
        SoakTable(attitude="free", file="free_1.mcap"),
        MonitorTable(position=3, laws=["paper"], file="soak_1.mcap"),
    ],
)
def test_what_the_guide_did_not_record_is_none_of_its_steps(
    table: DwellTable | SoakTable | MonitorTable,
) -> None:
    assert step_of(table) is None
