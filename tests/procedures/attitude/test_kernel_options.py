"""numba's own cache looks at the file of a kernel alone, not at those of the kernels that it calls."""

import sys
from importlib import import_module, invalidate_caches
from pathlib import Path

import pytest

CALLEE = """
from procedures.attitude.kernel_options import inlined
LIMIT = 2.0

@inlined
def limited(x):
    return min(x, LIMIT)
"""
CALLER = """
from kernel_callee import limited
from procedures.attitude.kernel_options import kernel

@kernel
def doubled(x):
    return 2.0 * limited(x)
"""


def test_a_changed_kernel_makes_its_callers_compile_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    (tmp_path / "kernel_callee.py").write_text(CALLEE)
    (tmp_path / "kernel_caller.py").write_text(CALLER)
    assert _from_the_cache_and_found() == (0, 4.0)
    assert _from_the_cache_and_found() == (1, 4.0)
    (tmp_path / "kernel_callee.py").write_text(CALLEE.replace("LIMIT = 2.0", "LIMIT = 10.0"))
    assert _from_the_cache_and_found() == (0, 6.0)


def _from_the_cache_and_found() -> tuple[int, float]:
    """Return how often compiled code came from the cache, and what the kernel returns: modules imported anew."""
    for each in ("kernel_callee", "kernel_caller"):
        sys.modules.pop(each, None)
    invalidate_caches()
    doubled = import_module("kernel_caller").doubled
    found = doubled(3.0)
    return len(doubled.stats.cache_hits), found
