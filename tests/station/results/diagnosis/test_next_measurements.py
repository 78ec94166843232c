"""What would tell findings apart, and plans that are read back as they were meant."""

import tomllib
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from procedures.campaign.plan_steps import Turn
from procedures.effects import EFFECTS
from procedures.effects.effect import MeasurementName
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import axes_matrix
from station.files.campaign_folder.plan_file import read_mounting, read_plan
from station.results.diagnosis.next_measurements import STATIC, next_measurements, turned, write_plans
from tests.refusals import refused

AS_IT_IS = ("+x", "+y", "+z")


def ambiguous(effect: str, *aliases: str, **where: object) -> dict[str, object]:
    return {"effect": effect, "kind": "instrument", "confidence": "possible", "aliases": aliases, "where": where}


def test_every_measurement_that_a_record_may_name_is_there() -> None:
    assert {*get_args(MeasurementName)} == STATIC.keys() | {"again", "channel_moved", "remounted"}


@pytest.mark.parametrize("effect", [effect.name for effect in EFFECTS])
def test_every_plan_is_plan_1(effect: str, tmp_path: Path) -> None:
    for path in write_plans(tmp_path / "next.toml", next_measurements([ambiguous(effect)], AS_IT_IS)):
        tables = tomllib.loads(path.read_text())
        assert tables.pop("format") == "plan/1"
        steps = [step for kind in ("dwell", "turn", "soak") for step in tables.get(kind, [])]
        assert all("file" not in step for step in steps)
        assert all(step.get("seconds", 1) > 0 for step in steps)
        if steps:
            assert len(read_plan(path)) == len(steps)  # so `station calibrate --plan` guides it


def test_the_mounting_of_a_plan_is_read_and_a_left_handed_one_refused(tmp_path: Path) -> None:
    wanted = next_measurements([ambiguous("fixture.parallelism")], AS_IT_IS)
    path, second = write_plans(tmp_path / "next.toml", wanted)
    assert read_mounting(path) == ("+y", "-x", "+z")
    assert read_mounting(second) == ("+x", "+z", "-y")
    path.write_text(path.read_text().replace('"-x"', '"+x"'))
    with refused(DataRefused):
        read_mounting(path)


def test_two_mountings_leave_nothing_of_the_cube_that_looks_like_the_imu() -> None:
    before = axes_matrix(AS_IT_IS)
    rows = [axes_matrix(turned(AS_IT_IS, about)) - before for about in "zx"]
    assert np.linalg.matrix_rank(np.vstack(rows)) == 3
    assert np.linalg.matrix_rank(rows[0]) == 2  # one alone leaves its own axis


def test_a_seating_is_repeated_with_its_pair_partner() -> None:
    (again,) = next_measurements([ambiguous("placement.dwell", position=[8, 7])], AS_IT_IS)
    assert [step["position"] for step in again.steps["dwell"]] == [8, 7]


def test_turns_at_other_speeds_say_so_to_whoever_turns(tmp_path: Path) -> None:
    for effect, speeds in (("scale_asymmetry", {"+": 12.0, "-": 12.0}), ("sagnac_sine", {"+": 55.0, "-": 100.0})):
        wanted = next_measurements([ambiguous(f"gyroscope.{effect}")], AS_IT_IS)
        (path,) = write_plans(tmp_path / "n.toml", wanted)
        turns = [step for step in read_plan(path) if isinstance(step, Turn)]
        assert len(turns) == 6
        assert all(turn.speed_deg_s == speeds[turn.direction] for turn in turns)


def test_no_certificate_is_asked_for_where_there_is_one() -> None:
    unsure = [ambiguous("fixture.face_tilt")]
    assert [one.name for one in next_measurements(unsure, AS_IT_IS)] == ["certificate"]
    assert [one.name for one in next_measurements(unsure, AS_IT_IS, is_certified=True)] == [
        "remounted_about_z", "remounted_about_x",
    ]  # fmt: skip
