"""A `calibration/1` as it is exported: triads, provenance, and the error terms that a program can compute.

Terms are those that the station corrects, `station.calibrated.applied_effects`, in the calibration's units. With
the inputs of user-defined terms there are ``warming``, 1 while it grows warmer and -1 while it cools, ``c``, the
sensor's own coefficient inside a term, and ``sine(y)``, ``sin(x) / x - 1`` of ``y = x^2``.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from procedures.effects.excitation import UNITS_OF_NONLINEAR
from procedures.effects.term.inputs import AUXILIARY, MEASURED
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.applied_effects import AppliedEffect, applied_effect, law_of_entry
from station.calibrated.correction_inputs import Backlash, Triad
from station.files.calibration_document import MAX_BYTES, parsed_calibration
from station.files.toml_file import read_text_file


@dataclass(frozen=True, slots=True, eq=False)
class StoredCalibration:
    """A calibration/1, its triads by name, and the SHA-256 of its file."""

    path: Path
    document: Mapping[str, Any]
    sha256: str
    triads: Mapping[str, Triad]

    @property
    def unit(self) -> str:
        """Model and serial."""
        return f"{self.document['model']} {self.document['serial']}"

    @property
    def effects(self) -> tuple[Mapping[str, Any], ...]:
        """The entries of its effects."""
        return tuple(self.document["effects"])

    @property
    def temperature_range_c(self) -> tuple[float, float] | None:
        """The least and the greatest temperature [degC] at which it was measured, None where nobody knows."""
        known = self.document.get("temperature_range_c")
        return None if known is None else (float(known[0]), float(known[1]))

    @property
    def origin(self) -> tuple[str, ...]:
        """Whose it is, its hash, when it was accepted and how long it holds: one line each."""
        document, lines = self.document, [f"Calibration of {self.unit}"]
        lines.append(f"SHA-256 of {self.path.name}: {self.sha256}")
        lines.append(
            f"status {document.get('status', 'unknown')}, accepted {document.get('accepted_utc', 'unknown')}"
        )
        until = document.get("valid_until", "not stated")
        lines.append(f"valid from {document.get('valid_from', 'not stated')}, until {until}")
        lines.append(f"made by {document.get('software', 'unknown')}")
        if (known := self.temperature_range_c) is not None:
            lines.append(f"measured at {known[0]:.1f} to {known[1]:.1f} degC")
        return tuple(lines)


def read_stored(path: Path) -> StoredCalibration:
    """Read a calibration/1 to be exported; raises `DataRefused` as `checked_calibration`."""
    content = read_text_file(path, MAX_BYTES)
    checked = parsed_calibration(content, str(path))
    return StoredCalibration(
        path, checked, hashlib.sha256(content).hexdigest(), CalibrationModel.of(checked).triads
    )


@dataclass(frozen=True, slots=True)
class NotExported:
    """An effect that is not carried: its name, why, and how large its coefficients are, in words."""

    name: str
    why: str
    size: str

    def __str__(self) -> str:
        return f"{self.name}: {self.why}; {self.size}"


def carried_effects(stored: StoredCalibration) -> tuple[tuple[AppliedEffect, ...], tuple[NotExported, ...]]:
    """Return the effects that a sample and what is remembered of the temperature determine, and the others.

    Raise `DataRefused` if the definition of an effect of one's own is not what was stored.
    """
    carried, left = list[AppliedEffect](), list[NotExported]()
    for entry in stored.effects:
        found = applied_effect(entry)
        why = found if isinstance(found, str) else _hindrance(found, stored)
        if isinstance(found, str) or why:
            left.append(NotExported(str(entry["name"]), why, stated_size(entry)))
        else:
            carried.append(found)
    return tuple(carried), tuple(left)


def input_name(auxiliary: str) -> str:
    """Return the name of an auxiliary channel's input without its prefix."""
    return auxiliary.removeprefix(AUXILIARY)


def _hindrance(one: AppliedEffect, stored: StoredCalibration) -> str:
    """Return why a program cannot work out an effect whose terms it could; empty if it can."""
    if any(isinstance(each, Backlash) for each in one.signals):
        return "exported programs cannot follow temperature hysteresis"
    of_vector = {vector: triad for triad, vector in MEASURED.items()}
    needed = {one.triad, *(of_vector.get(name.partition("_")[0], one.triad) for name in one.inputs)}
    for triad in sorted(needed - stored.triads.keys()):
        return f"there is no calibrated {triad}"
    odd = sorted(name for name in one.inputs if not (name.isascii() and name.isidentifier()))
    return f"the channel {odd[0]!r} is no name in a program" if odd else ""


def stated_size(entry: Mapping[str, Any]) -> str:
    """Return how large an effect is, in words: its largest coefficient, in the unit that says when."""
    law = law_of_entry(entry)
    constants = UNITS_OF_NONLINEAR if law is None else law.parameters
    sizes = [abs(float(one["value"])) for key, one in entry["coefficients"].items() if key not in constants]
    if not sizes:
        return "its size is not known"
    unit = str(entry.get("unit", ""))
    return f"up to {max(sizes):.3g} {'' if unit == '1' else unit}".rstrip()
