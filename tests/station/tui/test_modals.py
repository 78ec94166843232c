"""Questions, and modals while the campaign goes on under them."""

import random

import pytest
from textual.command import CommandPalette
from textual.events import Key

from station.guide.setup_view import Choice
from station.guide.view import CalibrationView, OperatorQuestion
from station.tui.screens import screen_for
from station.tui.screens.framed_screen import RUNNING
from station.tui.screens.modals import ConfirmScreen, HelpScreen, Modal, QuestionScreen
from tests.station.tui import views
from tests.station.tui.session import LARGE, SMALL, screens

PAIR = OperatorQuestion(
    text="Which position is it?",
    choices=(Choice(key="11", title="position 11"), Choice(key="12", title="position 12")),
)


@pytest.mark.parametrize(
    ("question", "keys", "answer"),
    [
        (views.ASKING.question, "4", "4"),
        (views.ASKING.question, "down down enter", "4"),
        (PAIR, "2", "12"),  # keys of two characters are answered by number
        (PAIR, "down enter", "11"),
    ],
)
async def test_a_question_is_answered_by_one_key(question: OperatorQuestion, keys: str, answer: str) -> None:
    async with screens(views.ASKING.model_copy(update={"question": question})) as seen:
        assert isinstance(seen.app.screen, QuestionScreen)
        await seen.press(*keys.split())
        assert [(command.verb, command.key) for command in seen.sent] == [("answer", answer)]
        seen.app.pull()  # the engine has not taken it yet: it is not asked twice
        assert not isinstance(seen.app.screen, QuestionScreen)


async def test_a_question_can_be_put_off_and_taken_up_and_cancel_is_there_all_the_time() -> None:
    async with screens(views.ASKING) as seen:
        await seen.press("escape")
        seen.app.pull()
        assert not isinstance(seen.app.screen, Modal)
        await seen.press("a")
        seen.app.pull()
        assert isinstance(seen.app.screen, QuestionScreen)
        await seen.press("escape", "c", "y")
        assert [command.verb for command in seen.sent] == ["cancel"]


async def test_a_question_that_is_gone_closes_itself_and_one_asked_again_opens() -> None:
    async with screens(views.ASKING) as seen:
        await seen.show(views.HOLDING)
        assert not isinstance(seen.app.screen, Modal)
        await seen.show(views.ASKING)
        assert isinstance(seen.app.screen, QuestionScreen)
        await seen.show(views.ASKING.model_copy(update={"question": PAIR}))
        assert seen.app.screen.question == PAIR


@pytest.mark.parametrize(("waiting", "then"), [(views.CONNECTING, views.WARMING), (views.SOLVING, views.PASSED)])
async def test_a_modal_over_a_screen_that_waits_stays_when_the_wait_is_over(
    waiting: CalibrationView, then: CalibrationView
) -> None:
    async with screens(waiting) as seen:
        await seen.press("q")
        await seen.show(then)
        assert isinstance(seen.app.screen, ConfirmScreen)
        await seen.press("n")
        seen.app.pull()
        assert type(seen.app.screen) is screen_for(then.stage)


async def test_a_modal_stays_while_it_fits_and_goes_when_it_does_not() -> None:
    async with screens(views.WARMING) as seen:
        await seen.press("c")
        await seen.show(views.PLACEMENT)  # another screen waits under the modal
        assert isinstance(seen.app.screen, ConfirmScreen)
        await seen.press("n")
        seen.app.pull()
        assert type(seen.app.screen) is screen_for("place")
        await seen.press("question_mark")
        assert isinstance(seen.app.screen, HelpScreen)
        await seen.show(views.SETTLING)
        assert not isinstance(seen.app.screen, Modal)
        await seen.press("c")
        await seen.show(views.BROKEN)
        assert type(seen.app.screen) is screen_for("failed")


async def test_keys_faster_than_the_screens_answer_once_and_close_nothing_else() -> None:
    async with screens(views.ASKING) as seen:
        for _ in range(3):
            seen.app.post_message(Key("3", "3"))
        await seen.pilot.pause()
        assert len(seen.app.screen_stack) == 2
        assert type(seen.app.screen) is screen_for("settle")
        assert [command.verb for command in seen.sent] == ["answer"]


async def test_the_palette_runs_an_action_by_its_name() -> None:
    async with screens(views.PLACEMENT) as seen:
        await seen.press("ctrl+p")
        assert isinstance(seen.app.screen, CommandPalette)
        await seen.press(*"pause")
        await seen.app.workers.wait_for_complete()
        await seen.press("enter")
        assert [command.verb for command in seen.sent] == ["pause"]


KEYS = ("question_mark", "ctrl+p", "escape", "down", "right", *"cynafrpbksq")
OVER = ("cancelled", "left", "failed")


async def test_views_and_keys_in_any_order_never_break_the_screens() -> None:
    chance = random.Random(1)
    every = [*views.VIEWS.values(), *(CalibrationView(stage=stage) for stage in RUNNING)]
    async with screens(CalibrationView(), LARGE) as seen:
        for _ in range(30):
            seen.session.view = chance.choice(every)
            seen.app.pull()
            if chance.random() < 0.3:
                await seen.pilot.pause()
            if chance.random() < 0.1:
                await seen.pilot.resize_terminal(*chance.choice([SMALL, LARGE, (30, 8), (81, 60)]))
            stage = seen.session.view.stage
            key = chance.choice(KEYS)
            if chance.random() < 0.3 and stage not in (*OVER, "stored") and not (stage == "start" and key == "q"):
                await seen.pilot.press(key)
        await seen.pilot.resize_terminal(*SMALL)
        await seen.show(views.HOLDING)
        for _ in range(4):  # whatever is still open
            if isinstance(seen.app.screen, screen_for("dwell")):
                break
            await seen.press("escape")
            seen.app.pull()
        await seen.pilot.pause()
        assert type(seen.app.screen) is screen_for("dwell")
        assert "62 of 100 s" in seen.app.screen.accepted.render().plain
