"""What is true of a simulated autopilot, beside where it is."""

from dataclasses import dataclass, field

EPOCH_UTC = 1_780_000_000.0  # s since 1970 at time 0


@dataclass(frozen=True, slots=True, kw_only=True)
class AutopilotTruth:
    """How it answers and what it sends.

    ``default_hz`` what it sends unasked; ``most_hz`` above which an interval is DENIED, as are those of
    ``denies``; without ``knows_intervals`` SET_MESSAGE_INTERVAL is UNSUPPORTED; unless it ``obeys``, what is asked
    for is accepted and nothing comes of it. ``states_utc``: GPS_RAW_INT is
    stamped with UTC, else with the time since boot; ``states_accuracy``: its extension fields are filled;
    ``states_velocity``: speed and course are.
    """

    system: int = 1
    component: int = 1
    epoch_utc: float = EPOCH_UTC
    default_hz: float = 1.0
    most_hz: float = 50.0
    denies: frozenset[int] = frozenset()
    knows_intervals: bool = True
    obeys: bool = True
    states_utc: bool = False
    states_accuracy: bool = True
    states_velocity: bool = True
    latency_s: float = 0.1
    position_std_m: float = 1.0
    velocity_std_m_s: float = 0.05
    undulation_m: float = 12.0
    temperature_c: float = 41.0
    airspeed_m_s: float = 0.0
    key: bytes = b""
    wrong_key: bytes = field(default=bytes(range(32)), repr=False)
