"""What hands do to a simulated unit, every effect that can be planted, an autopilot that is heard."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.mavlink.decoder import MavlinkDecoder
from drivers.mavlink.session import MavlinkSession
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.effects import EFFECTS
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.timed_faults import TimedFault
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.campaign.plan_steps import Dwell, Turn
from tests.stored.held import assert_held
from tests.stored.simulated_truth import TRUTH

BY_NAME: dict[str, dict[str, float]] = {"placement.label": {"position": 4, "actual": 5}}


def moved() -> SimulatedImu:
    """All that hands can do, one after the other."""
    imu = SimulatedImu(TRUTH, 3)
    imu.rest(1.0)
    imu.place(3, 4.0, np.array([1e-3, -2e-3, 5e-4]))
    imu.heat(3.0, 20.0)
    imu.turn("x", "-", 1, rest_s=1.0)
    imu.knock(0.5, 0.02)
    imu.creep(1.0, np.array([0.0, 1e-3, 2e-3]))
    imu.lean(np.array([1.0, 1.0, 0.3]), 3.0)
    t = np.arange(0.0, 21.0, 5.0)
    imu.drive(VehicleTrack(t + imu.done, np.stack((3 * t, 40 * np.sin(t / 9), 0.1 * t), axis=1)))
    return imu


def test_what_hands_do_is_in_counts_and_in_rates() -> None:
    imu, samples = moved(), 4000
    assert_held("devices", "counts", {"done": imu.done, "block": imu.read(samples), "world": imu.world})
    assert_held("devices", "rates", moved().read_rates(samples))


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_planted_in_a_bench_without_noise(name: str) -> None:
    """Each coefficient has a size of its own; positions 4 and 9 and a turn are of what the effect may ask for."""
    effect = EFFECTS[name]
    sizes = {key: 1e-3 * (1 + 0.1 * i) for i, key in enumerate(effect.keys)}
    bench = SimulatedBench(replace(TRUTH, effects={name: {**sizes, **BY_NAME.get(name, {})}}), None)
    steps = (Dwell(4, 3.0), Turn("x", "+", 1, 1, 1.0), Dwell(9, 3.0))
    sums = [(series.gyro.sum(axis=0), series.accel.sum(axis=0)) for series in map(bench.perform, steps)]
    assert_held("devices", f"effect {name}", {"sums": sums, "world": bench.world})


PILOTS = {
    "plain": AutopilotTruth(position_std_m=0.8, undulation_m=12.5, airspeed_m_s=17.0, default_hz=4.0),
    "utc": AutopilotTruth(states_utc=True, states_accuracy=False, states_velocity=False, system=7, latency_s=0.2),
}


@pytest.mark.parametrize("name", PILOTS)
def test_an_autopilot_is_heard(name: str) -> None:
    t = np.arange(0.0, 31.0, 5.0)
    track = VehicleTrack(t, np.stack((3 * t, 40 * np.sin(t / 9), 0.1 * t), axis=1))
    faults = [TimedFault("no_fix", 12.0, seconds=2.0), TimedFault("time_jump", 20.0, seconds=1.0, size=3.0)]
    pilot = Autopilot(TRUTH, PILOTS[name], faults, track, 5)
    decoder, session = MavlinkDecoder(), MavlinkSession(5.0)
    said, heard = list[object](), list[object]()
    for step in range(300):
        now = 0.1 * step
        sent = pilot.due(now) + pilot.hear(session.due(now), now)
        session.hear(sent, now)
        said.append(sent)
        heard += [(type(each).__name__, each) for each in decoder.feed(sent, round(1e9 * (now + 0.02)))]
    told = {"said": said, "heard": heard, "commands": pilot.commands, "messages": dict(decoder.messages)}
    assert_held("devices", f"autopilot {name}", told | {"counters": decoder.framer.counters})
