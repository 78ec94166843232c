"""Set-up: what is typed and chosen becomes what is sent, and what is wrong is said."""

import pytest
from textual.events import Key

from station.files.campaign_setup import Setup
from station.guide.setup_view import Choice, PortCheck, Readiness, ReadyLine, StartView
from station.guide.view import CalibrationView, OperatorCommand
from station.tui.screens.modals import HelpScreen, ReadyScreen
from station.tui.screens.start import CONSIDER_S
from station.tui.widgets.setup_entries import ENTRIES, MISSING, problems, setup_of, texts_of
from tests.station.tui import start_views
from tests.station.tui.session import Screens, screens

URL = "tcp://rig:5000?format=counts"
RIG = Choice(key=URL, title="rig")
FRESH = CalibrationView(stage="start", start=StartView(setup=Setup(url=URL), ports=(RIG,)))
SETUP = start_views.START.start.setup


def of_start(**update: object) -> CalibrationView:
    """Return the start screen, with nothing known of how ready it is unless that is given."""
    start = start_views.START.start.model_copy(update={"readiness": None, **update})
    return start_views.START.model_copy(update={"start": start})


def reported(seen: Screens) -> str:
    return seen.app.screen.message.render().plain


async def fill(seen: Screens, name: str, text: str) -> None:
    field = seen.app.screen.form.fields[name].input
    field.focus()
    field.value = text[:-1]
    field.cursor_position = len(field.value)
    await seen.press(text[-1])


async def test_enter_goes_on_with_the_campaign_on_top() -> None:
    async with screens(start_views.START) as seen:
        await seen.press("enter")
        assert seen.sent == [OperatorCommand(verb="resume", folder=start_views.FOLDER, url=start_views.URL)]


async def test_campaigns_in_use_or_not_here_are_shown_and_cannot_be_chosen() -> None:
    async with screens(start_views.START) as seen:
        options = seen.app.screen.unfinished
        assert [options.get_option_at_index(i).disabled for i in range(3)] == [False, True, True]
        await seen.press("down", "down", "enter")
        assert seen.sent == [OperatorCommand(verb="resume", folder=start_views.FOLDER, url=start_views.URL)]


@pytest.mark.parametrize(
    ("check", "sent"),
    [
        (PortCheck(url=SETUP.url, is_good=True, serial=""), SETUP.url),
        (PortCheck(url=SETUP.url, is_good=True, serial="SIM-8"), ""),
        (PortCheck(url=SETUP.url, is_good=False), ""),
        (PortCheck(url="tcp://else:1", is_good=True), ""),
        (None, ""),
    ],
)
async def test_a_campaign_goes_on_at_the_port_looked_at_if_its_unit_may_be_there(
    check: PortCheck | None, sent: str
) -> None:
    async with screens(of_start(check=check)) as seen:
        await seen.press("enter")
        assert seen.sent == [OperatorCommand(verb="resume", folder=start_views.FOLDER, url=sent)]


async def test_what_is_remembered_is_filled_in_and_sent_back_as_it_was() -> None:
    async with screens(of_start()) as seen:
        await seen.press("ctrl+s")
        expected = SETUP.model_copy(update={"model": "SIM-FOG3", "serial": "SIM-7"})
        assert seen.sent == [OperatorCommand(verb="begin", setup=expected)]


async def test_a_question_mark_opens_help_except_within_text() -> None:
    async with screens(FRESH) as seen:
        field = seen.app.screen.form.fields["model"].input
        field.focus()
        await seen.press("question_mark")
        assert isinstance(seen.app.screen, HelpScreen)
        await seen.press("escape")
        await fill(seen, "model", "FOG3")
        await seen.press("question_mark")
        assert field.value == "FOG3?"


async def test_what_is_typed_is_sent() -> None:
    async with screens(FRESH) as seen:
        typed = {"latitude_deg": "48.137", "height_m": "520", "operator": "M. Huber", "dwell_s": "0",
                 "bias_ug": "0.5", "revolutions": "5", "serial": "A-7"}  # fmt: skip
        for name, text in typed.items():
            await fill(seen, name, text)
        await seen.press("ctrl+s")
        expected = Setup(
            url="tcp://rig:5000?format=counts", latitude_deg=48.137, height_m=520.0, operator="M. Huber",
            dwell_s=0.0, bias_ug=0.5, revolutions=5, serial="A-7",
        )  # fmt: skip
        assert seen.sent == [OperatorCommand(verb="begin", setup=expected)]


