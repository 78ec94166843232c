"""How the joint filter's kernels are compiled.

They allocate nothing, so that numba may leave out the counting of references (``_nrt``), which would take four
fifths of their time; and they are compiled into each other, since a call would copy the settings.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile what Python calls."""
    made: F = njit(cache=True, _nrt=False)(function)  # type: ignore[call-overload]
    return made


def inlined(function: F) -> F:
    """Compile what kernels call."""
    made: F = njit(cache=True, forceinline=True, _nrt=False)(function)  # type: ignore[call-overload]
    return made
