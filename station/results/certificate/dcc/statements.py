"""The statements of a digital certificate: what it is, traceability, uncertainty, amendment, conformity."""

from station.results.certificate.content import CertificateContent, greatest_risks
from station.results.certificate.dcc.elements import Bilingual, Element, dcc, joined, worded
from station.results.certificate.dcc.names import as_written
from station.text import plural


def statement(ref_type: str, text: Bilingual, *extra: Element | None, norm: tuple[str, ...] = ()) -> Element:
    """Return a statement; ``extra`` stands after its text, in the order of the schema."""
    norms = (dcc("norm", text=one) for one in norm)
    return dcc("statement", *norms, worded("declaration", text), *extra, refType=ref_type)


CONFORMITY = {"PASS": "pass", "FAIL": "fail"}
CONFORMITY_TEXT = {"PASS": "erfüllt", "FAIL": "nicht erfüllt", "NOT MEASURED": "nicht gemessen"}


def decision_statements(content: CertificateContent) -> list[Element]:
    """Return rule and outcome; without limits that nothing is stated of conformity."""
    found = content.found
    if found is None:
        model = content.document["model"]
        return [
            statement(
                "fog_noConformity",
                Bilingual(
                    f"No statement of conformity is made: no limits were laid down for model {model}.",
                    f"Keine Konformitätsaussage: für das Modell {model} waren keine Grenzen festgelegt.",
                ),
            )
        ]
    word, risks = found.word.replace("_", " "), greatest_risks(found)
    agreed = content.certificate.laboratory.decision.agreed
    rule = Bilingual(*(f"{agreed} " if agreed else "" for _ in range(2))) + Bilingual(
        "Binary statement with guard band: a value is accepted if it lies within its tolerance narrowed at both "
        "ends "
        "by w = r u, u being its combined standard uncertainty and r the factor laid down for the model. PASS: "
        "every "
        f"limited parameter was accepted. Greatest risk of an accepted value: {risks or 'not stated'}.",
        "Binäre Aussage mit Schutzabstand: ein Wert wird angenommen, wenn er innerhalb der beidseits um w = r u "
        "verengten Toleranz liegt; u ist seine kombinierte Standardunsicherheit, r der für das Modell festgelegte "
        f"Faktor. PASS: jeder begrenzte Parameter wurde angenommen. Größtes Risiko eines angenommenen Werts: "
        f"{risks or 'nicht angegeben'}.",
    )
    info = bool(content.certificate.reasons)
    overall = Bilingual(
        f"{word}: {plural(len(found.against), 'limited parameter')} of model {content.document['model']}"
        + ("; for information only, traceability is not claimed" if info else "")
        + f"; at acceptance the verdict was {found.stored.replace('_', ' ')}",
        f"{word} ({CONFORMITY_TEXT[word]}), Zahl begrenzter Parameter {len(found.against)}, Modell "
        f"{content.document['model']}"
        + ("; nur zur Information, Rückführung wird nicht beansprucht" if info else "")
        + f"; bei der Annahme lautete das Urteil {found.stored.replace('_', ' ')}",
    )
    held = CONFORMITY.get(found.word) if not info else None
    return [
        statement("basic_decisionRule", rule, norm=("JCGM 106:2012, 8.3", "ILAC-G8:09/2019")),
        statement(
            "basic_conformity", overall, None if held is None else dcc("conformity", text=held),
            norm=("ISO/IEC 17025:2017, 7.8.6",),
        ),
    ]  # fmt: skip


def statements(content: CertificateContent) -> Element:
    """Return all statements that are of the whole certificate."""
    several = (
        _kind(content), _amendment(content), _traceability(content), _uncertainty(content),
        *decision_statements(content), *_previous(content), _item_alone(), _whole(),
    )  # fmt: skip
    return dcc("statements", *several)


def _kind(content: CertificateContent) -> Element:
    certificate = content.certificate
    simulated = (
        Bilingual(" of a simulated unit", " eines simulierten Geräts")
        if content.is_simulated
        else Bilingual("", "")
    )
    if not certificate.reasons:
        return statement("fog_kindOfDocument", Bilingual("Calibration certificate", "Kalibrierschein") + simulated)
    why = joined(map(as_written, certificate.reasons), "; ")
    return statement(
        "fog_kindOfDocument",
        Bilingual(
            f"Measurement report{simulated.en}. Measured, not calibrated: {why.en}. "
            "The values are those measured; this is no calibration certificate.",
            f"Messbericht{simulated.de}. Gemessen, nicht kalibriert: {why.de}. "
            "Die Werte sind die gemessenen; dies ist kein Kalibrierschein.",
        ),
    )


