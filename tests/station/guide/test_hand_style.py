"""Simulated hands carry a cube as people do: flips without a turn, one of them wrong, recorded and solved."""

from typing import cast

from drivers.simulated.simulated_hands import SimulatedHands
from station.guide.hand_style import TREMOR_DEG_S, HandStyle


class Told:
    """Takes commands as hands do, and keeps them."""

    def __init__(self) -> None:
        self.moves: list[tuple[int, float, float, float]] = []

    def carry(self, position: int, move_s: float, tremor_deg_s: float, pause_s: float = 0.0) -> float:
        self.moves.append((position, move_s, tremor_deg_s, pause_s))
        return float(len(self.moves))


def test_a_tenth_goes_wrong_a_fifth_stops_in_the_air_and_all_tremble() -> None:
    told, style = Told(), HandStyle(3)
    ends = [style.carry(cast("SimulatedHands", told), 20, 6.0) for _ in range(500)]
    assert [over for over, _ in ends] == list(range(1, 501))
    wrong = [move for move, (_, is_right) in zip(told.moves, ends, strict=True) if not is_right]
    assert 25 < len(wrong) < 80
    assert all((move[0] != 20) == (move in wrong) for move in told.moves)
    assert 60 < sum(pause > 0 for *_, pause in told.moves) < 150
    assert all(TREMOR_DEG_S[0] <= tremor <= TREMOR_DEG_S[1] for _, _, tremor, _ in told.moves)


def test_equal_seeds_carry_alike() -> None:
    first, second = Told(), Told()
    for told in (first, second):
        style = HandStyle(7)
        for position in (1, 4, 9):
            style.carry(cast("SimulatedHands", told), position, 6.0)
    assert first.moves == second.moves
