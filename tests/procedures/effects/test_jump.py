"""Places of a jump: each has a name of its own, and however many rests there are, some are tried within."""

import numpy as np

from procedures.effects.effect import Excitation, ExcitationStep
from procedures.effects.jump import accelerometer_columns

NODES = 16  # of a step, a second each


def rests(*campaigns: int) -> Excitation:
    """Return an excitation of so many rests a campaign, p0.csv, p1.csv and so on in each."""
    steps = tuple(
        ExcitationStep(f"p{i}.csv", "rest", n, 0, "") for n, count in enumerate(campaigns) for i in range(count)
    )
    begin = np.concatenate([np.arange(count) for count in campaigns]) * (NODES + 4.0)
    n = NODES * len(steps)
    vector, one = np.ones((n, 3)), np.ones(n)
    unit = np.tile(np.eye(3), (n, 1, 1))
    inside = np.tile(np.arange(NODES, dtype=float), len(steps))
    return Excitation(
        f=vector, omega=vector, magnetic=vector, accel_output=vector, gyro_output=vector, change=vector,
        t=np.repeat(begin, NODES) + inside, rest_s=inside, temperature=one, temperature_rate=one, auxiliary={},
        step=np.repeat(np.arange(len(steps)), NODES), C_sb=unit, E_accel=unit, E_gyro=unit, steps=steps,
    )  # fmt: skip


def test_a_jump_of_one_campaign_is_not_anothers_whose_files_have_the_same_names() -> None:
    seen = rests(5, 5)
    ways = accelerometer_columns(seen)
    assert len({(way.shape, *way.where.items()) for way in ways}) == len(ways)
    campaign = seen.per_step("campaign")
    for way in ways:
        assert way.accel is not None
        acts = way.accel.any(axis=(1, 2))
        assert set(campaign[acts] + 1) == {way.where["campaign"]}
