"""Whether turns closed: figures of docs/explanation/guiding.md in short, and every case of the decision."""

import numpy as np
import pytest

from procedures.bench.seating_check import (
    Closing,
    TurnCounts,
    judge_closing,
)

ANGLE, K = 6 * np.pi, 2e6  # rad, count/rad
C = float(np.radians(0.01))


def seen(direction: str, closure: float, std: float = 0.0, revolutions: int = 3) -> TurnCounts:
    angle = 2 * np.pi * revolutions
    return TurnCounts(direction, K * (angle + closure) / revolutions, angle, std)


def reported(*turns: tuple[str, float]) -> Closing:
    return judge_closing([seen(direction, off * C) for direction, off in turns], C)


@pytest.mark.parametrize(
    ("turns", "expected"),
    [
        ([("+", 9.0)], Closing.ALONE),
        ([("+", 1.0), ("-", -1.0)], Closing.CLOSED),
        ([("+", 0.0), ("-", 9.0)], Closing.ONCE_MORE),
        ([("+", 0.0), ("-", 9.0), ("-", 1.0)], Closing.CLOSED),
        ([("+", 0.0), ("-", 9.0), ("-", 9.5)], Closing.OTHER),
        ([("+", 0.0), ("-", 9.0), ("-", 9.5), ("+", 9.0)], Closing.CLOSED),
        ([("+", 0.0), ("-", 9.0), ("-", 9.5), ("+", 0.5)], Closing.REPEATS),
        ([("+", 0.0), ("-", 9.0), ("-", 18.0)], Closing.APART),
        ([("+", 0.0), ("-", 9.0), ("-", 9.5), ("+", 30.0)], Closing.ONCE_MORE),
    ],
)
def test_what_turns_say_together(turns: list[tuple[str, float]], expected: Closing) -> None:
    assert reported(*turns) is expected


def test_honest_pairs_are_taken_and_pairs_four_sigma_apart_are_caught() -> None:
    rng = np.random.default_rng(1)
    noise = 0.2 * C
    honest = far = 0
    for closures in C * rng.standard_normal((4000, 2)):
        a, b = closures + noise * rng.standard_normal(2)
        honest += judge_closing([seen("+", a, noise), seen("-", b, noise)], C) is Closing.CLOSED
        b = closures[0] + 4 * np.sqrt(2) * C + noise * rng.standard_normal()
        far += judge_closing([seen("+", a, noise), seen("-", b, noise)], C) is Closing.CLOSED
    assert honest >= 0.995 * 4000
    assert far <= 0.01 * 4000
