"""How simulated hands carry a cube: with the tremor of real ones, with pauses in the air, now and then wrongly."""

from dataclasses import dataclass, field

import numpy as np

from drivers.simulated.bench_control import BenchControl
from procedures.frames import ATTITUDES

TREMOR_DEG_S = (20.0, 60.0)  # deg/s, the least and the greatest amplitude of a real hand that holds a weight


@dataclass(frozen=True, slots=True, eq=False)
class HandStyle:
    """``seed`` draws what each move is like.

    ``wrong_share`` of them end in another position, ``pause_share`` stop in the air, for up to ``pause_s`` [s].
    """

    seed: int
    wrong_share: float = 0.1
    pause_share: float = 0.2
    pause_s: float = 3.0
    _rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_rng", np.random.default_rng(self.seed))

    def carry(self, hands: BenchControl, position: int, move_s: float) -> tuple[float, bool]:
        """Carry the cube towards ``position`` in ``move_s`` [s] of moving.

        Returns the device time [s] at which it will be over, and whether it went to the right position.
        """
        rng, wrong = self._rng, position
        if rng.random() < self.wrong_share:
            wrong = int(rng.choice([p for p in range(1, len(ATTITUDES) + 1) if p != position]))
        pause = float(rng.uniform(0.0, self.pause_s)) if rng.random() < self.pause_share else 0.0
        over = hands.carry(wrong, move_s, float(rng.uniform(*TREMOR_DEG_S)), pause)
        return over, wrong == position
