"""How long the XML of a campaign's certificate takes: ``python -m tests.benchmarks.digital_certificate``.

A simulated campaign of twelve positions and six turns, solved and stored. The start of the validators, once a
process, is counted apart. Shortest of ten runs, by the clock.
"""

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import calibration
from station.files.campaign_folder.notes import write_note
from station.files.setup import Setup
from station.results.campaign_results import make_results, store
from station.results.certificate.dcc.checking import load_validators
from station.results.certificate.dcc.validation import rule_faults, schema_faults
from station.results.certificate.dcc.xml_writing import certificate_xml
from tests.station.guide.stored import recorded
from tests.station.results.certificate.dcc_kinds import content
from tests.station.results.certificate.factory import laboratory
from tests.station.results.certificate.test_from_campaign import furnish

RUNS = 10


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as place, open_db(Path(place) / "station.db") as database:
        furnish(database)
        folder = recorded(Path(place) / "c", database, turned=True, cube_id="CUBE-7", slab_id="SLAB-2")
        write_note(folder, Setup(operator="M. Curie"))
        sha256 = store(make_results(folder, database), database)
        with database.read() as session:
            document = json.loads(calibration(session, sha256).document)
    lab = laboratory().given("traceability", {"gravity_source": "gravimeter"})
    began = perf_counter()
    load_validators()
    start = perf_counter() - began
    said = content(document, laboratory=lab)
    xml = certificate_xml(said)
    steps: dict[str, Callable[[], object]] = {
        "content and XML": lambda: certificate_xml(content(document, laboratory=lab)),
        "schema": lambda: schema_faults(xml),
        "rules of dcclib": lambda: rule_faults(xml),
    }
    print(f"validators read, once a process: {start:.2f} s")
    for name, step in steps.items():
        print(f"{name}: {min(_timed(step) for _ in range(RUNS)):.3f} s")
    print(f"faults {len(schema_faults(xml))}, {len(rule_faults(xml) or ())}; {len(xml) / 1e3:.0f} kB")


def _timed(step: Callable[[], object]) -> float:
    began = perf_counter()
    step()
    return perf_counter() - began


if __name__ == "__main__":
    main()
