"""An effect in words: of the catalogue by its name, of a file by its path."""

from collections.abc import Sequence
from pathlib import Path

from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.term.inputs import input_of
from station.errors import DataRefused
from station.files.effect_file import EffectFile, read_effect
from station.results.effect_confirmed import confidence_text


def effect_text(name: str, in_force: Sequence[str] = ()) -> str:
    """Return what is known of an effect of the catalogue, or of a file of `effect/1`.

    ``in_force`` are the names of the database, which a refusal lists.

    Raises
    ------
    DataRefused
        If there is neither, or the file is no `effect/1`.
    """
    if (known := next((effect for effect in EFFECTS if effect.name == name), None)) is not None:
        return "\n".join([f"{name}: in the catalogue", *_lines(known)])
    if not Path(name).exists():
        known_names = ", ".join([*in_force, *(effect.name for effect in EFFECTS)])
        expected = f"a file of effect/1, or one of {known_names}"
        raise DataRefused(name, None, "no such error term", expected, "check the name")
    return file_text(read_effect(Path(name)))


def file_text(file: EffectFile) -> str:
    """Return what an `effect/1` says."""
    lines = [f"{file.name}: effect/1, sha256 {file.sha256}", *_lines(file.effect)]
    for name, one in file.term.parameters.items():
        lines.append(f"  {name:<10} fitted between {one.low:g} and {one.high:g} {one.unit}")
    for name in file.term.inputs:
        known = input_of(name, file.term.triad)
        lines.append(f"  {name:<10} {known.meaning} [{known.unit}]" if known is not None else f"  {name}")
    if file.term.looks_back:
        lines.append(
            "  it is specific to the campaign or to earlier steps: it is in the solution "
            "and is not corrected in later samples"
        )
    if (origin := file.origin) is not None:
        lines.append(
            f"  adopted on {origin.date} from {', '.join(origin.campaigns)}, diagnosis {origin.diagnosis_sha256}"
        )
    if said := confidence_text(file):
        lines.append(f"  {said}")
    return "\n".join(lines)


def _lines(effect: Effect) -> list[str]:
    return [
        f"  adds       {effect.physics}",
        f"  unit       {effect.unit}, plausible {effect.plausible:g}",
        f"  source     {effect.source}",
    ]
