"""Two steps may not overlap: ``t_s`` says when each happened."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from station.errors import DataRefused
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.text.plural import plural


def refuse_overlap(folder: Path, steps: Sequence[LoadedStep]) -> list[str]:
    """Refuse steps that overlap in ``t_s``; return one remark if only the device's clock was reset between them.

    A recording that carries the station's own time proves by it that two steps were apart although the
    device's time, which a loss of power resets, says otherwise; so does a step of another ``turn_on``.
    """
    reset = list[LoadedStep]()  # since the step before, in order of the device's time
    timed = [(getattr(step.table, "turn_on", None) or 1, step.data.span, step) for step in steps if step.data]
    timed.sort(key=lambda item: item[:2])
    for (on, span, first), (next_on, next_span, second) in pairwise(timed):
        if on != next_on or next_span[0] > span[1]:
            continue
        if not _apart_by_host(first, second):
            raise DataRefused(
                folder / second.table.file,
                None,
                f"t_s {next_span[0]:.9g} to {next_span[1]:.9g}",
                f"no overlap with {first.table.file} ({span[0]:.9g} to {span[1]:.9g})",
                "correct t_s or leave one of the two steps out",
            )
        reset.append(second)
    if not reset:
        return []
    files = ", ".join(each.table.file for each in reset)
    return [f"the device's clock was reset during the campaign: {plural(len(reset), 'step')} affected ({files})"]


def _apart_by_host(first: LoadedStep, second: LoadedStep) -> bool:
    spans = [step.data.host_span for step in (first, second) if step.data and step.data.host_span]
    return len(spans) == 2 and (spans[0][1] < spans[1][0] or spans[1][1] < spans[0][0])
