"""What the top of the screen says is the one thing to do; steps and limits below it are whole."""

from station.guide.view import LimitView, TurnView
from station.tui.widgets.cube import is_counter_clockwise
from tests.station.tui import views
from tests.station.tui.flip_views import FLIPPING
from tests.station.tui.session import SMALL, screens
from tests.station.tui.test_messages import shown_in

BANNERS = [
    (views.PLACEMENT, "NOW put the cube in position 3", "hands off"),
    (views.SETTLING, "KEEP STILL hands off", "put the cube"),
    (views.BADLY_SEATED, "SET DOWN AGAIN lift the cube, wipe it and the plate", "position"),
    (views.TURNING, "TURN turn X-: 2.34 of 3 turns", "hands off"),
    (views.CAME_BACK, "KEEP STILL hands off: the cube rests after turn X-", "3 times"),
    (views.SILENT, "NO DATA check cable and power", "position"),
    (views.OTHER_UNIT, "WRONG UNIT connect the campaign's own unit", "NO DATA"),
    (views.WARMING, "WARM-UP leave the cube at rest", "put the cube"),
]


async def test_the_banner_says_one_thing() -> None:
    async with screens(views.CONNECTING) as seen:
        for view, reported, not_reported in BANNERS:
            await seen.show(view)
            await seen.pilot.pause()
            banner = shown_in(seen, seen.app.screen.banner)
            assert reported in banner
            assert not_reported not in banner


async def test_symbol_and_column_of_a_turn_are_those_of_the_turn_asked_for() -> None:
    turn = TurnView(revolutions=1.0, speed_deg_s=30.0)
    async with screens(views.CONNECTING) as seen:
        for step in [step for step in views.steps(12) if step.axis]:
            await seen.show(
                views.TURNING.model_copy(update={"live": step.name, "wanted": step.name, "turn": turn})
            )
            await seen.pilot.pause()
            symbol = "↺" if is_counter_clockwise(step) else "↻"
            assert f"{symbol} TURN" in shown_in(seen, seen.app.screen.banner)
            rows = seen.app.screen.grid.render().plain.split("\n")
            at = next(i for i, row in enumerate(rows) if "turn X, X up" in row)
            cell = f"▶{symbol} {step.axis.upper()}{step.direction}"
            assert cell in rows[at + 1]
            column = rows[at].index(f"turn {step.axis.upper()}, {step.axis.upper()} up")
            assert column - 2 <= rows[at + 1].index(cell) < column + 12  # below the heading of its own axis


TEXTS = (
    "gyroscope bias 0.0268 of 0.0200 deg/h",
    "accelerometer scale factor asymmetry 12.34 of 15.00 ppm",
    "gyroscope non-orthogonality between x and y 12.34 of 15.00 arcsec",
)


async def test_both_numbers_and_the_unit_of_a_limit_stand_in_its_line() -> None:
    async with screens(views.HOLDING) as seen:
        for text in TEXTS:
            await seen.show(views.FILLING.model_copy(update={"limits": (LimitView(text=text, share=0.5),)}))
            await seen.pilot.pause()
            assert text in next(line for line in seen.lines() if "LIMITS" in line)


async def test_a_position_named_by_its_axes_is_drawn_and_has_its_cell() -> None:
    async with screens(FLIPPING, SMALL) as seen:
        await seen.show(FLIPPING)
        text = "\n".join(seen.lines())
    assert "put the cube in position SDE: X south, Y down, Z east" in text
    assert "where X, Y, Z point" in text
    assert "▶SDE" in text
    assert "-Y up" in text
    assert "no transfer to it: samples were lost" in text
