from dataclasses import replace

import numpy as np
import pytest

from procedures.attitude.attitude_estimate import AttitudeEstimate, estimate
from procedures.attitude.attitude_log import AttitudeLog, inclination
from procedures.attitude.both_directions import estimate_both_directions
from tests.drivers.simulated.flight import paper_bench
from tests.procedures.attitude.driving import G, driving


def rms_deg(down: np.ndarray, truth: np.ndarray, rows: np.ndarray | slice = slice(None)) -> float:
    return float(np.degrees(np.sqrt(np.mean(inclination(down, truth)[rows] ** 2))))


@pytest.mark.parametrize("aid", ["airspeed-filter", "gnss"])
def test_both_directions_are_better_than_one_and_most_at_the_start(aid: str) -> None:
    log, down = driving()
    online, both = estimate(log, aid), estimate_both_directions(log, aid)
    assert rms_deg(both.down, down) < 0.7 * rms_deg(online.down, down)
    assert rms_deg(both.down, down, log.t < 30) < 0.5 * rms_deg(online.down, down, log.t < 30)
    assert both.sigma is not None
    assert online.sigma is not None
    assert np.median(both.sigma / online.sigma) < 0.98
    assert np.all(both.sigma < 1.001 * online.sigma)
    assert both.down[-1] == pytest.approx(online.down[-1])  # nothing comes after the last row


@pytest.mark.parametrize("late_s", [0.0, 0.2])
def test_late_fixes_count_at_their_own_moment_in_both_directions(late_s: float) -> None:
    log, down = driving()
    assert log.velocity is not None
    rows = round(late_s / 0.01)
    late = replace(log, velocity=np.vstack([np.full((rows, 3), np.nan), log.velocity[: len(log.t) - rows]]))
    assert rms_deg(estimate_both_directions(late, "gnss", fix_latency=late_s).down, down) < 0.06
    if late_s:
        assert rms_deg(estimate_both_directions(late, "gnss").down, down) > 0.06


def test_what_both_share_stays_in_sigma() -> None:
    """At rest both see the same accelerometers: NEES over twelve positions, chi square of 24."""
    tracks = list[tuple[AttitudeLog, AttitudeEstimate]]()
    for position in range(1, 13):
        log = paper_bench(5, position, seconds=70.0)
        tracks.append((log, estimate_both_directions(log, "none", force_bias_std=140e-6 * G)))
    nees = list[float]()
    for log, track in tracks:
        assert log.true_down is not None
        assert track.sigma is not None
        nees.append(float((inclination(track.down, log.true_down)[3500] / track.sigma[3500]) ** 2))
    assert np.mean(nees) == pytest.approx(1.0, abs=4 / np.sqrt(len(nees)))
    assert np.mean(nees) > 0.4