async def test_a_wrong_value_is_reported_in_words_as_it_is_typed() -> None:
    async with screens(FRESH) as seen:
        await fill(seen, "latitude_deg", "95")
        assert reported(seen) == "✗ Latitude 95 is out of range, expected a number from -90 to 90 deg"
        assert seen.app.screen.form.fields["latitude_deg"].has_class("wrong")
        await fill(seen, "latitude_deg", "45")
        assert reported(seen) == ""
        assert not seen.app.screen.form.fields["latitude_deg"].has_class("wrong")


async def test_begin_names_all_that_is_missing_at_once() -> None:
    async with screens(CalibrationView(stage="start", start=StartView(setup=Setup()))) as seen:
        await seen.press("ctrl+s")
        assert seen.sent == []
        found = [name for name in ("Address", "Latitude", "Dwell", "GNSS") if name in reported(seen)]
        assert found == ["Address", "Latitude"]
        assert seen.app.focused is seen.app.screen.form.fields["url"].input
        await fill(seen, "height_m", "1e9")
        await seen.press("ctrl+s")
        assert [name for name in ("Address", "Latitude", "Height") if name in reported(seen)] == [
            "Address", "Latitude", "Height",
        ]  # fmt: skip


@pytest.mark.parametrize("key", ["tab", "shift+tab"])
async def test_an_address_is_looked_at_when_its_field_is_left(key: str) -> None:
    async with screens(FRESH) as seen:
        await fill(seen, "url", "tcp://x:1")
        await seen.press(key)
        assert seen.sent == [OperatorCommand(verb="check", url="tcp://x:1")]
        seen.app.screen.form.fields["url"].input.focus()
        await seen.press(key)
        assert len(seen.sent) == 1  # once for each address


@pytest.mark.parametrize("go", ["tab", "enter"])
async def test_keys_typed_faster_than_they_are_drawn_stay_in_their_fields(go: str) -> None:
    async with screens(FRESH) as seen:
        fields = seen.app.screen.form.fields
        fields["height_m"].input.value = ""
        fields["latitude_deg"].input.focus()
        await seen.pilot.pause()
        keys = ["4", "8", ".", "1", go, "1", "1", ".", "5", go, "5", "2", "0", go, *"berg"]
        for key in keys:  # all before the first is looked at
            seen.app.post_message(Key(key, None if key == go else key))
        for _ in range(5):
            await seen.pilot.pause()
        texts = seen.app.screen.form.texts()
        assert [texts[name] for name in ("latitude_deg", "longitude_deg", "height_m", "operator")] == [
            "48.1", "11.5", "520", "berg",
        ]  # fmt: skip


async def test_an_answer_of_the_device_does_not_move_what_is_being_typed() -> None:
    async with screens(FRESH) as seen:
        fields = seen.app.screen.form.fields
        fields["model"].input.focus()
        await seen.press("F", "O")
        check = PortCheck(url=URL, is_good=True, model="SIM-FOG3", serial="SIM-7")
        start = FRESH.start.model_copy(update={"check": check}) if FRESH.start else None
        await seen.show(FRESH.model_copy(update={"start": start}))
        await seen.press("G")
        texts = seen.app.screen.form.texts()
        assert (texts["model"], texts["serial"], texts["gnss"]) == ("FOG", "SIM-7", "")
        await seen.press("tab")
        assert fields["model"].input.value == "SIM-FOG3"
        assert fields["model"].input.disabled


