"""What ``station locate`` does with a folder that was read."""

from pathlib import Path

from procedures.errors import NotObservable
from station.files.fusion_folder import FusionLog, write_tum
from station.locate.location_json import location_document
from station.locate.location_text import location_text
from station.locate.source_choice import default_source, locate
from station.results.solution_json import write_solution


def locate_folder(
    log: FusionLog, source: str | None, layers: int, out: Path | None, batch: Path | None, json: Path | None
) -> str:
    """Locate, write what was asked for, and return a summary, empty where a JSON was asked for.

    Raises
    ------
    NotObservable
        If it never could be initialised; the JSON is written and says why.
    """
    source = source or default_source(log)
    located = locate(log, source, layers)
    document = location_document(located, source, log.truth)
    if json is not None:
        write_solution(json, document)
    if located.begun_at is None:
        raise NotObservable(f"{log.folder}: position and heading", (located.why_not,))
    if out is not None:
        write_tum(out, located.online)
    if batch is not None:
        write_tum(batch, located.smoothed)
    return "" if json is not None else location_text(document, located.fixes)
