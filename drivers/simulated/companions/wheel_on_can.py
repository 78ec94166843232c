"""A simulated vehicle's wheel on CAN: frames of a DBC behind an slcan adapter, with a simulated IMU or alone."""

from pathlib import Path

import numpy as np

from drivers.can.wheel_signal import wheel_signal
from drivers.simulated.companions.companion_device import CompanionDevice
from drivers.simulated.lines import SlcanAdapter
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.arrays import FloatArray

DBC, SIGNAL = str(Path(__file__).parents[2] / "can" / "wheel.dbc"), "WHEELS.SPEED"
RATE_HZ = 50.0
SCALE = 1.015  # the true speed over the one that is sent
FORGOTTEN_S = 0.3  # s: a bus does not wait for its listener
NOISE_M_S = 0.02
BITRATE = 500_000


def wheel_speeds(t: FloatArray, track: VehicleTrack | None, scale: float, rng: np.random.Generator) -> FloatArray:
    """Return what a wheel reports (n,) [m/s] at times ``t`` (n,) [s]: true is ``scale`` times that."""
    if track is None:
        return np.zeros(len(t))
    true = np.linalg.norm(track.velocities(t), axis=1)
    speeds: FloatArray = np.maximum(true / scale + rng.normal(0, NOISE_M_S, len(t)) * (true > 0), 0.0)
    return speeds


class SimulatedWheel(CompanionDevice):
    """A wheel on CAN while the ``with`` block lasts; its speed is that along ``track``, divided by `SCALE`.

    ``link`` is a path to the adapter's pty.
    """

    def __init__(
        self, track: VehicleTrack | None = None, seed: int | None = 1, *, imu: SimulatedDevice | None = None,
        speed: float = 1.0, link: Path | None = None,
    ) -> None:  # fmt: skip
        self._line = SlcanAdapter(link)
        super().__init__("simulated wheel", (), imu, speed, self._line.plug, self._line.unplug)
        self._track, self._rng = track, np.random.default_rng(seed)
        self._signal = wheel_signal(DBC, SIGNAL)
        self._sent = 0  # frames, or those that nobody heard

    @property
    def url(self) -> str:
        """The URL of its bus."""
        return f"{self._line.address}?bitrate={BITRATE}"

    def _step(self, now: float, *, is_plugged: bool) -> None:
        due = int(now * RATE_HZ)
        first = max(self._sent, due - int(FORGOTTEN_S * RATE_HZ))
        self._sent = due
        if not is_plugged or first >= due:
            self._stop.wait(0.2 / RATE_HZ)
            return
        t = np.arange(first, due) / RATE_HZ
        speeds = wheel_speeds(t, self._track, SCALE, self._rng)
        self._line.write(b"".join(self._signal.frame(each, 0) for each in speeds.tolist()), self._stop)


def wheel_toml(url: str, dbc: str, forward: str = "[1.0, 0.0, 0.0]") -> str:
    """Return the file of a simulated wheel, `wheel/1`."""
    return (
        f'format = "wheel/1"\nurl = "{url}"\ndbc = "{dbc}"\nsignal = "{SIGNAL}"\n'
        f"wheel_std_m_s = 0.03\nforward = {forward}\n"
    )
