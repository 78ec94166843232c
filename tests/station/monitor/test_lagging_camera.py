"""A drive in memory whose camera lags: nothing waits for its images, and they count where they were taken."""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
import pytest

from procedures.fusion.inner.camera_frames import SPACING
from station.locate.location import Location
from station.monitor.text_lines import json_line
from tests.station.monitor.driving import DriveRig
from tests.station.monitor.test_driving import TRUTH, off, turned
from tests.station.monitor.test_driving_by_camera import AUTOPILOT, TRACK

Held = Callable[[float], float]
LAGS: dict[str, Held] = {
    "half a second": lambda t: 0.5,
    "2 to 4 s": lambda t: 3.0 + float(np.sin(t)),
    "of no use": lambda t: 6.0,
}


def driven(held_s: Held | None, seconds: float = 31.0) -> DriveRig:
    sees = None if held_s is None else (0.04, (0.0, 0.0))
    given = {} if held_s is None else {"told": -0.04, "held_s": held_s}
    rig = DriveRig(TRUTH, TRACK, AUTOPILOT, sees=sees, **given)
    rig.run(seconds)
    return rig


@cache
def drive(name: str | None) -> DriveRig:
    """Return a drive that several tests look at, with a camera that lags or, None, without."""
    return driven(None if name is None else LAGS[name])


@pytest.fixture(scope="module", autouse=True)
def _let_go() -> Iterator[None]:
    yield
    drive.cache_clear()


def located(rig: DriveRig) -> list[tuple[float, Location]]:
    """Return locations and when [s] each was shown."""
    return [
        (view.reading.t, view.location)
        for view in rig.lines
        if view.reading and view.location and view.location.is_located
    ]


def ages(rig: DriveRig) -> np.ndarray:
    return np.array([shown - location.t for shown, location in located(rig)])


@pytest.fixture(scope="module")
def alone() -> DriveRig:
    return drive(None)


@pytest.fixture(scope="module", params=LAGS)
def lagging(request: pytest.FixtureRequest) -> tuple[str, DriveRig]:
    return request.param, drive(request.param)


def test_a_location_is_no_later_and_no_older_than_without_a_camera(
    lagging: tuple[str, DriveRig], alone: DriveRig
) -> None:
    _, rig = lagging
    assert located(rig)[0][0] <= located(alone)[0][0] + SPACING
    assert np.median(ages(rig)) < np.median(ages(alone)) + 0.1 * SPACING
    assert ages(rig).max() < ages(alone).max() + SPACING


def test_place_and_heading_are_the_truth_within_their_sigma(lagging: tuple[str, DriveRig]) -> None:
    settled = [location for _, location in located(lagging[1]) if location.t > 20.0]
    assert len(settled) > 100
    assert all(off(each) < 4 * np.sqrt(2) * max(each.enu_std[:2]) for each in settled)
    assert all(abs(turned(each)) < 4 * (each.heading_std or 0.0) for each in settled)
    assert np.mean([turned(each) ** 2 for each in settled]) < 0.3**2


def test_late_images_count_where_they_were_taken(lagging: tuple[str, DriveRig]) -> None:
    name, rig = lagging
    least, most = {"half a second": (0.5, 0.5), "2 to 4 s": (2.0, 4.0), "of no use": (6.0, 6.0)}[name]
    window = rig.monitor._options.locating._window  # noqa: SLF001
    now = rig.view.reading.t
    if name == "of no use":
        assert window.seen_until < 17.0
        assert window.awaited == 0
    else:
        assert now - most - 0.5 < window.seen_until < now - least


def test_what_was_dropped_is_counted_and_said_once(lagging: tuple[str, DriveRig]) -> None:
    name, rig = lagging
    location = located(rig)[-1][1]
    said = [event.text for event in rig.view.events if "dropped" in event.text]
    assert f'"images_dropped": {location.images_dropped}' in json_line(rig.view)
    if name == "half a second":
        assert location.images_dropped == 0
        assert said == []
    else:
        assert f"{location.images_dropped} images dropped" in location.camera
        assert said == ["images come too late and are dropped: position and heading go on without them"]
    if name == "of no use":
        assert location.images_dropped > 100
        assert location.camera.startswith("images are 6.")


def test_the_clock_of_a_camera_that_begins_to_lag_stays_its_own() -> None:
    rig = DriveRig(
        TRUTH, TRACK, AUTOPILOT, sees=(0.04, (0.0, 0.0)), told=-0.04, stamps=True,
        held_s=lambda t: 0.0 if t < 20.0 else 1.5 + 0.5 * float(np.sin(t)),
    )  # fmt: skip
    rig.run(40.0)
    camera = rig.monitor._options.locating._camera  # noqa: SLF001
    seen, taken = camera.tracks().frames()[0], rig.sight.tracks.frames()[0]
    assert len(seen) > 300
    assert np.abs(seen[:, None] - taken).min(axis=1).max() < 0.005
    assert 1.0 < rig.view.reading.t - seen[-1] < 2.2
    late = [location for _, location in located(rig) if location.t > 25.0]
    assert all(abs(turned(each)) < 4 * (each.heading_std or 0.0) for each in late)
    assert rig.monitor._options.locating._window.rejected < 1400  # noqa: SLF001


def test_it_is_the_same_each_time() -> None:
    again = located(driven(LAGS["2 to 4 s"], 25.0))  # images have come late for 5 s, and some were dropped
    assert len(again) > 60
    assert again[-1][1].images_dropped > 20
    assert located(drive("2 to 4 s"))[: len(again)] == again
