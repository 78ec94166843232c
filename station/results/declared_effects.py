"""Effects that were declared by files, as a solution names them: coefficients, unit, hash and the file itself."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from procedures.effects.effect import REFERENCE_C
from procedures.inference.result import DeclaredEffect
from station.files.effect_file import EffectFile


def effect_entries(solved: Sequence[DeclaredEffect], files: Sequence[EffectFile]) -> list[dict[str, Any]]:
    """Return the ``effects`` of solution/1 and calibration/1; what is not finite is left out.

    ``definition`` is the text of the `effect/1`, ``sha256`` that of its bytes, ``units`` those of its parameters.
    """
    by_name = {one.name: one for one in files}
    return [_entry(each, by_name[each.effect]) for each in solved]


def _entry(solved: DeclaredEffect, file: EffectFile) -> dict[str, Any]:
    values = zip(solved.coefficients, solved.value.tolist(), solved.std.tolist(), strict=True)
    known = {name: {"value": v, "std": s} for name, v, s in values if np.isfinite(v) and np.isfinite(s)}
    units = {name: one.unit for name, one in file.term.parameters.items()}
    return {
        "name": solved.effect, "coefficients": known, "unit": solved.unit, **({"units": units} if units else {}),
        **({"reference": {"temperature_c": REFERENCE_C}} if "T" in file.term.inputs else {}),
        **_definition(file),
    }  # fmt: skip


def own_definition(name: str, files: Sequence[EffectFile]) -> dict[str, Any]:
    """Return the hash and the text of the `effect/1` of a name; nothing of an effect of the catalogue."""
    return next((_definition(file) for file in files if file.name == name), {})


def _definition(file: EffectFile) -> dict[str, Any]:
    return {"term": list(file.term.terms), "sha256": file.sha256, "definition": file.text}