async def test_a_newcomer_reaches_each_field_that_must_be_typed_by_few_keys() -> None:
    """Without ports, cubes and slabs to choose, Tab goes over their lists."""
    async with screens(CalibrationView(stage="start", start=StartView(setup=Setup()))) as seen:
        fields = seen.app.screen.form.fields
        assert seen.app.focused is fields["url"].input
        for name in ("model", "serial", "gnss", "latitude_deg"):
            await seen.press("tab")
            assert seen.app.focused is fields[name].input
        await seen.show(CalibrationView(stage="start", start=StartView(setup=Setup(), ports=(RIG,))))
        assert not seen.app.screen.form.port.select.disabled  # one was plugged in


async def test_what_the_device_sends_is_not_missing_in_an_empty_field_with_the_cursor() -> None:
    async with screens(FRESH) as seen:
        field = seen.app.screen.form.fields["model"]
        field.input.focus()
        await seen.pilot.pause()
        check = PortCheck(url=URL, is_good=True, model="SIM-FOG3", serial="SIM-7")
        await seen.show(CalibrationView(stage="start", start=StartView(setup=Setup(url=URL), check=check)))
        assert field.input.value == "SIM-FOG3"
        assert not field.has_class("wrong")
        assert seen.app.focused is field.input
        await seen.press("tab")
        assert field.input.disabled


async def test_a_wrong_address_of_a_receiver_is_reported_and_not_listened_to() -> None:
    async with screens(FRESH) as seen:
        await fill(seen, "gnss", "receiver")
        expected = "'receiver' is no receiver, expected mavlink:udpin:0.0.0.0:14550, udpout or tcp"
        assert f"✗ GNSS {expected}" in reported(seen)
        await seen.press("enter", "ctrl+s")
        assert seen.sent == []
        assert seen.app.focused is seen.app.screen.form.fields["gnss"].input


async def test_what_the_receiver_says_stands_below_its_address() -> None:
    base = start_views.WITH_RECEIVER
    async with screens(base) as seen:
        for receiver, is_listening, expected in (
            (None, True, "checking the receiver"),
            (None, False, "not checked yet"),
            (base.start.receiver, False, "✓ 48.137251, 11.575498 deg, 568.3 m, u 1.2 m"),
            (PortCheck(url=start_views.GNSS, is_good=False, text="no fix"), False, "✗ no fix"),
            (PortCheck(url="mavlink:tcp:x:1", is_good=True, text="48"), False, "not checked yet"),
        ):
            start = base.start.model_copy(update={"receiver": receiver, "is_listening": is_listening})
            await seen.show(base.model_copy(update={"start": start}))
            assert expected in seen.app.screen.form.heard.render().plain


async def test_a_look_says_what_came() -> None:
    async with screens(start_views.START) as seen:
        for check, expected in (
            (start_views.START.start.check, "✓ counts, SIM-FOG3 SIM-7, 100.0 Hz, 0 of 200 frames bad"),
            (PortCheck(url=SETUP.url, is_good=False, text="no byte within 2 s"), "✗ no byte within 2 s"),
            (PortCheck(url="tcp://else:1", is_good=True), "not checked yet"),
        ):
            await seen.show(of_start(check=check))
            assert expected in seen.app.screen.form.look.render().plain


async def test_a_device_that_says_its_serial_number_fills_it_in_and_one_that_does_not_is_asked_for() -> None:
    async with screens(start_views.START) as seen:
        serial = seen.app.screen.form.fields["serial"].input
        assert (serial.value, serial.disabled) == ("SIM-7", True)
        silent = PortCheck(url=SETUP.url, is_good=True, format="counts", model="RIG", frames=200)
        await seen.show(of_start(check=silent, setup=SETUP.model_copy(update={"operator": "B"})))
        assert (serial.value, serial.disabled) == ("", False)
        await seen.press("ctrl+s")
        assert seen.sent == []
        assert "Serial no. is required" in reported(seen)


async def test_an_expired_certificate_is_a_warning_with_the_cube_and_one_in_force_is_not() -> None:
    async with screens(start_views.START) as seen:
        form = seen.app.screen.form
        assert "! certificate expired on 2026-02-01" in form.cube._note.render().plain  # noqa: SLF001
        form.cube.choose("CUBE-8")
        await seen.pilot.pause()
        assert form.cube._note.render().plain == "✓ certificate due 2027-11-22"  # noqa: SLF001
        assert not form.cube._note.has_class("warns")  # noqa: SLF001