def _amendment(content: CertificateContent) -> Element | None:
    if (replaced := content.certificate.replaced) is None:
        return None
    reason = replaced.reason.rstrip(".")
    day, changed = replaced.issued_utc.isoformat()[:10], ", ".join(replaced.changed or ()) or "none"
    fields = "" if replaced.changed is None else f" Fields printed otherwise: {changed}."
    felder = "" if replaced.changed is None else f" Anders gedruckte Felder (englisch): {changed}."
    return statement(
        "fog_amendment",
        Bilingual(
            f"Amendment. This document replaces No. {replaced.number} of {day}, SHA-256 {replaced.sha256}, "
            f"which is no longer valid. Reason: {reason}.{fields}",
            f"Änderung. Dieses Dokument ersetzt Nr. {replaced.number} vom {day}, SHA-256 {replaced.sha256}; jenes "
            f"gilt nicht mehr. Grund: {reason}.{felder}",
        ),
        norm=("ISO/IEC 17025:2017, 7.8.8",),
    )


def _traceability(content: CertificateContent) -> Element:
    is_traceable = not content.certificate.reasons and not content.is_simulated
    return dcc(
        "statement",
        dcc("traceable", text=str(is_traceable).lower()),
        worded("declaration", _traced(content)),
        refType="basic_metrologicallyTraceableToSI" if is_traceable else "fog_notTraceable",
    )


def _traced(content: CertificateContent) -> Bilingual:
    if content.certificate.reasons:
        return Bilingual(
            "Not all references held on the day of measurement: traceability to the SI is not claimed.",
            "Nicht alle Bezugsnormale galten am Tag der Messung: Rückführung auf das SI wird nicht beansprucht.",
        )
    if content.is_simulated:
        return Bilingual(
            "A simulated device was measured with simulated references: nothing is traceable to the SI.",
            "Ein simuliertes Gerät wurde mit simulierten Normalen gemessen: nichts ist auf das SI rückgeführt.",
        )
    text = Bilingual(
        "The results are traceable to the International System of Units (SI) through the references named as "
        "measuring equipment, each with the certificate that held for it on the day of measurement",
        "Die Ergebnisse sind über die als Messmittel genannten Normale auf das Internationale Einheitensystem "
        "(SI) "
        "rückgeführt, jedes mit dem am Tag der Messung geltenden Schein",
    )
    if content.is_timed:
        return text + Bilingual(".", ".")
    return text + Bilingual(
        ", with one exception: their second is that of the device\u2019s own clock, compared with no reference "
        "here.",
        ", mit einer Ausnahme: ihre Sekunde ist die der Uhr des Geräts, die hier mit keinem Normal verglichen "
        "wurde.",
    )


def _uncertainty(content: CertificateContent) -> Element:
    percent = f"{100 * content.document['uncertainty']['coverage']:.0f}"
    return statement(
        "fog_expandedUncertainty",
        Bilingual(
            "The expanded uncertainty U is the combined standard uncertainty u multiplied by the coverage "
            "factor k, "
            "which for a Student distribution with the effective degrees of freedom stated (normal where none "
            "are) "
            f"corresponds to a coverage probability of approximately {percent} %; u = U / k. It holds at "
            f"the "
            "time and under the conditions of the measurement and says nothing of the unit\u2019s stability.",
            "Die erweiterte Unsicherheit U ist die kombinierte Standardunsicherheit u mal dem "
            "Erweiterungsfaktor k, "
            "der für eine Student-Verteilung mit den genannten effektiven Freiheitsgraden (normal, wo keine "
            "genannt "
            f"sind) einer Überdeckungswahrscheinlichkeit von etwa {percent} % entspricht; u = U / k. "
            f"Sie gilt "
            "für Zeit und Bedingungen der Messung und sagt nichts über die Stabilität des Geräts.",
        ),
        norm=("JCGM 100:2008",),
    )


def _previous(content: CertificateContent) -> list[Element]:
    if content.before is None:
        first = Bilingual(
            "As found: this is the first calibration of the unit by this station.",
            "Eingangszustand: dies ist die erste Kalibrierung des Geräts an dieser Station.",
        )
        return [statement("fog_asFound", first)]
    left = Bilingual(
        "As left: the parameters of this certificate. Nothing was adjusted on the unit itself.",
        "Ausgangszustand: die Parameter dieses Scheins. Am Gerät selbst wurde nichts justiert.",
    )
    return [statement("fog_asLeft", left)]


def _item_alone() -> Element:
    return statement(
        "fog_itemAlone",
        Bilingual(
            "The results relate only to the item named, in the condition in which it was received and measured.",
            "Die Ergebnisse beziehen sich nur auf den genannten Gegenstand im Zustand bei Eingang und Messung.",
        ),
        norm=("ISO/IEC 17025:2017, 7.8.2.1 l",),
    )


def _whole() -> Element:
    return statement(
        "fog_reproduction",
        Bilingual(
            "This document shall not be reproduced except in full without written approval of the laboratory.",
            "Dieses Dokument darf ohne schriftliche Zustimmung des Labors nur vollständig weitergegeben werden.",
        ),
    )
