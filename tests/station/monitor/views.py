"""Views made by hand: a monitor as an operator sees it."""

import math

from station.attitude.live_readings import (
    AttitudeReading,
    FilterReading,
    RestErrorComparison,
    RestErrors,
    SettlesAt,
)
from station.calibrated import InUse
from station.locate.location import Location
from station.monitor.view import ChartPoint, MonitorView
from station.stream.stream_events import Event, StreamState

FOLDER = "/srv/monitor/2026-11-21_1240"


def _history(n: int = 600) -> tuple[ChartPoint, ...]:
    """A minute: it leans to the right in mid-chart, and comes back."""
    return tuple(
        ChartPoint(
            0.1 * i, 12.0 * _bump(i / n), 3.0 * _bump(i / n) * math.sin(i / 30), 0.4 * math.sin(i / 25), 0.1,
            -0.05, math.nan, 0.02 + 0.2 * _bump(i / n), 0.01 + 0.02 * _bump(i / n),
        )
        for i in range(n)
    )  # fmt: skip


def _bump(x: float) -> float:
    return math.exp(-(((x - 0.6) / 0.12) ** 2))


READING = AttitudeReading(
    t=812.4, sample=40619, roll=12.345, pitch=-4.321, sigma=0.01, rate=(0.4, 0.1, -0.05), bias=(0.12, -0.3, 12.1),
    residual=0.021, mode="moving", temperature=23.4,
)  # fmt: skip
IMU = StreamState(name="IMU counts", rate_hz=50.0, age_s=0.0, samples=40620, gaps=0, lost=0, bad=0)
GNSS = StreamState(name="GNSS udpin:0.0.0.0:14550", rate_hz=5.0, age_s=0.1, samples=4060, gaps=0, lost=2, bad=0)
IN_USE = InUse("9f2c41d07be8 of 2026-11-01, calibrated, 20 days old")
MOVING = MonitorView(
    unit="SIM-FOG3 SIM-7", line="", reading=READING, history=_history(), streams=(IMU,), in_use=IN_USE,
    recording="recording.mcap", folder=FOLDER,
    events=(Event(number=1, sound="start", text="mark 1"), Event(number=2, sound="start", text="mark 2")),
)  # fmt: skip


def _with(view: MonitorView, **changes: object) -> MonitorView:
    from dataclasses import replace

    return replace(view, **changes)  # type: ignore[arg-type]


