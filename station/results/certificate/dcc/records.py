"""The records of a digital certificate: hashes of what it was made from, chain heads, the calibration itself."""

from base64 import b64encode
from collections.abc import Iterator

from fixtures_db.hash_chain import canonical
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.quantities import no_quantity
from station.results.certificate.dcc.results import result

TITLE = Said("Records, SHA-256", "Aufzeichnungen, SHA-256")
HEADS = Said("Heads of the chains", "Köpfe der Ketten")
FILES = Said("Files used", "Verwendete Dateien")
CALIBRATION = Said("The calibration as it is applied", "Die Kalibrierung, wie sie angewandt wird")
RECORD = Said(
    "The calibration/1 that is certified, byte by byte: its SHA-256 is the one given as this calibration.",
    "Die bescheinigte calibration/1, Byte für Byte: ihr SHA-256 ist der als diese Kalibrierung genannte.",
)


def records_results(content: CertificateContent) -> Iterator[Element]:
    """Give the hashes, then the calibration itself."""
    certificate, document = content.certificate, content.document
    heads = [
        (Said("this calibration", "diese Kalibrierung"), certificate.sha256, "fog_thisCalibration"),
        (Said("newest calibration", "neueste Kalibrierung"), certificate.heads.calibration, "fog_head"),
        (Said("newest face certificate", "neuester Flächenschein"), certificate.heads.certificate, "fog_head"),
        (Said("newest surface plate level", "neueste Nivellierung"), certificate.heads.level, "fog_head"),
        (Said("certificate before this", "Schein vor diesem"), certificate.heads.issued, "fog_head"),
    ]
    if certificate.heads.entries:
        heads.append(
            (Said("journal of the database", "Journal der Datenbank"), certificate.heads.code, "fog_head")
        )
    if "manifest" in document:
        steps = Said("recorded steps, head of their chain", "aufgezeichnete Schritte, Kopf ihrer Kette")
        heads.insert(1, (steps, str(document["manifest"]), "fog_stepsHead"))
    if content.before is not None:
        heads.insert(
            1, (Said("previous calibration", "vorige Kalibrierung"), content.before.sha256, "fog_previous")
        )
    files = [
        no_quantity(Said(name, name), hash_, "fog_rawData") for name, hash_ in sorted(document["inputs"].items())
    ]
    yield result(
        TITLE,
        dcc("list", worded("name", HEADS), *(no_quantity(*each) for each in heads), refType="fog_heads"),
        dcc("list", worded("name", FILES), *files, refType="fog_files"),
        ref_type="fog_records",
    )
    yield result(CALIBRATION, _calibration(content), ref_type="fog_calibration")


def _calibration(content: CertificateContent) -> Element:
    written = canonical(content.document).encode()
    return dcc(
        "byteData",
        worded("name", CALIBRATION),
        worded("description", RECORD),
        dcc("fileName", text="calibration.json"),
        dcc("mimeType", text="application/json"),
        dcc("dataBase64", text=b64encode(written).decode()),
    )
