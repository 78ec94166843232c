"""What a guided calibration shows and what an operator can ask: one frozen value each, as JSON between processes.

The engine makes a `CalibrationView` with all that a screen, a line of text or a test needs; a screen draws it and
sends an `OperatorCommand`. Angles in deg, rates in deg/s, times in s of the device unless a name says otherwise.
"""

from typing import Literal, Protocol

from station.files.campaign_setup import Setup
from station.guide.setup_view import Choice, FrozenValue, Readiness, StartView
from station.stream.stream_events import Event

StageName = Literal[
    "start",  # no campaign yet: set-up, and unfinished ones to resume
    "connecting",
    "warm_up",
    "place",  # the cube is to be put somewhere, or turned: `View.wanted` says where
    "settle",  # it is on its way to rest on the right face
    "dwell",  # accepted seconds are counted
    "turn",  # a hand turn is under way
    "paused",
    "solving",
    "verdict",
    "stored",  # the verdict, and the calibration is in the database
    "cancelled",
    "left",  # to be resumed another day
    "failed",  # it cannot go on; `View.error` says why. What was accepted is safe
]
ENDED_STAGES: frozenset[StageName] = frozenset({"cancelled", "left", "failed"})
VERDICT_STAGES: frozenset[StageName] = frozenset({"verdict", "stored"})
StepState = Literal["todo", "live", "done", "redo"]


class StepView(FrozenValue):
    """A step of the campaign, in the order suggested. ``position`` is 0 for a turn, ``axis`` empty for a dwell.

    ``repeat``: how many dwells in its position come before it. Free positions and soaks have a ``number`` of their
    own; ``is_free``: in a free attitude; ``up``: the face of a soak that has no position.

    ``attempts`` counts accepted recordings, of which all but the last are superseded.
    """

    name: str
    state: StepState
    position: int = 0
    repeat: int = 0
    number: int = 0
    is_free: bool = False
    is_soak: bool = False
    is_monitor: bool = False
    up: str = ""
    axis: str = ""
    direction: str = ""
    revolutions: int = 0
    start_position: int = 0
    attempts: int = 0
    seconds: float = 0.0
    note: str = ""

    @property
    def superseded(self) -> int:
        """How many earlier recordings stand behind the one that counts."""
        return max(self.attempts - 1, 0)


class GatesView(FrozenValue):
    """The two gates, and what the counts show right now.

    ``face`` is the face that is up (``x_up`` ...), ``off_deg`` the angle it seems off the vertical against
    ``limit_deg``; ``still`` the live sigma over this unit's own noise, in ``still_channel``, against
    ``still_limit``. ``is_free``: the gate is that of a free attitude, far from faces. ``position`` 0: the heading
    is not known (yet); ``heading`` says how it was found.
    """

    face: str = ""
    off_deg: float = 0.0
    limit_deg: float = 3.0
    is_right_face: bool = False
    is_wanted_face: bool = True  # else another one on which something is to do as well
    is_free: bool = False
    still: float = 0.0
    still_limit: float = 4.0
    still_channel: str = ""
    is_still: bool = False
    position: int = 0
    heading: str = ""  # "by the Earth rate", "as you said", "reading the Earth rate", "not known"
    seating: str = ""  # "seated within 3 arcsec", or why to lift, wipe and set down
    is_seated: bool = True


class TurnView(FrozenValue):
    """A hand turn: revolutions so far (signed, about the axis), speed against its limits, how long it rests."""

    revolutions: float = 0.0
    wanted: int = 3
    speed_deg_s: float = 0.0
    slow_deg_s: float = 5.0
    fast_deg_s: float = 100.0
    rest_s: float = 0.0
    rest_wanted_s: float = 5.0
    may_begin: bool = True  # or is under way; it may not before the rest, and before the heading is known
    is_back: bool = False  # it has made its revolutions and rests

    @property
    def is_to_rest(self) -> bool:
        """Whether the cube is to be let alone: before the turn, and once it has come back."""
        return not self.may_begin or self.is_back


class PoseView(FrozenValue):
    """The cube as it stands, from the counts; ``text`` says what is left to do, or that it stands as wanted.

    ``C_lb``: what East, North and Up each are along the cube's axes, row by row; East and North mean nothing where
    ``heading_std_deg`` is None. ``turn_deg``: by how much to turn it about the vertical, counter-clockwise from
    above; None unless the face is the right one and the heading known.
    """

    C_lb: tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
    heading_std_deg: float | None = None
    turn_deg: float | None = None
    text: str = ""


class SoakView(FrozenValue):
    """A soak: the temperature now and its range so far [degC], None where the device says none; time left [s]."""

    temperature_c: float | None = None
    low_c: float | None = None
    high_c: float | None = None
    left_s: float = 0.0


class FilterView(FrozenValue):
    """What a filter reads [deg], of the axes that lie north, east, down where the cube is to stand."""

    name: str
    roll_deg: float
    pitch_deg: float


class MonitoredView(FrozenValue):
    """A monitor step: what each filter reads, the angle between two; ``text``: why not."""

    filters: tuple[FilterView, ...] = ()
    difference_deg: float | None = None
    text: str = ""


class WarmUpView(FrozenValue):
    """Warm-up; limits are learnt from this unit. ``left_s`` None: not known yet."""

    seconds: float = 0.0
    left_s: float | None = None
    temperature_rate_c_min: float | None = None
    temperature_limit_c_min: float | None = None
    gyro_drift_deg_h: float | None = None
    gyro_limit_deg_h: float | None = None
    note: str = ""


