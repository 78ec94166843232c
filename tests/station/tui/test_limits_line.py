"""In 80 columns the numbers of LIMITS are not cut: the minutes go first, then the bar."""

import pytest

from station.guide.view import LimitView
from tests.station.tui import views
from tests.station.tui.session import screens

TEXTS = (
    "gyroscope bias 0.0268 of 0.0200 deg/h",
    "accelerometer scale factor asymmetry 12.34 of 15.00 ppm",
    "gyroscope non-orthogonality between x and y 12.34 of 15.00 arcsec",
)


@pytest.mark.parametrize("text", TEXTS)
async def test_both_numbers_and_the_unit_stand_in_the_line(text: str) -> None:
    view = views.FILLING.model_copy(update={"limits": (LimitView(text=text, share=0.5),)})
    async with screens(view) as seen:
        await seen.pilot.pause()
        line = next(line for line in seen.lines() if "LIMITS" in line)
        assert text in line
