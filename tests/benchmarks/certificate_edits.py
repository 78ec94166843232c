"""Edit signed certificates: is every edit detected, and no honest document refused?

Half of the edits are of the XML, half of the PDF with that XML attached. An edit is detected if something does not
hold or the file is refused. Edits that change nothing that is signed must hold: white space within tags, quotes.
"""

import random
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lxml import etree

from fixtures_db.database import open_db
from station.errors import StationError
from station.results.certificate.issuing import issue
from station.results.certificate.signing.key_certificate import Trust
from station.results.certificate.signing.verification import verify_pdf, verify_xml
from tests.proof.evidence import Figure, zero
from tests.station.results.certificate.factory import accepted, laboratory
from tests.station.results.certificate.signing import pdf_edits, xml_edits
from tests.station.results.certificate.signing.signed_files import signed_files, trusted


def is_detected(content: bytes, look: Callable[..., Any], trust: Trust) -> bool:
    """Return whether a file is refused or found faulty; anything else that is raised is a bug."""
    try:
        return bool(look(content, "edited", trust).faults)
    except StationError:
        return True


def edited_xml(content: bytes, kind: str, chance: random.Random) -> bytes:
    """Return a document after one edit."""
    root = etree.fromstring(content)
    xml_edits.EDITS[kind](root, chance)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8")


def unchanged_xml(content: bytes, chance: random.Random) -> bytes:
    """Return a document that is written otherwise and says the same."""
    text = content.decode()
    way = chance.randrange(4)
    if way == 0:
        return text.replace('" xmlns:si=', '"   xmlns:si=', 1).encode()
    if way == 1:
        return text.replace("/>", " />").encode()
    if way == 2:
        return (text + "\n<!-- behind it -->\n").encode()
    return text.replace('schemaVersion="3.1.2"', "schemaVersion='3.1.2'").encode()


def missed(count: int, seed: int, files: tuple[bytes, bytes]) -> tuple[Counter[str], list[str]]:
    """Return how many edits of each kind were made, and which were missed."""
    made, lost, chance, trust = Counter[str](), list[str](), random.Random(seed), trusted()
    kinds = [("XML", kind) for kind in xml_edits.EDITS] + [("PDF", kind) for kind in pdf_edits.EDITS]
    for number in range(count):
        form, kind = kinds[number % len(kinds)]
        before = files[form == "PDF"]
        after = edited_xml(before, kind, chance) if form == "XML" else pdf_edits.EDITS[kind](before, chance)
        made[f"{form} {kind}"] += 1
        if not is_detected(after, verify_xml if form == "XML" else verify_pdf, trust):
            lost.append(f"{form} {kind} {number}")
    return made, lost


def false_alarms(count: int, seed: int, files: tuple[bytes, bytes]) -> int:
    """Return how many documents that say the same were said to be faulty."""
    chance, trust = random.Random(seed), trusted()
    return sum(is_detected(unchanged_xml(files[0], chance), verify_xml, trust) for _ in range(count))


def own_certificate(folder: Path) -> bytes:
    """Return the XML of a certificate that the station issued."""
    with open_db(folder / "station.db") as database:
        with database.write() as session:
            accepted(session)
        issued = issue(database, "S0101", laboratory(), digital=True)
    return issued.dcc.encode()


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Make ``size`` edits, and a tenth as many that change nothing."""
    with tempfile.TemporaryDirectory() as folder:
        files = signed_files(Path(folder), own_certificate(Path(folder)))
    made, lost = missed(size, seed, files)
    return {
        "kinds of edits": Figure(len(made)),
        "edits missed": zero(len(lost)),
        "honest documents refused": zero(false_alarms(max(size // 10, 1), seed, files)),
    }