RESTING = _with(
    MOVING,
    reading=_with(
        READING,
        heading=-121.3,
        roll=0.003,
        pitch=-0.002,
        rate=(0.0, 0.002, -0.003),
        sigma=0.004,
        residual=0.003,
        mode="at rest",
    ),
    at_rest=RestErrorComparison(
        157.2, RestErrors(0.0025, 0.031, 0.0018), RestErrors(0.07, 1.006, -22.647), "the Earth's rate is corrected"
    ),
)
ZEROED = _with(MOVING, zero=(12.0, -4.0))
ALARM = Event(number=3, sound="rejected", text="ALARM roll 12.3, limit 10 deg")
ALARMING = _with(MOVING, alarms=("roll 12.3, limit 10 deg",), events=(*MOVING.events, ALARM))
SILENT = _with(
    MOVING, streams=(_with(IMU, trouble="ttyUSB0: no bytes for 2 s; check cable and power", age_s=3.1),)
)
AIDED = _with(
    MOVING, aid="gnss", reading=_with(READING, speed=12.3), streams=(IMU, GNSS),
    history=tuple(point._replace(aid=12.0 + point.pitch) for point in MOVING.history),
)  # fmt: skip
STEEP = _with(RESTING, reading=_with(READING, roll=-157.0, pitch=89.994, mode="at rest"))
UNCALIBRATED = _with(
    RESTING,
    in_use=InUse("NONE: nominal scale factors of HG4930", "NovAtel OEM7 manual"),
    recording="",
)
WAITING_TO_LOCATE = _with(
    AIDED,
    location=Location(
        why="at rest the Earth's rate gives yaw to 5.7 deg and gravity tilt to 0.0 deg (u), 4 and 1 are "
        "needed: move it, or use better gyros",
        fixes=98,
    ),
)
_EIGHT = tuple((40 * math.sin(i / 40), 25 * math.sin(1.7 * i / 40)) for i in range(240))
LOCATED = _with(
    AIDED,
    location=Location(
        is_located=True, t=812.1, enu=(*_EIGHT[-1], 1.2), enu_std=(0.21, 0.2, 0.34), velocity=(-3.1, 5.2, 0.0),
        heading=329.2, heading_std=0.11, latitude=48.1000123, longitude=11.5000456, height=521.2, fixes=4051,
        outliers=3, fix_age=0.2, track=_EIGHT, far=((10.0, 20.0), (12.0, 19.0), (-30.0, 5.0)),
    ),
)  # fmt: skip
SEEING = _with(
    LOCATED, streams=(IMU, GNSS, StreamState("camera 10.0.0.7:8080", 19.8, 0.1, 16000, 0, 0, 0)),
    location=_with(LOCATED.location, camera="118 features, stamps 43 ms late"),
)  # fmt: skip
BLIND = _with(
    SEEING,
    streams=(IMU, GNSS, StreamState(
        "camera 10.0.0.7:8080", 0.0, 4.1, 16000, 0, 2, 0,
        trouble="10.0.0.7:8080: no bytes for 1.8 s, expected images; check the camera",
    )),
    location=Location(
        why="the image moves by 1.8 sigmas more than by a turn, 4 are needed: move further; without the camera: "
        "at rest the Earth's rate gives yaw to 5.7 deg and gravity tilt to 0.0 deg (u), 4 and 1 are needed",
        fixes=98, camera="no image for 4 s",
    ),
)  # fmt: skip
BEHIND = _with(LOCATED, reading=_with(LOCATED.reading, t=824.0))
_JOINT = FilterReading(
    "joint", "Kalman filter, aid gnss", READING.roll, READING.pitch, (0.07535, 0.2132, 0.9741), READING.bias
)
_PAPER = FilterReading(
    "paper", "forward speed (10)", 12.145, -3.101, (0.0541, 0.2101, 0.9762), (1.1, -0.4, 0.0),
    SettlesAt(-0.138, 1.226, 0.338, 0.194),
)  # fmt: skip
SIDE_BY_SIDE = _with(
    AIDED, filters=(_JOINT, _PAPER),
    history=tuple(point._replace(apart=1.2 * _bump(i / 600)) for i, point in enumerate(AIDED.history)),
)  # fmt: skip
FAILING = _with(
    STEEP,
    filters=(
        _JOINT,
        _with(_PAPER, note="paper: pitch beyond 80 deg, its Euler angles fail there; use joint or mixer"),
    ),
)
BY_MIXERS = _with(
    AIDED, reading=_with(AIDED.reading, sigma=math.nan),
    filters=(_with(_PAPER, name="paper-filter", roll=-123.456), _with(_PAPER, name="paper-whole", settles=None)),
)  # fmt: skip
BY_MIXER = _with(
    MOVING, reading=_with(READING, sigma=math.nan), filters=(_with(_PAPER, name="mixer", settles=None),)
)
VIEWS = {
    "side_by_side": SIDE_BY_SIDE, "failing": FAILING, "by_mixers": BY_MIXERS, "by_mixer": BY_MIXER,
    "behind": BEHIND,
    "not_located": WAITING_TO_LOCATE, "located": LOCATED, "seeing": SEEING, "blind": BLIND,
    "waiting": MonitorView(), "moving": MOVING, "resting": RESTING, "zeroed": ZEROED, "alarming": ALARMING,
    "silent": SILENT, "aided": AIDED, "steep": STEEP, "uncalibrated": UNCALIBRATED,
    "ended": _with(RESTING, is_over=True, line="ended"),
}  # fmt: skip
