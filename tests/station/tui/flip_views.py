"""A campaign of flips among all 24 positions of a cube, made by hand as `tests.station.tui.views`."""

from procedures.positions import ATTITUDES
from station.guide.view import GatesView, StepView
from station.stream.stream_events import Event
from tests.station.tui.views import pose, running

ORDER = "ENU ESD USE DSW SUW NDW NWU SWD SDE DES EUS EDN".split()
NUMBERS = [ATTITUDES.index(axes) + 1 for axes in ORDER]
STEPS = tuple(
    StepView(
        name=f"dwell_{p:02d}", state="done" if n < 4 else "todo", position=p, attempts=int(n < 4), seconds=100.0
    )
    for n, p in enumerate(NUMBERS)
)
SDE = ATTITUDES.index("SDE") + 1
FLIPPING = running(
    "place",
    steps=STEPS, wanted="dwell_20", live="", can_redo="dwell_04",
    line="put the cube in position SDE: X south, Y down, Z east",
    hint="", pose=pose(SDE, 90.0, turn_deg=-90.0, text="turn 90 deg more, clockwise from above"),
    gates=GatesView(face="y_down", off_deg=0.3, is_right_face=True, still=1.1, still_channel="gyro z",
                    is_still=True, heading="not known"),
    events=(
        Event(number=8, sound="accepted",
              text="accepted: position 4, no transfer to it: samples were lost, 4 of 12"),
        Event(number=9, sound="rejected", text="moved too fast: 4 arcsec of coning; at least 6 s for a flip"),
    ),
)  # fmt: skip