READY = Readiness(
    lines=(ReadyLine(name="limits", state="ready", text="24 for SIM-FOG3"),), can_pass=True, can_certify=True
)


async def test_what_lacks_stands_below_the_form_and_line_by_line_before_it_begins() -> None:
    async with screens(start_views.START) as seen:
        text = "\n".join(seen.lines())
        assert "✗ can end in PASS: no, no limits are stored for SIM-FOG3" in text
        assert "✗ can end in a certificate: no, ctrl+r for details" in text
        await seen.press("ctrl+s")
        assert isinstance(seen.app.screen, ReadyScreen)
        await seen.pilot.pause()
        text = "\n".join(seen.lines())
        for word in ("✗ limits", "✓ operator  M. Huber", "✗ cube      CUBE-7, its certificate expired", "· site"):
            assert word in text
        assert "y  Begin anyway" in text
        await seen.press("n")
        assert seen.sent == []
        await seen.press("ctrl+s", "y")
        assert [command.verb for command in seen.sent] == ["begin"]


@pytest.mark.parametrize("readiness", [READY, READY.model_copy(update={"can_pass": None})])
async def test_what_lacks_nothing_begins_at_once_and_the_list_can_be_asked_for(readiness: Readiness) -> None:
    async with screens(of_start(readiness=readiness)) as seen:
        await seen.press("ctrl+r")
        await seen.pilot.pause()
        assert "✓ limits    24 for SIM-FOG3" in "\n".join(seen.lines())
        await seen.press("y", "escape", "ctrl+s")
        assert [command.verb for command in seen.sent] == ["begin"]


async def test_the_engine_receives_what_stands_in_the_form_as_far_as_it_is_right() -> None:
    async with screens(of_start()) as seen:
        await fill(seen, "operator", "A. Weber")
        await fill(seen, "latitude_deg", "north")
        await seen.pilot.pause(2 * CONSIDER_S)
        await seen.pilot.pause()  # what was due by then is done
        noticed = seen.session.considered[-1].setup
        assert (noticed.operator, noticed.latitude_deg, noticed.cube) == ("A. Weber", None, "CUBE-7")
        count = len(seen.session.considered)
        await seen.press("tab")
        await seen.pilot.pause(2 * CONSIDER_S)
        await seen.pilot.pause()  # what was due by then is done
        assert len(seen.session.considered) == count  # nothing else stands there now


def test_a_set_up_survives_the_form_to_the_last_digit() -> None:
    full = SETUP.model_copy(update={"latitude_deg": 48.123456789, "bias_ug": 0.05, "folder": "/x"})
    assert setup_of(texts_of(full), full) == full
    assert problems(texts_of(full)) == {}


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("url", "", ""),
        ("latitude_deg", "", "-90 to 90 deg"),
        ("latitude_deg", "north", "'north'"),
        ("latitude_deg", "nan", "nan"),
        ("latitude_deg", "-90.01", "-90.01"),
        ("longitude_deg", "400", "400"),
        ("gravity_m_s2", "9.4", "9.5 to 10.1 m/s2"),
        ("gravity_m_s2", "", "uncertainty"),
        ("gravity_std_m_s2", "0", "0"),
        ("dwell_s", "", ""),
        ("dwell_s", "-1", "-1"),
        ("revolutions", "2.5", "1 to 100"),
        ("gnss", "mavlink:udp:0.0.0.0:14550", "udpin"),
        ("gnss", "mavlink:udpin:0.0.0.0", "udpin"),
    ],
)
def test_each_field_says_what_is_wrong_in_words(name: str, text: str, words: str) -> None:
    assert words in problems(texts_of(SETUP) | {name: text})[name]


def test_a_dwell_from_the_noise_needs_the_sigma_wanted() -> None:
    found = problems(texts_of(SETUP) | {"dwell_s": "0"})["bias_ug"]
    assert "is required" in found
    assert not found.startswith(MISSING)  # it is marked at once, as another field is why


def test_every_entry_is_a_field_of_the_set_up() -> None:
    assert {entry.name for entry in ENTRIES} <= set(Setup.model_fields)
