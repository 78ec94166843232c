"""What the set-up of a guided calibration holds and shows: its values, what can be chosen, how ready it is.

Parts of `station.guide.view.CalibrationView`; they cross a process border as JSON.
"""

from typing import Literal

from pydantic import BaseModel, ConfigDict

from station.files.campaign_setup import Setup

ReadyState = Literal["ready", "note", "lacks"]


class FrozenValue(BaseModel):
    """A part of a view; what it does not know is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Choice(FrozenValue):
    """One of a list: ``key`` is what is sent back, ``title`` what is shown; ``warns``: its note is of harm."""

    key: str
    title: str
    note: str = ""
    warns: bool = False


class PortCheck(FrozenValue):
    """A live look at a port: what its bytes are. ``noise`` says the white noise in words.

    Of a GNSS receiver ``text`` alone: where it stands, with sigma, or what is wrong.
    """

    url: str
    is_good: bool
    format: str = ""
    model: str = ""
    serial: str = ""
    output: str = ""  # "increments" or "rate"
    rate_hz: float | None = None
    frames: int = 0
    bad_frames: int = 0
    noise: str = ""
    text: str = ""


class ReadyLine(FrozenValue):
    """One thing that a campaign needs, or is better with. ``state``: lacks prevents what it is needed for."""

    name: str
    state: ReadyState
    text: str


class Readiness(FrozenValue):
    """What is there before a campaign begins, and how it can end.

    ``can_pass`` and ``can_certify`` are None while that is not known; ``no_pass`` and ``no_certificate`` say why
    not, empty where it can.
    """

    lines: tuple[ReadyLine, ...] = ()
    can_pass: bool | None = None
    no_pass: str = ""
    can_certify: bool | None = None
    no_certificate: str = ""

    @property
    def outcomes(self) -> tuple[str, str]:
        """Both consequences in words: of the verdict, and of a certificate."""
        if self.can_pass is None:
            passes = "PASS: not known before the unit's model is known"
        else:
            passes = "PASS: yes" if self.can_pass else f"PASS: no, {self.no_pass}"
        certified = "a certificate: yes" if self.can_certify else f"a certificate: no, {self.no_certificate}"
        return f"can end in {passes}", f"can end in {certified}"


class UnfinishedCampaign(FrozenValue):
    """A campaign that can be resumed. ``state``: free, in use (by another station), not here (no folder)."""

    folder: str
    title: str  # "campaign of 12:40, 7 of 18 done, SIM-FOG3 SIM-7"
    serial: str
    done: int
    state: Literal["free", "in use", "not here"]


class StartView(FrozenValue):
    """What the start screen offers."""

    setup: Setup = Setup()
    ports: tuple[Choice, ...] = ()
    cubes: tuple[Choice, ...] = ()  # note: "certificate expired on 2026-02-01"
    slabs: tuple[Choice, ...] = ()
    check: PortCheck | None = None
    is_checking: bool = False
    receiver: PortCheck | None = None
    is_listening: bool = False
    unfinished: tuple[UnfinishedCampaign, ...] = ()
    is_planned_on_the_way: bool = False  # it goes on until what is wanted is met
    readiness: Readiness | None = None  # of the set-up that was considered last
    refused: str = ""  # why what was sent could not begin
    refusals: int = 0  # how often that was so: the same words twice are two answers
    refused_code: int = 0  # the program's exit code for it, where nobody is there to try again
