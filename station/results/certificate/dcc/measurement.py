"""The measurement of a digital certificate: methods, equipment, conditions, results, records, remarks."""

from base64 import b64encode
from collections.abc import Iterator, Mapping
from typing import Any

from fixtures_db.hash_chain import canonical
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.administrative import software
from station.results.certificate.dcc.elements import (
    DEGREE,
    DEGREE_CELSIUS,
    METRE,
    METRE_PER_S2,
    MILLIMETRE,
    PERCENT,
    DsiUnit,
    Element,
    Expanded,
    dcc,
    no_quantity,
    of_normal,
    quantity,
    real,
    worded,
)
from station.results.certificate.dcc.names import Bilingual, as_written, joined
from station.results.certificate.dcc.results import (
    budget_result,
    covariance_results,
    effects_and_global_test,
    parameter_results,
    result,
)
from station.results.certificate.sentences import DEVIATIONS, STATED, TAKEN_AS_ZERO

TITLE = Bilingual("Records, SHA-256", "Aufzeichnungen, SHA-256")
HEADS = Bilingual("Heads of the chains", "Köpfe der Ketten")
FILES = Bilingual("Files used", "Verwendete Dateien")
CALIBRATION = Bilingual("The calibration as it is applied", "Die Kalibrierung, wie sie angewandt wird")
RECORD = Bilingual(
    "The calibration/1 that is certified, byte by byte: its SHA-256 is the one given as this calibration.",
    "Die bescheinigte calibration/1, Byte für Byte: ihr SHA-256 ist der als diese Kalibrierung genannte.",
)


