"""p-values of many tests at once."""

from collections.abc import Hashable, Mapping
from math import erfc, inf, log, sqrt
from typing import TypeVar

Name = TypeVar("Name", bound=Hashable)


def two_sided(sigmas: float) -> float:
    """Return the probability that a standard normal number is so far from 0 or farther."""
    return erfc(abs(sigmas) / sqrt(2.0))


def holm(p_values: Mapping[Name, float], are_logs: bool = False) -> dict[Name, float]:
    """Return the p-values, or ln p, adjusted for their number.

    One is below alpha by chance in alpha of all sets at most, however the tests depend on each other. Source:
    Holm, Scand. J. Statist. 6, 65, 1979.
    """
    adjusted, largest, certain = dict[Name, float](), -inf, 0.0 if are_logs else 1.0
    for rank, name in enumerate(sorted(p_values, key=lambda one: p_values[one])):
        tests = len(p_values) - rank
        counted = p_values[name] + log(tests) if are_logs else tests * p_values[name]
        largest = adjusted[name] = min(max(largest, counted), certain)
    return {name: adjusted[name] for name in p_values}
