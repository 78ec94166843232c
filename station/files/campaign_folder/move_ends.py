"""A move must meet its steps: its rows go on where one ends, and end where the other begins."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, DwellTable, MoveTable, TurnTable
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.toml_reading import Key, line_of

MOST_NAMED = 3  # steps in a refusal
MEETING_PERIODS = 0.5  # of a sample, by which a move's rows may begin early or late


def refuse_loose_moves(folder: Path, steps: Sequence[LoadedStep], lines: dict[Key, int] | None = None) -> None:
    """Refuse moves from or to what is no dwell or turn of the folder, and those that do not meet these.

    ``lines`` has the line of each key of ``campaign.toml``, where there is one.
    Between a step's last row and a move's first the cube may have been turned, and nobody would know.
    """
    rests = {step.table.file: step for step in steps if isinstance(step.table, DwellTable | TurnTable)}
    moves = [step for step in steps if isinstance(step.table, MoveTable)]
    for i, step in enumerate(moves):
        assert isinstance(step.table, MoveTable)
        if step.data is None:
            continue
        for key, name in (("from", step.table.before), ("to", step.table.after)):
            if name not in rests:
                line = line_of(("move", i, key), lines) if lines else None
                raise DataRefused(
                    folder / CAMPAIGN_TOML, line, f"[[move]] {step.table.file}: {key} = {ascii(name)[:80]}",
                    "the file of a [[dwell]] or [[turn]] of this folder",
                    f"name the step that it joins, one of {_some(rests)}, or remove the transfer",
                )  # fmt: skip
        period, (first, last) = step.data.series.period, step.data.span
        begin, end = rests[step.table.before].data, rests[step.table.after].data
        assert begin is not None
        assert end is not None
        gaps = (first - begin.span[1] - period, end.span[0] - last - period)
        worst = max(gaps, key=abs)
        if abs(worst) > MEETING_PERIODS * period:
            raise DataRefused(
                folder / step.table.file, None, f"rows {worst:+.4g} s off where its steps end and begin",
                f"the first {period:.4g} s after {step.table.before}, the last as long before {step.table.after}",
                "cut the rows there, or remove the transfer",
            )  # fmt: skip


def _some(names: Iterable[str]) -> str:
    """Return the first few names."""
    first = list(names)
    return ", ".join([*first[:MOST_NAMED], *(["..."] if len(first) > MOST_NAMED else [])])
