"""Moves are freed of what an effect added to them, and nothing else is touched."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.diagnosis.move_rows import move_bins
from procedures.diagnosis.moves_without import without_in_moves


def test_what_an_effect_adds_to_a_moves_rates_is_taken_off_its_counts() -> None:
    campaign = simulate_campaign(
        Truth.example(4), 4, dwell_s=1.0, positions=(1, 2, 3), turns=(), move_s=2.0, moves=True
    )
    first, second = (replace(move, name=name) for move, name in zip(campaign.moves, "ab", strict=True))
    campaign = replace(campaign, moves=(first, second))
    n = len(move_bins(second.series).edges) - 1
    step = SimpleNamespace(campaign=0, name="b")
    evidence: Any = SimpleNamespace(
        weights=(
            SimpleNamespace(move=None, rows=slice(0, 1), nodes=slice(0, 1)),  # a dwell's
            SimpleNamespace(move=object(), rows=slice(1, 2), nodes=slice(1, 1 + n)),
        ),
        excitation=SimpleNamespace(steps=(SimpleNamespace(campaign=0, name="a"), step)),
        step=np.array([0, 1]),
    )
    k, gyro = np.array([2000.0, 3000.0, 5000.0]), np.vstack(([[9.0, 9.0, 9.0]], np.outer(np.arange(n), [1, 2, 3])))
    (found,) = without_in_moves([campaign], evidence, k, gyro, None)
    assert found.moves[0] is first
    less = np.asarray(second.series.gyro) - np.asarray(found.moves[1].series.gyro)
    assert less.sum(axis=0) == pytest.approx(
        np.diff(move_bins(second.series).edges) @ np.outer(np.arange(n), [1, 2, 3]) * k * second.series.period
    )
