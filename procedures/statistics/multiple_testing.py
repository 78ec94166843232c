"""p-values of many tests at once."""

from collections.abc import Hashable, Mapping
from math import erfc, sqrt
from typing import TypeVar

Name = TypeVar("Name", bound=Hashable)


def two_sided(sigmas: float) -> float:
    """Return the probability that a standard normal number is so far from 0 or farther."""
    return erfc(abs(sigmas) / sqrt(2.0))


def holm(p_values: Mapping[Name, float]) -> dict[Name, float]:
    """Return the p-values adjusted for their number: one is below alpha by chance in alpha of all sets at most.

    It holds however the tests depend on each other. Source: Holm, Scand. J. Statist. 6, 65, 1979.
    """
    adjusted, largest = dict[Name, float](), 0.0
    for rank, name in enumerate(sorted(p_values, key=lambda one: p_values[one])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[name]))
        adjusted[name] = largest
    return {name: adjusted[name] for name in p_values}
