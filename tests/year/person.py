"""The operator: does what the screen says, mostly; slips, looks away, answers wrongly, begins again."""

from dataclasses import dataclass

import numpy as np

from drivers.simulated.bench_control import BenchControl
from station.guide.engine import CalibrationEngine
from station.guide.simulated_operator import SimulatedOperator
from station.guide.view import CalibrationView, CommandVerb, OperatorCommand, OperatorQuestion
from tests.year.machine import InProcessHands, Machine

OFF_DEG = 3.0  # of a cube put down on a crumb, at most
THINKS_S = 4.0


@dataclass(frozen=True, slots=True)
class Manner:
    """How careful somebody is: shares of moves and rounds in which the thing happens."""

    wrong_share: float = 0.0  # another position than wanted
    debris_share: float = 0.0  # put down tilted
    tremor_share: float = 0.0  # carried as hands carry
    pause_rate: float = 0.0  # 1/s
    redo_rate: float = 0.0  # 1/s
    lie_share: float = 0.0  # of answers that are wrong
    keep_share: float = 0.0  # of bad seats that are kept as they are


class Carrying:
    """How this person carries a cube, as `station.guide.simulated_operator.HandlingStyle` is asked."""

    def __init__(self, machine: Machine, manner: Manner, rng: np.random.Generator) -> None:
        self._machine, self._manner, self._rng = machine, manner, rng

    def carry(self, hands: BenchControl, position: int, move_s: float) -> tuple[float, bool]:
        """Carry the cube towards ``position``; return when [s] that is over, and whether it is right."""
        rng, manner, wrong = self._rng, self._manner, position
        if rng.random() < manner.wrong_share:
            wrong = int(rng.choice([p for p in range(1, 13) if p != position]))
        if rng.random() < manner.debris_share:
            tilt = np.degrees(rng.choice([3e-5, 3e-4, 3e-3, np.radians(OFF_DEG)])) * rng.standard_normal(3)
            words = hands.say(f"place {wrong} {move_s} {tilt[0]:.6f} {tilt[1]:.6f} {tilt[2]:.6f}")
            return float(words[-1]), False
        if rng.random() < manner.tremor_share:
            return hands.carry(
                wrong, move_s, float(rng.uniform(20, 60)), float(rng.uniform(0, 3))
            ), wrong == position
        return hands.place(wrong, move_s), wrong == position


class Person:
    """Looks at each view of an engine."""

    def __init__(self, machine: Machine, manner: Manner, rng: np.random.Generator, at: str = "hands") -> None:
        self._machine, self._manner, self._rng, self._at = machine, manner, rng, at
        self._answers_at: float | None = None
        self._goes_on_at: float | None = None
        self._looked = machine.clock.now
        self.lies = 0
        self.comes()

    def comes(self) -> None:
        """Begin afresh, with another power-on or another program."""
        carrying = Carrying(self._machine, self._manner, self._rng)
        move_s = float(self._rng.uniform(4.0, 9.0))
        behind_s = self._machine.bench.now.clock_off[-1]
        hands = InProcessHands(self._machine.of(self._at), self._at)
        self._hands = SimulatedOperator(hands, move_s, carrying, behind_s)  # type: ignore[arg-type]  # carries as one
        self._answers_at = self._goes_on_at = None

    def look(self, engine: CalibrationEngine) -> None:
        """Do what is to be done now."""
        view, now, rng = engine.view, self._machine.clock.now, self._rng
        dt, self._looked = now - self._looked, now
        if view.stage == "warm_up":
            self._send(engine, "skip_warm_up")
        elif view.question is not None:
            self._answer(engine, view.question, now)
        elif view.stage == "paused":
            self._go_on(engine, now)
        elif rng.random() < self._manner.pause_rate * dt:
            self._send(engine, "pause")
        elif view.can_redo and rng.random() < self._manner.redo_rate * dt:
            self._do_again(engine, view)
        elif view.gates is not None and not view.gates.is_seated and rng.random() < self._manner.keep_share * dt:
            self._send(engine, "keep_seating")
        self._answers_at = self._answers_at if engine.view.question is not None else None
        if engine.is_busy:
            engine.move_cube_by(self._hands)

    def _send(self, engine: CalibrationEngine, verb: CommandVerb, **what: str) -> None:
        self._machine.say(f"operator: {' '.join([verb, *what.values()])}")
        engine.execute(OperatorCommand.model_validate({"verb": verb, **what}))

    def _do_again(self, engine: CalibrationEngine, view: CalibrationView) -> None:
        done = [step.name for step in view.steps if step.attempts]
        others = [step.name for step in view.steps if not step.attempts]
        if others and self._rng.random() < 0.5:
            self._send(engine, "choose", step=str(self._rng.choice(others)))
        else:
            self._send(engine, "redo", step=str(self._rng.choice(done)))

    def _go_on(self, engine: CalibrationEngine, now: float) -> None:
        if self._goes_on_at is None:
            self._goes_on_at = now + float(self._rng.exponential(20.0))
        elif now >= self._goes_on_at:
            self._goes_on_at = None
            self._send(engine, "go_on")

    def _answer(self, engine: CalibrationEngine, question: OperatorQuestion, now: float) -> None:
        if self._answers_at is None:
            self._answers_at = now + float(self._rng.exponential(THINKS_S))
        elif now >= self._answers_at:
            self._answers_at = None
            keys = [choice.key for choice in question.choices]
            key = self._truth(question, keys)
            if self._rng.random() < self._manner.lie_share:
                key = str(self._rng.choice(keys))
                self.lies += 1
            self._machine.say(f"asked: {question.text}")
            self._send(engine, "answer", key=key)

    def _truth(self, question: OperatorQuestion, keys: list[str]) -> str:
        """Return what is so, where this person can see it; else a choice."""
        position = self._machine.bench.device.imu.position
        if str(position) in keys:
            return str(position)
        if any(key.isdigit() for key in keys):  # which position, and it is none of them
            return next(key for key in keys if not key.isdigit())
        if question.text.startswith("The cube is tilted"):
            return "n"
        for key in ("r", "y"):  # what stood crooked is recorded again; it is the same unit
            if key in keys:
                return key
        return str(self._rng.choice(keys))
