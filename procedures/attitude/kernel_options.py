"""How the attitude kernels are compiled, and when compiled code is still good.

They allocate nothing, so that numba may leave out the counting of references (``_nrt``), which would take four
fifths of their time; and those of the Kalman filter are compiled into each other, since a call would copy the
settings. numba's own cache looks at a kernel's source file alone; here also at all that it calls.
"""

import hashlib
from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit
from numba.core.caching import FunctionCache

Record = Any  # of a structured dtype: numpy's types do not name its fields
F = TypeVar("F", bound=Callable[..., Any])


class KernelCache(FunctionCache):
    """numba's cache of one kernel, whose index distinguishes what the kernel calls and reads, too."""

    def _index_key(self, sig: object, codegen: object) -> tuple[object, ...]:
        text = repr(sorted(sources(self._py_func).items()))
        key = super()._index_key(sig, codegen)  # type: ignore[no-untyped-call]
        return (*key, hashlib.sha256(text.encode()).hexdigest())


def sources(function: Callable[..., Any]) -> dict[str, object]:
    """Return the code of a function, of all kernels that it calls in turn, and the values of globals they read."""
    code, found = function.__code__, dict[str, object]()
    for name in code.co_names:
        value = function.__globals__.get(name)
        if callee := getattr(value, "py_func", None):
            found |= sources(callee)
        elif isinstance(value, int | float):
            found[f"{function.__module__}.{name}"] = value
    fields = [getattr(each, "_fields", ()) for each in function.__annotations__.values()]
    found[f"{function.__module__}.{function.__qualname__}"] = (code.co_code, code.co_consts, code.co_names, fields)
    return found


def kernel(function: F) -> F:
    """Compile what Python calls."""
    return _compiled(function)


def inlined(function: F) -> F:
    """Compile what kernels call."""
    return _compiled(function, forceinline=True)


def _compiled(function: F, **options: bool) -> F:
    made = njit(_nrt=False, **options)(function)  # type: ignore[call-overload]
    made._cache = KernelCache(function)  # type: ignore[no-untyped-call]  # noqa: SLF001  (as ``cache=True`` does)
    found: F = made
    return found
