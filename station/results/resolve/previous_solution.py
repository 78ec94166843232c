"""What was known of a campaign before: its newest stored calibration, else the ``solution.json`` in its folder.

A diagnosis is the calibration's, else the ``diagnosis.json`` in the folder where that is of the same files.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from sqlalchemy.orm import Session

from fixtures_db.campaigns import known_campaign
from fixtures_db.stored_calibrations import newest_calibration
from station.errors import DataRefused
from station.files.toml_file import read_text_file
from station.results.measurement_circumstances import diagnosis_kept
from station.results.parameters_by_name import parameters

SOLUTION, DIAGNOSIS = "solution.json", "diagnosis.json"
MAX_BYTES = 2**26  # bytes


@dataclass(frozen=True, slots=True)
class PreviousSolution:
    """A `calibration/1` or `solution/1` of the same campaign; ``name`` is its hash or its file.

    ``warnings`` is None where nobody wrote them down: a calibration has none of its own. ``diagnosis`` has
    verdict and findings; None where none is known.
    """

    kind: Literal["calibration", "solution"]
    name: str
    document: Mapping[str, Any]
    warnings: tuple[str, ...] | None
    diagnosis: Mapping[str, Any] | None = None

    @property
    def inputs(self) -> Mapping[str, str]:
        """The SHA-256 of each file that it was made from."""
        found: Mapping[str, str] = self.document.get("inputs") or self.document["provenance"]["files"]
        return found


@dataclass(frozen=True, slots=True)
class KnownCampaign:
    """What database and folder know of a campaign; ``steps`` has the SHA-256 of each accepted step's file."""

    folder: str
    steps: Mapping[str, str]
    before: PreviousSolution | None


def known_of(session: Session, folder: str) -> KnownCampaign:
    """Return what is known of the campaign of a folder (its resolved path)."""
    row, stored, solved = known_campaign(session, folder), newest_calibration(session, folder), _solved(folder)
    steps = {} if row is None else {step.file: step.sha256 for step in row.steps}
    if stored is None:
        return KnownCampaign(folder, steps, solved)
    document = json.loads(stored.document)
    is_same = solved is not None and solved.inputs == document["inputs"]
    warnings = solved.warnings if solved is not None and is_same else None
    diagnosis = document.get("diagnosis") or _diagnosed(folder, document["inputs"])
    return KnownCampaign(
        folder, steps, PreviousSolution("calibration", stored.sha256, document, warnings, diagnosis)
    )


def _diagnosed(folder: str, files: Mapping[str, str]) -> Mapping[str, Any] | None:
    """Return what the folder's ``diagnosis.json`` found in the same files, None if that cannot be read."""
    try:
        document = json.loads(read_text_file(Path(folder) / DIAGNOSIS, MAX_BYTES))
        is_same = document["format"] == "diagnosis/2" and document["solution"]["provenance"]["files"] == files
        return diagnosis_kept(document) if is_same else None
    except (DataRefused, ValueError, KeyError, TypeError):
        return None


def _solved(folder: str) -> PreviousSolution | None:
    """Return the folder's ``solution.json``, None if there is none that can be read: it is no record."""
    path = Path(folder) / SOLUTION
    try:
        document = json.loads(read_text_file(path, MAX_BYTES))
        if document["format"] != "solution/1":
            return None
        parameters(document)
        files = document["provenance"]["files"]
        before = PreviousSolution(
            "solution", str(path), document, tuple(document["warnings"]), _diagnosed(folder, files)
        )
        return before if before.inputs else None
    except (DataRefused, ValueError, KeyError, TypeError, IndexError, AttributeError):
        return None
