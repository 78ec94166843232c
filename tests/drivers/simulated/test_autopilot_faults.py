"""What the frames of a simulated autopilot come from while a fault has them come from another system."""

import pytest

from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.errors import TruthRefused
from drivers.simulated.timed_faults import TimedFault, gnss_faults_from
from drivers.simulated.truth import Truth

SYSTEM = 5  # of a frame's bytes


@pytest.mark.parametrize(("size", "system"), [(9.0, 9), (255.0, 255), (0.0, 77)])
def test_frames_come_from_the_system_that_is_asked_for(size: float, system: int) -> None:
    faults = [TimedFault("wrong_system", 0.0, 5.0, size)]
    sent = Autopilot(Truth.example(3), AutopilotTruth(default_hz=2.0), faults).due(2.0)
    assert sent[SYSTEM] == system


@pytest.mark.parametrize("size", [3600.0, 256.0, -1.0, float("nan")])
def test_a_system_that_no_byte_holds_is_refused(size: float) -> None:
    with pytest.raises(TruthRefused, match=r"found wrong_system size = .*; expected a MAVLink system, 1 to 255"):
        gnss_faults_from([{"kind": "wrong_system", "at_s": 1, "size": size}])
