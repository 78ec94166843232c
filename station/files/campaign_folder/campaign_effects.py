"""The effects that a campaign is solved with: what its folder lists, and what a command names beside it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, EffectsTable
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.files.opening import open_inside
from station.files.toml_reading import Key, line_of

if TYPE_CHECKING:
    from station.files.effect_file import EffectFile  # with the catalogue: a solve without effects does without


def folder_effects(folder: Path, table: EffectsTable | None, lines: dict[Key, int]) -> "dict[str, EffectFile]":
    """Return the `effect/1` files that a folder lists, by their names in it.

    Raises
    ------
    DataRefused
        If one leads outside, is no `effect/1`, or has another hash than is stated.
    """
    if table is None:
        return {}
    from station.files.effect_file import MAX_BYTES, each_once, effect_in

    found: dict[str, EffectFile] = {}
    for name, stated in zip(table.files, table.sha256 or [""] * len(table.files), strict=True):
        with open_inside(folder, name, folder / CAMPAIGN_TOML, line_of(("effects", "files"), lines)) as stream:
            content = stream.read(MAX_BYTES + 1)
        found[name] = effect_in(content, folder / name)
        if stated and found[name].sha256 != stated:
            expected = f"{stated} as {CAMPAIGN_TOML} states"
            remedy = "bring back the file that was recorded"
            raise DataRefused(folder / name, None, f"sha256 {found[name].sha256}", expected, remedy)
    each_once([(folder / name, one) for name, one in found.items()])
    return found


def with_effects(campaigns: Sequence[LoadedCampaign], files: Sequence[Path]) -> list[LoadedCampaign]:
    """Return campaigns with effects from files beside their own; their hashes stand with those of all files.

    Raises
    ------
    DataRefused
        If a file is no `effect/1`, or two that differ have one name.
    """
    if not files and not any(one.effects for one in campaigns):
        return list(campaigns)
    from station.files.effect_file import each_once, read_effect

    read = {str(path): read_effect(path) for path in files}
    first, *others = campaigns
    whole = [(one.folder, effect) for one in campaigns for effect in one.effects]
    each_once([*whole, *((Path(path), effect) for path, effect in read.items())])
    hashes = {path: effect.sha256 for path, effect in read.items()}
    more = replace(first, effects=(*first.effects, *read.values()), files={**first.files, **hashes})
    return [more, *others]


def effects_of(campaigns: Sequence[LoadedCampaign]) -> "tuple[EffectFile, ...]":
    """Return the effects that campaigns are solved with together, each once."""
    if not any(one.effects for one in campaigns):
        return ()
    from station.files.effect_file import each_once

    return each_once([(one.folder, effect) for one in campaigns for effect in one.effects])
