"""Declared effects as a solution names them: a coefficient without a finite value, or sigma, is left out."""

from pathlib import Path

import numpy as np
import pytest

from procedures.diagnosis.result import DeclaredEffect
from station.files.effect_file import EffectFile, effect_in
from station.results.declared_effects import effect_entries, own_definition


@pytest.fixture
def file() -> EffectFile:
    text = b"""format = "effect/1"
name = "steep"
triad = "accelerometer"
term = "f_z * f_z * f_z"
unit = "g/g^3"
plausible = 1e-6
source = "by hand"
"""
    return effect_in(text, Path("steep.toml"))


def test_what_is_not_finite_is_left_out(file: EffectFile) -> None:
    names = ("x", "y", "z")
    solved = DeclaredEffect(file.name, names, np.array([1.0, 2.0, np.nan]), np.array([0.1, np.inf, 0.1]), "g")
    [entry] = effect_entries([solved], [file])
    assert entry["coefficients"] == {"x": {"value": 1.0, "std": 0.1}}
    assert entry["sha256"] == file.sha256
    assert own_definition("another", [file]) == {}
