"""Kernels as the Python that they are compiled from: one step of a filter needs no compiler."""

from types import ModuleType

import pytest


def uncompiled(monkeypatch: pytest.MonkeyPatch, *modules: ModuleType) -> None:
    """Let the modules call each other's kernels as Python."""
    for module in modules:
        for name, value in list(vars(module).items()):
            if hasattr(value, "py_func"):
                monkeypatch.setattr(module, name, value.py_func)
