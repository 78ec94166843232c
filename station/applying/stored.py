"""The newest calibration that the database holds of a serial number."""

import json

from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import history
from station.calibration import Calibration, calibration_of
from station.errors import DataRefused


def newest_of(serial: str, database: str | None, model: str | None) -> Calibration:
    """Return it; ``model`` tells units of one serial number apart.

    Raises
    ------
    DataRefused
        If there is none, or there are several models of this serial number.
    """
    with open_db(database) as opened, opened.read() as session:
        documents = [(json.loads(row.document), row.sha256) for row in history(session, serial)]
    models = sorted({str(document["model"]) for document, _ in documents})
    wanted = model if model in models else models[0] if len(models) == 1 else None
    if wanted is None:
        found = (
            f"models {', '.join(models)} of serial {serial}" if models else f"no calibration of serial {serial}"
        )
        expected = "a file of calibration/1, or a serial number that is stored"
        raise DataRefused("the database", None, found, expected, "give --calibration FILE")
    document, sha256 = next(each for each in reversed(documents) if each[0]["model"] == wanted)
    return calibration_of(document, sha256[:12])
