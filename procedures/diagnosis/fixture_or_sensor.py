"""Along which axes opposite faces differ in a way that no term of the sensor can imitate.

Along an axis q lie two sums of opposite faces' tilts, those of the pairs of the two other axes. K2, a scale
asymmetry and the bias move both alike; their difference is the fixture's, or a seating's, alone.
"""

from dataclasses import replace

import numpy as np

from procedures.calibration.solution import Solution
from procedures.diagnosis.result import Finding
from procedures.frames import AXES

NAME, SENSOR = "fixture.parallelism", "accelerometer.quadratic"
SURE = 3.0  # sigmas


def pure_fixture(solution: Solution) -> tuple[str, ...]:
    """Return the accelerometer channels along which the two sums differ for certain, in cube axes."""
    if solution.parallelism is None:
        return ()
    at = {name.removeprefix(f"{NAME}."): i for i, name in enumerate(solution.names) if name.startswith(NAME)}
    value = dict(zip(at, solution.parallelism.value.ravel(), strict=True))
    found = list[str]()
    for q in AXES:
        one, other = (name for name in at if name.endswith(f".{q}"))
        i = [at[one], at[other]]
        std = np.sqrt(np.array([1, -1]) @ solution.covariance[np.ix_(i, i)] @ np.array([1, -1]))
        if abs(value[one] - value[other]) > SURE * std:
            found.append(f"a{q}")
    return tuple(found)


def with_channels(findings: tuple[Finding, ...], base: Solution) -> tuple[Finding, ...]:
    """Return findings, parallelism that may be the sensor's with the channels in which part of it is not."""
    found = pure_fixture(base)
    return tuple(
        replace(each, where={**each.where, "channel": list(found)})
        if each.effect == NAME and SENSOR in each.aliases and found
        else each
        for each in findings
    )
