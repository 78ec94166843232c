"""The columns in which auxiliary channels are carried along: ``aux_`` and a plain name, one for each."""

import re
from collections.abc import Iterable

from procedures.effects.term.inputs import AUXILIARY
from station.errors import DataRefused


def channels_by_column(channels: Iterable[str], where: str) -> dict[str, str]:
    """Return channels by the column that each goes to; raise `DataRefused` where two would go to one."""
    found = dict[str, str]()
    for name in channels:
        plain = re.sub(r"[^A-Za-z0-9_]+", "_", name)
        column = plain if plain.startswith(AUXILIARY) else f"{AUXILIARY}{plain}"
        if column in found:
            both = f"channels {found[column]!r} and {name!r}, which both would be column {column}"
            raise DataRefused(where, None, both, "a name of letters and digits for each", "rename one")
        found[column] = name
    return found
