"""The catalogue of effects: a file for each family of physical causes, a record for each effect in it.

`MODULES` lists the files; an effect that belongs to none (`sensitivities`: what acts from outside) is a new file.

An `Excitation` (what the sensors went through) goes into an `Effect`, `Columns` (what it may have added) come out.
Where an effect has a `Law` (`term.law`), its equation, all of its users are made from that.
"""

from collections.abc import Mapping
from importlib import import_module

from procedures.effects.effect import INSTRUMENT, Effect

MODULES = (
    "input_nonlinearity",
    "sagnac_sine",
    "temperature",
    "settling",
    "surface_plate",
    "cube_faces",
    "placement",
    "site_and_clock",
    "jump",
    "bias_noise",
    "sensitivities",
)


def _effects() -> tuple[Effect, ...]:
    """Return the effects of the files as they stand there, the accelerometers' first; the order decides ties."""
    found = [vars(import_module(f"{__name__}.{name}")).values() for name in MODULES]
    owners = (*INSTRUMENT, "")
    effects = [one for values in found for one in values if isinstance(one, Effect)]
    return tuple(one for owner in owners for one in effects if one.triad == owner)


EFFECTS = _effects()
CATALOGUE: Mapping[str, Effect] = {effect.name: effect for effect in EFFECTS}
