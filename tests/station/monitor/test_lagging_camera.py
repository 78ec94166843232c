"""A drive in memory whose camera lags: nothing waits for its images, and they count where they were taken."""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
import pytest

from procedures.fusion.inner.window_state import FRAME_SPACING_S
from station.locate.location import Location
from station.monitor.text_lines import json_line
from tests.station.monitor.driving import DrivenAlong, DriveRig, driven_along
from tests.station.monitor.test_driving import TRUTH, off, turned
from tests.station.monitor.test_driving_by_camera import AUTOPILOT, TRACK

pytestmark = pytest.mark.proof

Held = Callable[[float], float]


def two_to_four(t: float) -> float:
    return 3.0 + float(np.sin(t))


def too_long(t: float) -> float:
    return 6.0


LAGS: dict[str, Held] = {"2 to 4 s": two_to_four, "of no use": too_long}
SEES = {"sees": (0.04, (0.0, 0.0)), "specified": -0.04}


@cache
def drive(name: str | None) -> DrivenAlong:
    """Return a drive that several tests look at, with a camera that lags or, None, without."""
    given = {} if name is None else {**SEES, "held_s": LAGS[name]}
    return driven_along(31.0, TRACK, AUTOPILOT, TRUTH, **given)


@pytest.fixture(scope="module", autouse=True)
def _let_go() -> Iterator[None]:
    yield
    drive.cache_clear()


def located(rig: DriveRig | DrivenAlong) -> list[tuple[float, Location]]:
    """Return locations and when [s] each was shown."""
    return [
        (view.reading.t, view.location)
        for view in rig.lines
        if view.reading and view.location and view.location.is_located
    ]


def ages(rig: DrivenAlong) -> np.ndarray:
    return np.array([shown - location.t for shown, location in located(rig)])


@pytest.fixture(scope="module")
def alone() -> DrivenAlong:
    return drive(None)


@pytest.fixture(scope="module", params=LAGS)
def lagging(request: pytest.FixtureRequest) -> tuple[str, DrivenAlong]:
    return request.param, drive(request.param)


def test_a_location_is_no_later_and_no_older_than_without_a_camera(
    lagging: tuple[str, DrivenAlong], alone: DrivenAlong
) -> None:
    _, rig = lagging
    assert located(rig)[0][0] <= located(alone)[0][0] + FRAME_SPACING_S
    assert np.median(ages(rig)) < np.median(ages(alone)) + 0.1 * FRAME_SPACING_S
    assert ages(rig).max() < ages(alone).max() + FRAME_SPACING_S


def test_place_and_heading_are_the_truth_within_their_sigma(lagging: tuple[str, DrivenAlong]) -> None:
    settled = [location for _, location in located(lagging[1]) if location.t > 20.0]
    assert len(settled) > 100
    assert all(off(each) < 4 * np.sqrt(2) * max(each.enu_std[:2]) for each in settled)
    assert all(abs(turned(each)) < 4 * (each.heading_std or 0.0) for each in settled)
    assert np.mean([turned(each) ** 2 for each in settled]) < 0.3**2


def test_late_images_count_where_they_were_taken(lagging: tuple[str, DrivenAlong]) -> None:
    name, rig = lagging
    least, most = {"2 to 4 s": (2.0, 4.0), "of no use": (6.0, 6.0)}[name]
    assert rig.view.reading is not None
    now = rig.view.reading.t
    if name == "of no use":
        assert rig.seen_until < 17.0
        assert rig.awaited == 0
    else:
        assert now - most - 0.5 < rig.seen_until < now - least


def test_what_was_dropped_is_counted_and_reported_once(lagging: tuple[str, DrivenAlong]) -> None:
    name, rig = lagging
    location = located(rig)[-1][1]
    reported = [event.text for event in rig.view.events if "dropped" in event.text]
    assert f'"images_dropped": {location.images_dropped}' in json_line(rig.view)
    assert f"{location.images_dropped} images dropped" in location.camera
    assert len(reported) == 1
    if name == "of no use":
        assert location.images_dropped > 100
        assert location.camera.startswith("images are 6.")
