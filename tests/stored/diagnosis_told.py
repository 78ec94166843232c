"""What is held of a diagnosis: all that it says, not the rows and fits that it says it of."""

from dataclasses import fields, replace
from typing import Any

from procedures.diagnosis.result import Diagnosis
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect

CLOCK = "clock.rate"
ROWS = {"before", "after", "evidence", "values", "added"}


def told(found: Diagnosis) -> dict[str, Any]:
    """Return the fields of a diagnosis, the effects added by their names.

    What is not held of the clock are its chances, in which the length of the catalogue is.
    """
    said = {each.name: getattr(found, each.name) for each in fields(found) if each.name not in ROWS}
    said["tried"] = [each for each in found.tried if each.effect != CLOCK]
    said["findings"] = [replace(each, log_p=0.0) if each.effect == CLOCK else each for each in found.findings]
    return said | {"values": found.values, "added": [each.effect.name for each in found.added]}


def some_effects(*names: str) -> list[Effect]:
    """Return effects of the catalogue by name: one that is added to it must not move what is held of others."""
    return [effect for effect in EFFECTS if effect.name in names]
