"""A guided campaign beside the shipped scenario: its operator does what the guide asks for, untold."""

from collections import deque
from pathlib import Path

from station.files.scenario import read_scenario
from station.files.setup import Setup
from station.guide.campaign.campaign_start import usual_steps
from station.guide.view import CalibrationView
from tests.paths import ROOT
from tests.station.guide.rig import GuideRig

SCENARIO = read_scenario(ROOT / "docs/scenarios/calibration.toml")
STEPS = usual_steps(Setup(dwell_s=20.0, revolutions=1))
ENOUGH = 4  # steps: the knock is in the fourth


def test_the_shipped_calibration_is_accepted_step_by_step_also_after_the_knock(tmp_path: Path) -> None:
    rig, moves = GuideRig(tmp_path, STEPS[:ENOUGH], SCENARIO.truth, asks=False), deque(SCENARIO.moves)

    def operate(_: CalibrationView) -> None:
        while moves and moves[0].at_s <= rig.source.device.imu.time:
            rig.hands(moves.popleft().command)

    rig.run(rig.done(ENOUGH), operate)
    rig.database.close()
    accepted = [text for text in rig.texts if text.startswith("accepted")]
    assert [f"position {n}, {n} of" in text for n, text in enumerate(accepted, 1)] == [True] * ENOUGH
