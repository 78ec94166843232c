"""The administrative part of a digital certificate: software, core data, item, laboratory, persons, statements."""

import re

from station.results.certificate import sentences
from station.results.certificate.content import Certificate, CertificateContent
from station.results.certificate.dcc.elements import Element, Text, dcc, worded
from station.results.certificate.dcc.names import LANGUAGES, Bilingual, joined

VERSION = re.compile(r"^(?P<name>\S+) (?P<release>\d{1,3}(?:\.\d{1,3}){0,3})")
CONFORMITY = {"PASS": "pass", "FAIL": "fail"}
CONFORMITY_TEXT = {"PASS": "erfüllt", "FAIL": "nicht erfüllt", "NOT MEASURED": "nicht gemessen"}
NOT_STATED = Bilingual("not stated", "nicht angegeben")


def administrative_data(content: CertificateContent) -> Element:
    """Return all of it, with the statements."""
    certificate = content.certificate
    return dcc(
        "administrativeData",
        dcc("dccSoftware", software(str(content.document["software"]))),
        _core_data(certificate),
        _items(content),
        _laboratory(certificate),
        _persons(certificate),
        _contact("customer", certificate.laboratory.customer),
        statements(content),
    )


def software(text: str) -> Element:
    """Return the program with its release, as the form wants it written; the commit is in its description."""
    found = VERSION.match(text)
    return dcc(
        "software",
        worded("name", found["name"] if found else text.split()[0]),
        dcc("release", text=f"v{found['release']}" if found else "v0"),
        dcc("type", text="application"),
        worded("description", Bilingual(f"Version and commit: {text}", f"Version und Commit: {text}")),
    )


def _core_data(certificate: Certificate) -> Element:
    document, lab, replaced = certificate.document, certificate.laboratory, certificate.replaced
    procedure = document["procedure"]
    return dcc(
        "coreData",
        dcc("countryCodeISO3166_1", text=lab.laboratory.country),
        *(dcc("usedLangCodeISO639_1", text=lang) for lang in LANGUAGES),
        dcc("mandatoryLangCodeISO639_1", text=LANGUAGES[0]),
        dcc("uniqueIdentifier", text=certificate.number),
        dcc(
            "identifications",
            _identification("calibrationLaboratory", certificate.sha256, CALIBRATION, "fog_calibrationHash"),
            _identification("calibrationLaboratory", certificate.issued_utc.isoformat(), ISSUED, "fog_issuedUtc"),
            _identification("calibrationLaboratory", document["accepted_utc"], ACCEPTED, "fog_acceptedUtc"),
        ),
        None if lab.item.received is None else dcc("receiptDate", text=lab.item.received.isoformat()),
        dcc("beginPerformanceDate", text=procedure["started_utc"][:10]),
        dcc("endPerformanceDate", text=procedure["ended_utc"][:10]),
        dcc("performanceLocation", text="other" if lab.laboratory.location else "laboratory"),
        None
        if replaced is None
        else dcc(
            "previousReport",
            worded("referral", REPLACED),
            dcc("referralID", text=replaced.number),
            dcc("procedure", text="SHA-256"),
            dcc("value", text=replaced.sha256),
        ),
    )


CALIBRATION = Bilingual("SHA-256 of the calibration certified", "SHA-256 der bescheinigten Kalibrierung")
ISSUED = Bilingual("issued", "ausgestellt")
ACCEPTED = Bilingual("calibration accepted", "Kalibrierung angenommen")
REPLACED = Bilingual("the certificate that this one replaces", "der Kalibrierschein, den dieser ersetzt")
SERIAL = Bilingual("serial number", "Seriennummer")


def _identification(issuer: str, value: str, name: Bilingual, ref_type: str) -> Element:
    return dcc(
        "identification",
        dcc("issuer", text=issuer),
        dcc("value", text=value),
        worded("name", name),
        refType=ref_type,
    )


def _items(content: CertificateContent) -> Element:
    document, item = content.document, content.certificate.laboratory.item
    condition = Bilingual(f"Condition on receipt: {item.condition}", f"Zustand bei Eingang: {item.condition}")
    return dcc(
        "items",
        dcc(
            "item",
            worded("name", sentences.SIMULATED_ITEM if content.is_simulated else sentences.ITEM),
            worded("description", condition),
            dcc("manufacturer", worded("name", item.manufacturer or NOT_STATED)),
            dcc("model", text=str(document["model"])),
            dcc(
                "identifications",
                _identification("manufacturer", str(document["serial"]), SERIAL, "basic_serialNumber"),
            ),
        ),
    )


