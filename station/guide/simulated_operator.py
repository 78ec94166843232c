"""Moves the cube of a simulated device: it follows the instructions of the views as a person would."""

import time
from collections.abc import Callable

import numpy as np

from drivers.errors import ControlUnreachable, DriverError, SimulatorError
from drivers.simulated.bench_control import BenchControl
from procedures.free_positions.free_attitudes import UP_DIRECTIONS, UpDirection
from procedures.positions import ATTITUDES, face_of
from station.guide.view import CalibrationView, StepView

TREMOR_DEG_S = (20.0, 60.0)  # deg/s, the least and the greatest amplitude of a real hand that holds a weight


PAUSE_SHARE, PAUSE_S = 0.2, 3.0  # of moves that stop in the air, and for how long at most


class HandlingStyle:
    """``seed`` draws what each move is like; ``wrong_share`` of them end in another position."""

    def __init__(self, seed: int, wrong_share: float = 0.1) -> None:
        self._rng, self._wrong_share = np.random.default_rng(seed), wrong_share

    def carry(self, hands: BenchControl, position: int, move_s: float) -> tuple[float, bool]:
        """Carry the cube towards ``position`` in ``move_s`` [s] of moving.

        Returns the device time [s] at which it will be over, and whether it went to the right position.
        """
        rng, wrong = self._rng, position
        if rng.random() < self._wrong_share:
            wrong = int(rng.choice([p for p in range(1, len(ATTITUDES) + 1) if p != position]))
        pause = float(rng.uniform(0.0, PAUSE_S)) if rng.random() < PAUSE_SHARE else 0.0
        over = hands.carry(wrong, move_s, float(rng.uniform(*TREMOR_DEG_S)), pause)
        return over, wrong == position


SOAK_K = 15.0
REST_MARGIN_S = 2.0  # the guide judges rest in blocks of 1 s that begin anywhere: one is then wholly at rest
RETRY_S = 1.0  # of the station's time, between two calls of hands that do not answer
SEEN_EVERY_S = 10.0  # of the device's time
REPEAT_AFTER_S = 300.0  # of the device's time, after a move: the guide sees it late where time runs fast


class HandsLost(DriverError):
    """The simulated hands refuse, or do not answer where nobody waits for them."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


class SimulatedOperator:
    """Moves the cube of a simulated device with its hands at ``address``; a move takes ``move_s`` of its time.

    Each thing asked for is done once; what was rejected is done again, and what is still asked for long after it
    was done. On a busy machine the device runs ahead of the guide, so that nothing is done before the guide has
    seen all that the hands did last. In a soak it warms the unit, and lets it cool from the middle on. With a
    ``style`` it carries the cube as people do. The unit's clock is ``behind_s`` [s] behind the hands' after a
    power cycle.

    Hands that do not answer are called again until they do: ``lost`` says why meanwhile. ``clock`` [s] is the
    station's.
    """

    def __init__(
        self, hands: BenchControl, move_s: float, style: HandlingStyle | None = None, behind_s: float = 0.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._hands, self._move_s, self._style, self._clock = hands, move_s, style, clock
        self.lost, self._lost_since, self._called = "", 0.0, 0.0
        self._forget(behind_s)

    def _forget(self, behind_s: float = 0.0) -> None:
        """Take it that nothing was done yet."""
        self._done: tuple[str, str, int] | None = None
        self._until = -np.inf  # device time [s] at which that was over
        self._seen, self._restarts = -np.inf, behind_s  # the guide's device time [s]; what restarts took off it
        self._reported_s = -np.inf  # of `_seen`, last sent to the hands
        self._is_wrong = False  # what it did last
        self._heated = 0.0  # by how much the unit is warmer than it was

    @property
    def lost_s(self) -> float:
        """For how long [s] of the station's time the hands have not answered."""
        return self._clock() - self._lost_since if self.lost else 0.0

    def reach(self) -> None:
        """Call the hands; raise `HandsLost` if they do not answer."""
        try:
            self._hands.time()
        except SimulatorError as error:
            raise HandsLost(str(error)) from error

    def look(self, view: CalibrationView) -> None:
        """Place the cube, or turn it once it has rested, if that is what is wanted now.

        Raises
        ------
        HandsLost
            If the hands refuse what they are asked for.
        """
        if self.lost and self._clock() < self._called + RETRY_S:
            return
        try:
            self._call_again() if self.lost else self._execute(view)
        except ControlUnreachable as error:
            self._called = self._clock()
            if not self.lost:
                self.lost, self._lost_since = str(error), self._called
        except SimulatorError as error:
            raise HandsLost(str(error)) from error

    def _call_again(self) -> None:
        """Go on with hands that answer again; those of a device that was started again did nothing yet."""
        if self._hands.time() < self._seen:
            self._forget()
        self.lost = ""

    def close(self) -> None:
        """Let the hands go."""
        self._hands.close()

    def _execute(self, view: CalibrationView) -> None:
        seen = -np.inf if view.time_s is None else self._seen_s(view)
        if seen > self._reported_s + SEEN_EVERY_S:
            self._hands.seen(seen)
            self._reported_s = seen
        self._heat(view)
        is_turning = view.stage == "turn"  # one under way is done, whatever comes next
        step = view.step(view.live if is_turning else view.wanted)
        if step is None or view.stage not in {"place", "turn"} or view.question is not None:
            return
        is_ready = view.turn is not None and view.turn.rest_s >= view.turn.rest_wanted_s
        what = "turn" if is_turning else "place"
        rejected = max((event.number for event in view.events if event.sound == "rejected"), default=0)
        task = (what, f"{step.name} {step.attempts}", rejected)
        seen = self._seen_s(view)
        if seen < self._until + REST_MARGIN_S or (what == "turn" and not is_ready):
            return
        if task == self._done and seen < self._until + REPEAT_AFTER_S:
            return
        self._is_wrong = False
        self._until = self._do(what, step, view.tilt)
        self._done = None if self._is_wrong else task

    def _seen_s(self, view: CalibrationView) -> float:
        """Return up to which device time [s] the guide has looked; where the stream has none, the device's own.

        A unit that was switched off and on begins its time again; the hands' goes on.
        """
        if view.time_s is None:
            return self._hands.time()
        now = view.time_s + self._restarts
        if now < self._seen:
            self._restarts += self._seen - now
            now = self._seen
        self._seen = now
        return now

    def _heat(self, view: CalibrationView) -> None:
        """Warm the unit in the first half of a soak, let it cool in the second and after it."""
        is_first = view.soak is not None and view.soak.left_s > view.wanted_s / 2
        wanted = SOAK_K if is_first else 0.0
        if wanted != self._heated:
            self._hands.heat(wanted - self._heated, max(view.wanted_s, 1.0) / 8)
            self._heated = wanted

    def _do(self, what: str, step: StepView, tilt: UpDirection | None) -> float:
        """Return the device time [s] at which it will be over."""
        if what == "place" and step.is_free:
            return self._hands.tilt(tilt or UP_DIRECTIONS[0], self._move_s)
        if what == "place":
            face = next((p for p in range(1, 13) if face_of(p) == step.up), 0)
            position = step.position or step.start_position or face
            if self._style is None:
                return self._hands.place(position, self._move_s)
            over, is_right = self._style.carry(self._hands, position, self._move_s)
            self._is_wrong = not is_right
            return over
        return self._hands.turn(step.axis, step.direction, step.revolutions, REST_MARGIN_S)
