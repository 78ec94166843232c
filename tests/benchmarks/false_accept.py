"""Is a dwell ever accepted that should not be, or one refused that should not be?

Each trial is a random unit whose cube is put down in one of `KINDS`; the guide has a minute of device time. An
accepted dwell is *tilted* if the cube was more than the face limit off the vertical, *mistaken* if in another
position. Refusing is wrong only of a flat cube, tapped or not.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell, Step
from procedures.positions import face_normal, face_of
from station.guide.checks.face_and_stillness import LIMIT_DEG
from station.stream.recorder.sample_buffer import SampleBuffer, SampleRun
from tests.proof.evidence import Figure, spread, zero
from tests.station.guide.rig import plain_guide
from tests.station.stream.live.bench_in_memory import Source

KINDS = ("flat", "tilted", "tilted a little", "wrong face", "tapped", "shaken", "creeping")
OUTCOMES = ("accepted", "refused", "tilted", "mistaken")
DWELL_S, PATIENCE_S, MOVE_S = 10.0, 60.0, 3.0


@dataclass
class Accepted:
    """In memory, as a `FolderRecorder`: steps, their first and last time [s]."""

    steps: list[tuple[Step, float, float]] = field(default_factory=list)

    def accept(
        self, step: Step, buffer: SampleBuffer, runs: Sequence[SampleRun], *_: object, **__: object
    ) -> None:
        first, last = buffer.block(runs[0][0], runs[0][0] + 1), buffer.block(runs[-1][1] - 1, runs[-1][1])
        self.steps.append((step, float(first.device_time[0]), float(last.device_time[0])))

    def ignore(self, *_: object, **__: object) -> None:
        """Take no notice."""

    keep_steps = keep_first_rest = widen_closure = keep_no_move = set_unsettled = ignore


def trial(seed: int) -> tuple[str, str]:
    """Return the kind of a trial and what came of it, one of `OUTCOMES`."""
    rng = np.random.default_rng([seed, 0xACC])
    source, accepted = Source(Truth.example(seed % 997), seed=seed), Accepted()
    kind, position = KINDS[seed % len(KINDS)], int(rng.integers(1, 13))
    wanted = [Dwell(p, DWELL_S) for p in range(1, 13)] if rng.random() < 0.5 else [Dwell(position, DWELL_S)]
    feed, guide = plain_guide(source, wanted, accepted)
    stands = position if kind != "wrong face" else int(rng.choice([p for p in range(1, 13) if p != position]))
    tilt_deg = {"tilted": rng.uniform(0, 45), "tilted a little": rng.uniform(0, 6)}.get(kind, 0.0)
    tilt = tilt_deg * level_direction(stands, rng)
    source.device.execute(f"place {stands} {MOVE_S} {tilt[0]} {tilt[1]} {tilt[2]}")
    slip = disturb(kind, stands, source, rng)
    end = source.device.imu.time + PATIENCE_S
    while source.device.imu.time < end and not accepted.steps:
        feed.advance()
        for block in feed.ready():
            guide.take(block)
    return kind, judged(accepted, stands, tilt, slip)


def level_direction(position: int, rng: np.random.Generator) -> FloatArray:
    """Return a random unit vector (3,) in the cube's axes, level where the cube stands."""
    vector = rng.standard_normal(3) * (np.abs(face_normal(face_of(position))) < 0.5)
    return vector / np.linalg.norm(vector)


def disturb(kind: str, position: int, source: Source, rng: np.random.Generator) -> tuple[float, float, FloatArray]:
    """Have the cube tapped, shaken or slipping once it is down; return when [s] and how far [deg] it slips."""
    device = source.device
    if kind == "tapped":
        device.execute(f"rest {rng.uniform(2, 20)}")
        device.execute(f"knock {rng.uniform(0.1, 3)} {10 ** rng.uniform(-2, 0)}")
    elif kind == "shaken":
        device.execute(f"knock {PATIENCE_S} {10 ** rng.uniform(-2.5, -0.3)}")
    elif kind == "creeping":
        device.execute(f"rest {rng.uniform(0, 15)}")
        begins, seconds = device.imu.done, rng.uniform(5, 60)
        turn = 10 ** rng.uniform(-1, 1.3) * level_direction(position, rng)
        device.execute(f"creep {seconds} {turn[0]} {turn[1]} {turn[2]}")
        return begins, seconds, turn
    return 0.0, 1.0, np.zeros(3)


def judged(accepted: Accepted, stands: int, tilt: FloatArray, slip: tuple[float, float, FloatArray]) -> str:
    """Say what came of a trial."""
    if not accepted.steps:
        return "refused"
    step, first, last = accepted.steps[0]
    begins, seconds, turn = slip
    worst = max(float(np.linalg.norm(tilt + turn * np.clip((t - begins) / seconds, 0, 1))) for t in (first, last))
    is_right = isinstance(step, Dwell) and step.position == stands
    if worst > LIMIT_DEG:
        return "tilted"
    return "accepted" if is_right else "mistaken"


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return how often a wrong dwell was accepted, and a right one refused."""
    found: dict[str, Counter[str]] = {kind: Counter() for kind in KINDS}
    for kind, outcome in spread(trial, range(seed, seed + size), 20):
        found[kind][outcome] += 1
    right = found["flat"] + found["tapped"]
    return {
        "accepted beyond the limit of the face": zero(sum(count["tilted"] for count in found.values())),
        "accepted for another position, cube at rest": zero(
            sum(count["mistaken"] for kind, count in found.items() if kind != "creeping")
        ),
        "accepted for another position, cube slipping": _rare(found["creeping"], "mistaken"),
        "flat cube refused": _rare(right, "refused"),
    }


def _rare(found: Counter[str], outcome: str) -> Figure:
    return Figure(found[outcome], of=found.total(), at_most=found.total() / 100)