def _laboratory(certificate: Certificate) -> Element:
    text = certificate.laboratory.laboratory
    code = None if not text.accreditation else dcc("calibrationLaboratoryCode", text=text.accreditation)
    return dcc("calibrationLaboratory", code, _contact("contact", text, text.country))


def _contact(element: str, text: object, country: str | None = None) -> Element:
    name, address, email = (getattr(text, field) for field in ("name", "address", "email"))
    where = dcc(
        "location",
        worded("further", str(address)),
        dcc("countryCode", text=country) if country else None,
    )
    return dcc(element, worded("name", str(name)), dcc("eMail", text=str(email)), where)


def _persons(certificate: Certificate) -> Element:
    authorised = certificate.laboratory.authorised
    return dcc(
        "respPersons",
        _person(str(authorised.name), Bilingual("authorised the certificate", "gibt den Kalibrierschein frei"),
                role=str(authorised.function), main="true"),
        _person(str(certificate.document["operator"]), Bilingual("measured", "hat gemessen"), "operator", "false"),
    )  # fmt: skip


def _person(name: Text, what: Bilingual, role: str, main: str) -> Element:
    return dcc(
        "respPerson",
        dcc("person", worded("name", name)),
        worded("description", Bilingual(what.en, what.de)),
        dcc("role", text=role),
        dcc("mainSigner", text=main),
    )


def statement(ref_type: str, text: Bilingual, *extra: Element | None, norm: tuple[str, ...] = ()) -> Element:
    """Return a statement; ``extra`` stands after its text, in the order of the schema."""
    norms = (dcc("norm", text=one) for one in norm)
    return dcc("statement", *norms, worded("declaration", text), *extra, refType=ref_type)


def decision_statements(content: CertificateContent) -> list[Element]:
    """Return rule and outcome; without limits that nothing is stated of conformity."""
    found = content.found
    if found is None:
        return [statement("fog_noConformity", sentences.no_conformity(content.document))]
    agreed, word = content.certificate.laboratory.decision.agreed, found.word.replace("_", " ")
    parts = (sentences.RULE, sentences.passed(content), sentences.FAIL, sentences.NOT_MEASURED)
    rule = joined((Bilingual(agreed, agreed), *parts) if agreed else parts, " ")
    overall = Bilingual(f"{word}: ", f"{word} ({CONFORMITY_TEXT[word]}): ") + sentences.outcome(content)
    held = None if content.certificate.reasons else CONFORMITY.get(found.word)
    return [
        statement("basic_decisionRule", rule, norm=("JCGM 106:2012, 8.3", "ILAC-G8:09/2019")),
        statement(
            "basic_conformity", overall, None if held is None else dcc("conformity", text=held),
            norm=("ISO/IEC 17025:2017, 7.8.6",),
        ),
    ]  # fmt: skip


def statements(content: CertificateContent) -> Element:
    """Return all statements that are of the whole certificate."""
    replaced, is_first = content.certificate.replaced, content.before is None
    kind = (content.certificate.title, sentences.measured_only(content))
    return dcc(
        "statements",
        statement("fog_kindOfDocument", joined((one for one in kind if one.en), ". ")),
        None
        if replaced is None
        else statement("fog_amendment", sentences.amendment(replaced), norm=("ISO/IEC 17025:2017, 7.8.8",)),
        _traceability(content),
        statement("fog_expandedUncertainty", sentences.uncertainty(content.document), norm=("JCGM 100:2008",)),
        *decision_statements(content),
        statement("fog_asFound", sentences.FIRST) if is_first else statement("fog_asLeft", sentences.AS_LEFT),
        statement("fog_itemAlone", sentences.ITEM_ALONE, norm=("ISO/IEC 17025:2017, 7.8.2.1 l",)),
        statement("fog_reproduction", sentences.REPRODUCTION),
    )


def _traceability(content: CertificateContent) -> Element:
    is_traceable = not content.certificate.reasons and not content.is_simulated
    return dcc(
        "statement",
        dcc("traceable", text=str(is_traceable).lower()),
        worded("declaration", sentences.traceability(content)),
        refType="basic_metrologicallyTraceableToSI" if is_traceable else "fog_notTraceable",
    )