class LimitView(FrozenValue):
    """A sigma that is wanted: how far it is, such as ``gyroscope bias 0.013 of 0.020 deg/h``.

    ``share`` is that of the information: the square of wanted over reached, 1 where it is met.
    """

    text: str
    share: float


class LinkView(FrozenValue):
    """The stream: ``is_live`` False while nothing comes that can be used; ``text`` says what is wrong, what to do.

    ``word`` is what is wrong in two words, such as NO DATA, WRONG UNIT.
    """

    name: str = ""
    rate_hz: float = 0.0
    bad_frames: int = 0
    lost: int = 0
    gaps: int = 0
    temperature_c: float | None = None
    is_live: bool = True
    word: str = ""
    text: str = ""


class OperatorQuestion(FrozenValue):
    """Something only the operator knows; answered with the ``key`` of a choice."""

    text: str
    choices: tuple[Choice, ...]


class VerdictRow(FrozenValue):
    """A line of the verdict's table, all of it text.

    ``sigma`` is the combined standard uncertainty, by which a guarded limit is narrowed; ``expanded`` is U (95 %),
    empty where there is no budget.
    """

    name: str
    value: str
    sigma: str
    expanded: str = ""
    unit: str
    limit: str = ""
    verdict: str = ""  # PASS, FAIL, NOT_MEASURED or empty
    change: str = ""  # since the unit's last calibration


class Verdict(FrozenValue):
    """The end: one sentence, then what stands behind it.

    ``doubt`` says why it is not to be relied on whatever the word; the sentence says it too. ``redo`` names the
    step that had better be done again.
    """

    word: Literal["PASS", "FAIL", "NOT_MEASURED"]
    in_words: str = ""  # the word as people read it, where that is another one
    sentence: str
    doubt: str = ""
    status: Literal["calibrated", "measured"]
    status_reason: str = ""
    worst_residual: str = ""
    change: str = ""
    diagnosis: str = ""
    diagnosis_text: str = ""  # all of it, as `station diagnose` prints it
    rows: tuple[VerdictRow, ...] = ()
    warnings: tuple[str, ...] = ()
    redo: str = ""
    report: str = ""  # path
    solution: str = ""
    stored_sha256: str = ""


class CalibrationView(FrozenValue):
    """Everything.

    ``line`` is the state as one plain sentence. ``hint`` says what hinders or what comes next. ``wanted`` and
    ``live`` name steps; ``live`` is empty while none is being recorded. ``remaining_s`` is the time still needed
    with no break. ``can_redo`` names the step that "redo" would do again. ``tilt`` is which way of the cube, in
    its axes, is to be up where a free attitude is wanted. ``time_s`` is the device's time up to which the stream
    was looked at; None where it sends none that goes on. ``limits`` are the sigmas that a campaign goes on
    for; where all are met one placement more ``can_do_more``.
    """

    stage: StageName = "start"
    time_s: float | None = None
    line: str = ""
    hint: str = ""
    unit: str = ""  # "SIM-FOG3 SIM-7"
    folder: str = ""
    start: StartView | None = None
    readiness: Readiness | None = None  # of the campaign, once the unit has answered
    steps: tuple[StepView, ...] = ()
    wanted: str = ""
    live: str = ""
    can_redo: str = ""
    can_do_more: bool = False
    accepted_s: float = 0.0
    wanted_s: float = 0.0
    remaining_s: float = 0.0
    gates: GatesView | None = None
    pose: PoseView | None = None
    turn: TurnView | None = None
    soak: SoakView | None = None
    monitored: MonitoredView | None = None
    limits: tuple[LimitView, ...] = ()
    tilt: tuple[int, int, int] | None = None
    warm_up: WarmUpView | None = None
    link: LinkView = LinkView()
    question: OperatorQuestion | None = None
    events: tuple[Event, ...] = ()  # the last few
    verdict: Verdict | None = None
    error: str = ""
    code: int = 0  # the program's exit code for an end that was nobody's wish

    def step(self, name: str) -> StepView | None:
        """Return a step by its name."""
        return next((step for step in self.steps if step.name == name), None)

    @property
    def done(self) -> int:
        """How many steps are accepted."""
        return sum(step.attempts > 0 for step in self.steps)


CommandVerb = Literal[
    "check",  # look at the port `url` for two seconds
    "listen",  # to the GNSS receiver `url` for a few seconds
    "consider",  # `setup` as it stands: how ready is it
    "begin",  # a new campaign as `setup` says
    "resume",  # the campaign in `folder`
    "skip_warm_up",
    "choose",  # do `step` next
    "redo",  # do `step` again; empty: the one that `View.can_redo` names
    "pause",
    "go_on",
    "answer",  # the question, with `key`
    "keep_seating",  # accept the cube as it sits
    "finish",  # solve with what is there
    "more",  # one placement more though all that is wanted is met
    "store",  # the calibration: the operator's act
    "leave",  # end here, to be resumed
    "cancel",  # end here, the database as it was
]


class OperatorCommand(FrozenValue):
    """A verb and what belongs to it."""

    verb: CommandVerb
    setup: Setup | None = None
    url: str = ""
    folder: str = ""
    step: str = ""
    key: str = ""


class CalibrationSession(Protocol):
    """An engine as its screens see it, which know of no socket; both return at once."""

    @property
    def view(self) -> CalibrationView:
        """The newest view."""

    def send(self, command: OperatorCommand) -> None:
        """Ask something of the engine."""
