"""The measuring equipment of a digital certificate: cube, slab and site, with their records and due dates."""

from collections.abc import Mapping
from typing import Any

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.dsi_units import MILLIMETRE
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.names import as_written
from station.results.certificate.dcc.quantities import real

EQUIPMENT = {
    "cube": Said("Cube with measured faces", "Würfel mit vermessenen Flächen"),
    "slab": Said("Level slab", "Richtplatte"),
    "site": Said("Surveyed site: local gravity", "Vermessener Ort: örtliche Schwere"),
}
DATES = (
    ("source", Said("determined by", "bestimmt durch"), "fog_determinedBy"),
    ("measured_utc", Said("determined on", "bestimmt am"), "fog_determinedOn"),
    ("due_date", Said("last day on which it holds", "letzter Tag der Gültigkeit"), "fog_dueDate"),
)


def measuring_equipments(content: CertificateContent) -> Element:
    """Return the references: cube, slab and site, with the records of their certificates and their due dates."""
    return dcc("measuringEquipments", *(_equipment(one) for one in content.document["references"]))


def _equipment(one: Mapping[str, Any]) -> Element:
    details = [
        dcc("measuringEquipmentQuantity", worded("name", name), worded("noQuantity", str(one[key])), refType=ref)
        for key, name, ref in DATES
        if one.get(key)
    ]
    if "side_mm" in one:
        side = Said("side", "Kantenlänge")
        details.insert(
            0, dcc("measuringEquipmentQuantity", worded("name", side), real(one["side_mm"], MILLIMETRE))
        )
    return dcc(
        "measuringEquipment",
        worded("name", EQUIPMENT.get(one["kind"], as_written(str(one["kind"])))),
        _certificate(one) if one.get("certificate") else None,
        dcc(
            "identifications",
            dcc("identification", dcc("issuer", text="calibrationLaboratory"), dcc("value", text=str(one["id"]))),
        ),
        dcc("measuringEquipmentQuantities", *details) if details else None,
        refType="basic_measurementStandard",
    )


def _certificate(one: Mapping[str, Any]) -> Element:
    return dcc(
        "certificate",
        worded("referral", Said("record of its certificate", "Datensatz ihres Scheins")),
        dcc("referralID", text=str(one["id"])),
        dcc("procedure", text="SHA-256"),
        dcc("value", text=str(one["certificate"])),
    )
