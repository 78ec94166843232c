"""Blocks of coarse counts: a rate that runs up steadily is no knock, one that jumps is."""

import numpy as np
import pytest

from procedures.diagnosis.disturbed_blocks import ChannelSamples, judge_blocks

PERIOD, SAMPLES = 0.02, 5000
KNOCKED = np.log(1e-9)  # 8000 blocks are judged


def channel(seed: int, run_up: float = 0.0, jump: float = 0.0) -> ChannelSamples:
    """0.3 counts a sample, which grow by ``run_up`` over the dwell; ``jump`` counts in its middle second."""
    rng, i = np.random.default_rng(seed), np.arange(SAMPLES)
    rate = 0.3 + run_up * i / SAMPLES + jump / 50 * (abs(i - SAMPLES / 2) < 25)
    total = rng.random() + np.cumsum(rate + 0.01 * rng.standard_normal(SAMPLES))
    return ChannelSamples(np.diff(np.floor(total), prepend=0.0), np.zeros(1, np.int64), PERIOD)


def least(channels: list[ChannelSamples]) -> float:
    return min(float(blocks.log_p[blocks.trace == 0].min()) for blocks in judge_blocks(channels, True))


@pytest.mark.parametrize("seed", [0])
def test_a_rate_that_runs_up_is_told_from_a_jump(seed: int) -> None:
    quiet = [channel(10 * seed + k) for k in range(1, 4)]
    assert least([channel(seed), *quiet]) > KNOCKED
    assert least([channel(seed, run_up=1.0), *quiet]) > KNOCKED  # 3 counts off a line in ten seconds
    assert least([channel(seed, jump=6.0), *quiet]) < KNOCKED
