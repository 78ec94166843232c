"""What goes wrong in a campaign, drawn from its seed: on the line, with the machine, by hand, between sessions."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.faults import MAX_SYSTEM
from drivers.simulated.truth import Truth
from fixtures_db.database import Database
from fixtures_db.imu_models import set_limits
from tests.year.machine import Machine
from tests.year.person import Manner

Act = Callable[[Machine, np.random.Generator], str]


def _line(kind: str, most: int = 1, longest_s: float = 1.0) -> Act:
    def act(machine: Machine, rng: np.random.Generator) -> str:
        count, seconds = int(rng.integers(1, most + 1)), round(float(rng.uniform(0.2, longest_s)), 2)
        machine.bench.device.plant(kind, count, seconds)
        return f"{kind} {count} {seconds}"

    return act


def _clock_step(machine: Machine, rng: np.random.Generator) -> str:
    step = float(rng.choice([-3600.0, -61.0, -1.0, -0.02, 0.02, 1.0, 61.0, 3600.0]))
    machine.clock.ahead += step
    return f"the wall clock goes {step:+g} s"


def _held_up(machine: Machine, rng: np.random.Generator) -> str:
    seconds = float(rng.uniform(2.0, 20.0))
    machine.sleep(seconds)
    return f"the station is held up for {seconds:.1f} s"


def _reader_dies(machine: Machine, _: np.random.Generator) -> str:
    machine.reader_dies = True
    return "the reader dies"


def _shock(machine: Machine, rng: np.random.Generator) -> str:
    if machine.bench.device.imu.is_moving:
        return "no shock: it is carried"
    command = f"shock {rng.uniform(0.05, 2):.2f} {rng.uniform(0.002, 0.5):.3f}"
    machine.bench.say(command)
    return command


def _creep(machine: Machine, rng: np.random.Generator) -> str:
    if machine.bench.device.imu.is_moving:
        return "no creep: it is carried"
    command = f"creep {rng.uniform(3, 20):.1f} {rng.uniform(0.05, 0.5):.3f} 0 0"
    machine.bench.say(command)
    return command


def _wrong_unit(machine: Machine, rng: np.random.Generator) -> str:
    period = machine.bench.truth.sample_period_s
    seconds = float(rng.uniform(3.0, 15.0))
    machine.bench.swap(replace(Truth.example(9), sample_period_s=period), seconds)
    return f"another unit is connected for {seconds:.1f} s"


def _receiver(machine: Machine, rng: np.random.Generator) -> str:
    if machine.receiver is None:
        return "no receiver to fail"
    kind = str(rng.choice(RECEIVER_KINDS))
    seconds, size = round(float(rng.uniform(5, 60)), 1), float(rng.choice([1.0, 50.0, 3600.0]))
    machine.receiver.fails(kind, seconds, min(size, MAX_SYSTEM) if kind == "wrong_system" else size)
    return f"the receiver: {kind} {seconds} {size}"


TROUBLES: dict[str, Act] = {
    "garbage": _line("garbage", 200),
    "bad_crc": _line("bad_crc", 5),
    "lost": _line("lost", 20),
    "repeated": _line("repeated", 3),
    "stall": _line("stall", longest_s=6.0),
    "unplug": _line("unplug", longest_s=20.0),
    "counter_restart": _line("counter_restart"),
    "backlog": _line("backlog", longest_s=4.0),
    "half": _line("half", 5),
    "noise": _line("noise", longest_s=4.0),
    "wrong_baud": _line("wrong_baud", longest_s=4.0),
    "two_devices": _line("two_devices", longest_s=3.0),
    "restart": _line("restart", longest_s=5.0),
    "clock_jump": _line("clock_jump", longest_s=60.0),
    "counter_wrap": _line("counter_wrap", 50),
    "clock_step": _clock_step,
    "held_up": _held_up,
    "reader_dies": _reader_dies,
    "shock": _shock,
    "creep": _creep,
    "wrong_unit": _wrong_unit,
    "receiver": _receiver,
}
RECEIVER_KINDS = (
    "no_fix", "jump", "time_jump", "outage", "reboot", "bad_crc", "noise", "half", "repeated", "backlog",
    "wrong_system",
)  # fmt: skip
TROUBLES_AT_ONCE = 4.0  # troubles of a session, in the mean
ENDS = ("", "", "", "kill_write", "kill_write", "kill_time", "leave", "full_disk", "kill_end", "cancel")
STARTS_UTC = (  # seconds: before a leap second, a day of 23 and one of 25 hours, a year's end, a leap day
    1483228200.0, 1774746000.0, 1792887600.0, 1798761000.0, 1835395200.0, 1780000000.0, 1784567890.0,
)  # fmt: skip
REFERENCES = (*["all"] * 5, "no limits", "expired", "expires soon", "no operator", "withdrawn")
ZONES = ("UTC", "Europe/Berlin", "America/St_Johns", "Asia/Kathmandu", "Pacific/Kiritimati")


@dataclass(frozen=True, slots=True)
class Session:
    """One start of the program: what goes wrong at which second of it, and how it ends.

    ``end`` empty: as it should; ``at`` is the write or the second of it. ``pause_s`` is how long nobody is there
    afterwards; ``powers``: the unit is off meanwhile; ``older``: the database is taken back to an older schema.
    """

    troubles: tuple[tuple[float, str], ...]
    end: str
    at: float
    pause_s: float
    powers: bool
    older: bool
    pace_s: float


@dataclass(frozen=True, slots=True)
class Drawn:
    """All that is drawn of a campaign."""

    unit: int
    period_s: float
    ppm: float
    dwell_s: float
    start_utc: float
    zone: str
    manner: Manner
    references: str  # what the bench has: all, no limits, expired, expires soon, no operator, withdrawn
    older: bool  # the database it is begun with has an older schema
    neighbour: bool  # another station tries the same folder
    screen: bool
    receiver: str  # empty; or what it is for: time, or time and site
    other: bool  # another station has a campaign of its own
    sessions: tuple[Session, ...]


def draw(rng: np.random.Generator, most_sessions: int = 4) -> Drawn:
    """Draw a campaign."""
    careful = rng.random() < 0.5
    manner = Manner(tremor_share=0.3) if careful else Manner(
        wrong_share=float(rng.uniform(0, 0.15)), debris_share=float(rng.uniform(0, 0.15)), tremor_share=0.5,
        pause_rate=0.003, redo_rate=0.003, lie_share=0.0 if rng.random() < 0.8 else 0.3,
        keep_share=0.0 if rng.random() < 0.8 else 0.05,
    )  # fmt: skip
    return Drawn(
        unit=int(rng.integers(1, 400)),
        period_s=float(rng.choice([0.04, 0.05, 0.05])),
        ppm=float(rng.normal(0.0, 30.0)),
        dwell_s=float(rng.choice([6.0, 8.0])),
        start_utc=float(rng.choice(STARTS_UTC)) + float(rng.uniform(0, 600)),
        zone=str(rng.choice(ZONES)),
        manner=manner,
        references=(references := str(rng.choice(REFERENCES))),
        older=bool(rng.random() < 0.2),
        neighbour=bool(rng.random() < 0.3),
        screen=bool(rng.random() < 0.05),
        receiver=str(rng.choice(["", "", "", "time", "site"])),
        other=bool(rng.random() < 0.16) and references == "all",  # it would give the model limits again
        sessions=tuple(_session(rng) for _ in range(most_sessions)),
    )


def _session(rng: np.random.Generator) -> Session:
    calm = rng.random() < 0.3
    names = [] if calm else rng.choice(list(TROUBLES), rng.poisson(TROUBLES_AT_ONCE))
    end = str(rng.choice(ENDS))
    at = {"kill_write": float(rng.integers(1, 900)), "kill_end": float(rng.integers(1, 60))}
    return Session(
        troubles=tuple(sorted((float(rng.uniform(5, 500)), str(name)) for name in names)),
        end=end,
        at=at.get(end, float(rng.uniform(3, 500))),
        pause_s=float(rng.choice([5.0, 120.0, 3600.0, 86400.0, 20 * 86400.0])),
        powers=bool(rng.random() < 0.4),
        older=bool(rng.random() < 0.2),
        pace_s=float(rng.choice([0.5, 1.0, 1.0])),
    )


def withdraw_limits(database: Database, model: str) -> None:
    """Take a model's limits away."""
    with database.write() as session:
        set_limits(session, model, ())