def records_results(content: CertificateContent) -> Iterator[Element]:
    """Give the hashes, then the calibration itself."""
    certificate, document, before = content.certificate, content.document, content.before
    chains = certificate.heads
    heads = (
        ("this calibration", "diese Kalibrierung", certificate.sha256, "fog_thisCalibration"),
        ("previous calibration", "vorige Kalibrierung", before and before.sha256, "fog_previous"),
        ("recorded steps, head of their chain", "aufgezeichnete Schritte, Kopf ihrer Kette",
         document.get("manifest"), "fog_stepsHead"),
        ("newest calibration", "neueste Kalibrierung", chains.calibration, "fog_head"),
        ("newest face certificate", "neuester Flächenschein", chains.certificate, "fog_head"),
        ("newest surface plate level", "neueste Nivellierung", chains.level, "fog_head"),
        ("certificate before this", "Schein vor diesem", chains.issued, "fog_head"),
        ("journal of the database", "Journal der Datenbank", chains.code if chains.entries else None, "fog_head"),
    )  # fmt: skip
    stated = [no_quantity(Bilingual(en, de), str(head), ref) for en, de, head, ref in heads if head is not None]
    files = [
        no_quantity(Bilingual(name, name), hash_, "fog_rawData")
        for name, hash_ in sorted(document["inputs"].items())
    ]
    yield result(
        TITLE,
        dcc("list", worded("name", HEADS), *stated, refType="fog_heads"),
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


def influence_conditions(content: CertificateContent) -> Element:
    """Return temperatures, humidity, gravity and latitude, as far as they are known."""
    document, lab = content.document, content.certificate.laboratory
    site, room = document["site"], lab.environment
    place = str(site.get("id") or lab.laboratory.location or lab.laboratory.address)
    std = of_normal(site["gravity_std_m_s2"])
    known = (
        _span("unit", UNIT_TEMPERATURE, "basic_temperature", document.get("temperature_range_c"), DEGREE_CELSIUS),
        _span("room", ROOM_TEMPERATURE, "basic_temperature", room.temperature_c, DEGREE_CELSIUS),
        _span("room", HUMIDITY, "basic_humidityRelative", room.humidity_percent, PERCENT),
        _one(GRAVITY, site["gravity_m_s2"], METRE_PER_S2, "fog_localGravity", std),
        _one(LATITUDE, site["latitude_deg"], DEGREE, "fog_latitude"),
        _one(HEIGHT, site.get("height_m"), METRE, "fog_height"),
        _one(REFERENCE, document.get("reference_temperature_c"), DEGREE_CELSIUS, "fog_referenceTemperature"),
        _condition(PLACE, "fog_site", no_quantity(PLACE, place)),
    )
    return dcc("influenceConditions", *known)


UNIT_TEMPERATURE = Bilingual("temperature of the unit", "Temperatur des Geräts")
ROOM_TEMPERATURE = Bilingual("temperature of the laboratory", "Temperatur des Labors")
HUMIDITY = Bilingual("relative humidity", "relative Luftfeuchte")
GRAVITY = Bilingual("local gravity, standard uncertainty", "örtliche Fallbeschleunigung, Standardunsicherheit")
LATITUDE = Bilingual("latitude", "geographische Breite")
HEIGHT = Bilingual("height", "Höhe")
REFERENCE = Bilingual(
    "temperature of the unit that results refer to", "Gerätetemperatur, auf die Ergebnisse sich beziehen"
)
PLACE = Bilingual("site", "Ort")
ENDS = (("Min", Bilingual("least", "kleinste")), ("Max", Bilingual("greatest", "größte")))


def _span(of: str, name: Bilingual, ref_type: str, span: Any, unit: DsiUnit) -> Element | None:
    if not span:
        return None
    ends = [
        quantity(name + Bilingual(f", {word.en}", f", {word.de}"), real(value, unit), ref_type=f"{ref_type}{end}")
        for value, (end, word) in zip(span, ENDS, strict=True)
    ]
    return _condition(name, f"{ref_type} fog_{of}", *ends)


def _one(
    name: Bilingual, value: float | None, unit: DsiUnit, ref_type: str, expanded: Expanded | None = None
) -> Element | None:
    return None if value is None else _condition(name, ref_type, quantity(name, real(value, unit, expanded)))


def _condition(name: Bilingual, ref_type: str, *quantities: Element) -> Element:
    return dcc("influenceCondition", worded("name", name), dcc("data", *quantities), refType=ref_type)


EQUIPMENT = {
    "cube": Bilingual("Cube with measured faces", "Würfel mit vermessenen Flächen"),
    "slab": Bilingual("Level slab", "Richtplatte"),
    "site": Bilingual("Surveyed site: local gravity", "Vermessener Ort: örtliche Schwere"),
}
DATES = (
    ("source", Bilingual("determined by", "bestimmt durch"), "fog_determinedBy"),
    ("measured_utc", Bilingual("determined on", "bestimmt am"), "fog_determinedOn"),
    ("due_date", Bilingual("last day on which it holds", "letzter Tag der Gültigkeit"), "fog_dueDate"),
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
        side = Bilingual("side", "Kantenlänge")
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
        worded("referral", Bilingual("record of its certificate", "Datensatz ihres Scheins")),
        dcc("referralID", text=str(one["id"])),
        dcc("procedure", text="SHA-256"),
        dcc("value", text=str(one["certificate"])),
    )


EQUATIONS = {  # by number, LaTeX: model, application, expanded uncertainty, error as found, acceptance, risk
    "1": r"\mathbf{N} = \mathbf{K} \circ (\mathbf{E}\,\mathbf{u} + \mathbf{D})",
    "2": r"\mathbf{u} = \mathbf{E}^{-1} (\mathbf{N} / \mathbf{K} - \mathbf{D})",
    "3": r"U = k_p(\nu_\mathrm{eff})\, u",
    "4": r"e = p_\mathrm{now} - p_\mathrm{prev},\; U(e) = 2\sqrt{u_\mathrm{now}^2 + u_\mathrm{prev}^2}",
    "5": r"L + r u \le y \le H - r u",
    "6": r"p = 1 - F_\nu\!\left(\frac{H-y}{u}\right) + F_\nu\!\left(\frac{L-y}{u}\right)",
}


def used_methods(content: CertificateContent) -> Element:
    """Return the procedure, how the uncertainty was evaluated, and the rule of decision where there are limits."""
    procedure = content.document["procedure"]
    name = as_written(str(procedure["name"]))
    steps = f"{len(procedure['steps'])}: {', '.join(map(str, procedure['steps']))}"
    joint = Bilingual(
        "Joint least-squares solution of equation (1) for both triads and the bench. N: count rate, u: specific "
        f"force or angular rate in body axes, rows of E of unit length. Steps, {steps}.",
        "Gemeinsame Ausgleichung der Gleichung (1) für beide Triaden und den Messplatz. N: Zählrate, u: "
        "spezifische "
        f"Kraft oder Drehrate in Körperachsen, Zeilen von E der Länge eins. Schritte, {steps}.",
    )
    budget = Bilingual(
        "Uncertainty budget by sources, combined after JCGM 100:2008; degrees of freedom after Welch and "
        "Satterthwaite; equation (3).",
        "Unsicherheitsbudget nach Quellen, kombiniert nach JCGM 100:2008; Freiheitsgrade nach Welch und "
        "Satterthwaite; Gleichung (3).",
    )
    methods = [
        _method("basic_calibrationMethod", name, joint, ("1", "2", "4")),
        _method("basic_methodMeasurementUncertainty", UNCERTAINTY, budget, ("3",), "JCGM 100:2008"),
    ]
    if content.found is not None:
        methods.append(_method("basic_decisionRule", RULE, RULE_TEXT, ("5", "6"), "JCGM 106:2012, 8.3"))
    return dcc("usedMethods", *methods)


UNCERTAINTY = Bilingual("Evaluation of the measurement uncertainty", "Ermittlung der Messunsicherheit")
RULE = Bilingual("Decision rule", "Entscheidungsregel")
RULE_TEXT = Bilingual(
    "Guarded acceptance, equation (5); the risk of a wrong decision is that of equation (6).",
    "Annahme mit Schutzabstand, Gleichung (5); das Risiko einer falschen Entscheidung ist das der Gleichung (6).",
)


def _method(
    ref_type: str, name: Bilingual, text: Bilingual, numbers: tuple[str, ...], norm: str | None = None
) -> Element:
    description = worded("description", text)
    for number in numbers:
        description.append(dcc("formula", dcc("latex", text=rf"{EQUATIONS[number]} \tag{{{number}}}")))
    norms = () if norm is None else (dcc("norm", text=norm),)
    return dcc("usedMethod", worded("name", name), description, *norms, refType=ref_type)


NAME = Bilingual("Calibration of an inertial measurement unit", "Kalibrierung einer Inertialmesseinheit")


def measurement_result(content: CertificateContent) -> Element:
    """Return the one measurement with all its results."""
    return dcc(
        "measurementResult",
        worded("name", NAME),
        used_methods(content),
        dcc("usedSoftware", software(str(content.document["software"]))),
        measuring_equipments(content),
        influence_conditions(content),
        dcc(
            "results",
            *parameter_results(content),
            *covariance_results(content),
            budget_result(content),
            *effects_and_global_test(content),
            *records_results(content),
        ),
        dcc("measurementMetaData", *_remarks(content)),
    )


def _remarks(content: CertificateContent) -> list[Element]:
    none = Bilingual("none", "keine")
    several = (
        ("fog_deviations", DEVIATIONS, content.deviations),
        ("fog_takenAsZero", TAKEN_AS_ZERO, content.taken_as_zero),
        ("fog_stated", STATED, [f"{label}: {text}" for label, text in content.stated]),
    )
    diagnosis = joined(map(as_written, content.diagnosis), " ")  # whole sentences, the first of which is its title
    remarks = [
        (ref_type, title + Bilingual(": ", ": ") + (joined(map(as_written, wording), "; ") if wording else none))
        for ref_type, title, wording in several
    ]
    return [
        dcc("metaData", worded("declaration", wording), refType=ref_type)
        for ref_type, wording in (*remarks[:1], ("fog_diagnosis", diagnosis), *remarks[1:])
    ]
