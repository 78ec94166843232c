"""What two pairs of faces differ by is no term of the sensor, and the finding says in which channel."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from tests.benchmarks.diagnosing.designs import plain, unit


def channels(effects: Mapping[str, Mapping[str, float]]) -> object:
    truth = replace(unit(3), faces_rad=np.zeros((6, 2)), effects=effects)
    found = {each.effect: each for each in diagnose(plain(truth, 3)).findings}
    return found["fixture.parallelism"].where.get("channel")


def test_a_tilted_pair_is_told_from_the_sensor_where_only_it_differs() -> None:
    quadratic = {"accelerometer.quadratic": {"x": 4e-5, "y": -3e-5}}
    assert channels(quadratic) is None
    assert channels(quadratic | {"fixture.parallelism": {"x.z": 6e-5}}) == ["az"]
