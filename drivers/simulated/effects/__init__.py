"""Every error term that can be planted by name and size.

Each is a `planted_effect`: of the `sensors` (also their bias noise) or of the `bench`.
`written_term` plants a user-defined one. `docs/reference/simulated-devices.md` lists units and equations.
"""

from collections.abc import Mapping
from types import MappingProxyType

from drivers.errors import TruthRefused, UnknownEffect
from drivers.simulated.effects.bench import BENCH, PROCEDURE, VIBRATION
from drivers.simulated.effects.planted_effect import PlantedEffect, Stimulus, TriadInput
from drivers.simulated.effects.sensors import ACCELEROMETER, BIAS_NOISE, BOTH, GYROSCOPE
from drivers.simulated.effects.written_term import planted_term
from drivers.simulated.truth import Sizes

_ALL = (*ACCELEROMETER, *GYROSCOPE, *BOTH, *BIAS_NOISE, *BENCH, *PROCEDURE, *VIBRATION)
EFFECTS = {effect.name: effect for effect in _ALL}

Planted = tuple[tuple[PlantedEffect, Sizes], ...]

__all__ = ["EFFECTS", "Planted", "PlantedEffect", "Stimulus", "TriadInput", "planted"]


def planted(effects: Mapping[str, Sizes], terms: Mapping[str, str] = MappingProxyType({})) -> Planted:
    """Return the effects of a truth with their sizes, options filled in; ``terms`` are those written as effect/1.

    Raises
    ------
    TruthRefused
        A position that there is not, or a term that cannot be planted.
    UnknownEffect
        A name that is no effect or no coefficient of it; lists the names there are.
    """
    found = []
    known = EFFECTS | {name: planted_term(name, text) for name, text in terms.items()}
    for name, sizes in effects.items():
        if name not in known:
            raise UnknownEffect(name, known)
        effect = known[name]
        for key in sizes:
            if key not in effect.keys and key not in effect.options:
                raise UnknownEffect(f"{name}.{key}", (*effect.keys, *effect.options))
        found.append((effect, {**effect.options, **sizes}))
        for key, lowest in (("position", 1), ("actual", 0)):
            if key in sizes and sizes[key] not in range(lowest, 13):
                raise TruthRefused(f"effects.{name}.{key} = {sizes[key]}", f"{lowest} to 12")
    return tuple(found)
