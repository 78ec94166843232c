"""The demo's certificate: of a simulated unit, by no laboratory, which it says."""

from datetime import date
from pathlib import Path

from fixtures_db.database import Database
from station.errors import Incomplete
from station.files.atomic_file import replace_file
from station.results.certificate.issuing import Request, issue
from station.results.certificate.laboratory import Laboratory

CERTIFICATE = "certificate.html"


def certify(database: Database, sha256: str, received: date, path: Path) -> str:
    """Issue the certificate of a stored calibration into a file; return its path, or what it lacks."""
    try:
        row = issue(database, Request(sha256, demo_laboratory(received)))
    except Incomplete as error:
        return "none: it lacks " + ", ".join(field for field, _ in error.missing)
    replace_file(path, row.html.encode())
    return str(path)


def demo_laboratory(received: date) -> Laboratory:
    """Return what a demo says of a laboratory: that there is none."""
    nobody = {"name": "DEMO: nobody", "address": "a demonstration on simulated devices"}
    return Laboratory.model_validate(
        {
            "format": "laboratory/1",
            "laboratory": {**nobody, "name": "DEMO: no laboratory", "number_prefix": "DEMO-"},
            "authorised": {"name": "DEMO: nobody", "function": "none: a simulated unit was measured"},
            "customer": nobody,
            "item": {"received": received, "condition": "simulated: there is no hardware"},
            "traceability": {"time_base": "the simulator's own time"},
        }
    )
