"""A move must meet its steps: its rows go on where one ends, and end where the other begins."""

from collections.abc import Sequence
from pathlib import Path

from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import DwellTable, MoveTable, TurnTable
from station.files.campaign_folder.loaded_campaign import LoadedStep

MEETING_PERIODS = 0.5  # of a sample, by which a move's rows may begin early or late


def refuse_loose_moves(folder: Path, steps: Sequence[LoadedStep]) -> None:
    """Refuse moves from or to what is no dwell or turn of the folder, and those that do not meet these.

    Between a step's last row and a move's first the cube may have been turned, and nobody would know.
    """
    rests = {step.table.file: step for step in steps if isinstance(step.table, DwellTable | TurnTable)}
    for step in steps:
        if not isinstance(step.table, MoveTable) or step.data is None:
            continue
        for key, name in (("from", step.table.before), ("to", step.table.after)):
            if name not in rests:
                raise DataRefused(
                    folder / "campaign.toml", None, f"[[move]] {step.table.file}: {key} = {ascii(name)[:80]}",
                    "the file of a [[dwell]] or [[turn]] of this folder", "name the step that it joins",
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
                "cut the rows there, or leave the move out",
            )  # fmt: skip
