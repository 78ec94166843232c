"""The fixed sentences of a certificate, each in English and German: HTML and XML have the same."""

from collections.abc import Mapping
from typing import Any

from station.results.certificate.content import CertificateContent, ReplacedCertificate, greatest_risks
from station.results.certificate.dcc.names import Bilingual, as_written, joined
from station.text import plural

ITEM = Bilingual(
    "Inertial measurement unit with fibre-optic gyroscopes and accelerometers",
    "Inertialmesseinheit mit faseroptischen Kreiseln und Beschleunigungsmessern",
)
SIMULATED_ITEM = ITEM + Bilingual(
    " (simulated device: no hardware was measured)", " (simuliertes Gerät: keine Hardware gemessen)"
)
DEVIATIONS = Bilingual("Deviations from the procedure and remarks", "Abweichungen vom Verfahren und Bemerkungen")
STATED = Bilingual("Stated, not measured here", "Angegeben, hier nicht gemessen")
TAKEN_AS_ZERO = Bilingual(
    "Not determined by these steps; assumed zero, or equal to that of the cube's mean faces",
    "In diesen Schritten nicht bestimmt und null gesetzt oder gleich denen des mittleren Würfels",
)
EFFECTS = Bilingual(
    "Error terms in the model, in addition to K, E and D", "Fehlerterme im Modell neben K, E und D"
)
FIRST = Bilingual(
    "As found: this is the first calibration of the unit by this station; there is no previous one to compare "
    "with.",
    "Eingangszustand: dies ist die erste Kalibrierung des Geräts an dieser Station; es gibt keine frühere zum "
    "Vergleich.",
)
AS_LEFT = Bilingual(
    "As left: the parameters of this document. The unit itself was not adjusted; the parameters take effect "
    "when they replace the earlier ones.",
    "Ausgangszustand: die Parameter dieses Dokuments. Am Gerät selbst wurde nichts justiert; die Parameter "
    "wirken, sobald sie die früheren ersetzen.",
)
ITEM_ALONE = Bilingual(
    "The results relate only to the item named here, in the condition in which it was received and measured.",
    "Die Ergebnisse beziehen sich nur auf den hier genannten Gegenstand im Zustand bei Eingang und Messung.",
)
REPRODUCTION = Bilingual(
    "This document shall not be reproduced except in full without written approval of the laboratory.",
    "Dieses Dokument darf ohne schriftliche Zustimmung des Labors nur vollständig weitergegeben werden.",
)
RULE = Bilingual(
    "Binary statement with guard band (JCGM 106:2012, 8.3; ILAC-G8:09/2019). A value is accepted if it lies "
    "within its tolerance narrowed at both ends by the guard band w = r u, u being its combined standard "
    "uncertainty and r the factor laid down for the model.",
    "Binäre Aussage mit Schutzabstand (JCGM 106:2012, 8.3; ILAC-G8:09/2019). Ein Wert wird angenommen, wenn er "
    "innerhalb der beidseits um w = r u verengten Toleranz liegt; u ist seine kombinierte Standardunsicherheit, "
    "r der für das Modell festgelegte Faktor.",
)
FAIL = Bilingual(
    "FAIL: at least one parameter was not accepted; it may still conform; its risk is the probability that it "
    "does not.",
    "FAIL: mindestens ein Parameter wurde nicht angenommen; er kann dennoch konform sein; sein Risiko ist die "
    "Wahrscheinlichkeit, dass er es nicht ist.",
)
NOT_MEASURED = Bilingual(
    "NOT MEASURED: none failed and at least one has no value.",
    "NOT MEASURED: keiner wurde abgelehnt, und mindestens einer hat keinen Wert.",
)


def measured_only(content: CertificateContent) -> Bilingual:
    """Return why it is no calibration certificate; empty if it is one."""
    if not content.certificate.reasons:
        return Bilingual("", "")
    why = joined(map(as_written, content.certificate.reasons), "; ")
    return Bilingual(
        f"Measured, not calibrated: {why.en}. The values are those measured; this is no calibration certificate.",
        f"Gemessen, nicht kalibriert: {why.de}. Die Werte sind die gemessenen; dies ist kein Kalibrierschein.",
    )


def amendment(replaced: ReplacedCertificate) -> Bilingual:
    """Return what is replaced, why, and which fields differ where they were compared."""
    day, reason = replaced.issued_utc.isoformat()[:10], replaced.reason.rstrip(".")
    text = Bilingual(
        f"Amendment. This document replaces No. {replaced.number} of {day}, SHA-256 {replaced.sha256}, which is "
        f"no longer valid. Reason: {reason}.",
        f"Änderung. Dieses Dokument ersetzt Nr. {replaced.number} vom {day}, SHA-256 {replaced.sha256}; jenes "
        f"gilt nicht mehr. Grund: {reason}.",
    )
    if replaced.changed is None:
        return text
    fields = ", ".join(replaced.changed) or "none"
    return text + Bilingual(
        f" Fields printed otherwise: {fields}.", f" Anders gedruckte Felder (englisch): {fields}."
    )


def uncertainty(document: Mapping[str, Any]) -> Bilingual:
    """Return what U, k and u are, and when they hold."""
    percent = f"{100 * document['uncertainty']['coverage']:.0f}"
    return Bilingual(
        "The expanded uncertainty U is the combined standard uncertainty u multiplied by the coverage factor k, "
        "which for a Student distribution with the effective degrees of freedom \u03bd stated (∞ or none: "
        f"normal) corresponds to a coverage probability of approximately {percent} %. It was evaluated according "
        "to JCGM 100:2008 (GUM) and holds at the time and under the conditions of the measurement; it says "
        "nothing of the unit\u2019s stability thereafter.",
        "Die erweiterte Unsicherheit U ist die kombinierte Standardunsicherheit u mal dem Erweiterungsfaktor k, "
        "der für eine Student-Verteilung mit den genannten effektiven Freiheitsgraden \u03bd (∞ oder keine: "
        f"normal) einer Überdeckungswahrscheinlichkeit von etwa {percent} % entspricht. Sie wurde nach JCGM "
        "100:2008 (GUM) ermittelt und gilt für Zeit und Bedingungen der Messung; sie sagt nichts über die "
        "spätere Stabilität des Geräts.",
    )


def traceability(content: CertificateContent) -> Bilingual:
    """Return what the results are traceable to, or why to nothing."""
    if content.certificate.reasons:
        return Bilingual(
            "Not all references named here held on the day of measurement: traceability to the SI is not claimed.",
            "Nicht alle hier genannten Normale galten am Tag der Messung: Rückführung auf das SI wird nicht "
            "beansprucht.",
        )
    if content.is_simulated:
        return Bilingual(
            "A simulated device was measured with simulated references: nothing is traceable to the SI, and "
            "this document only shows what a certificate says.",
            "Ein simuliertes Gerät wurde mit simulierten Normalen gemessen: nichts ist auf das SI rückgeführt, "
            "und dieses Dokument zeigt nur, was ein Kalibrierschein sagt.",
        )
    text = Bilingual(
        "The results are traceable to the International System of Units (SI) through the references named here, "
        "each with the certificate that held for it on the day of measurement",
        "Die Ergebnisse sind über die hier genannten Normale auf das Internationale Einheitensystem (SI) "
        "rückgeführt, jedes mit dem am Tag der Messung geltenden Schein",
    )
    if content.is_timed:
        return text + Bilingual(".", ".")
    return text + Bilingual(
        ", with one exception: their second is that of the device\u2019s own clock, which was compared with no "
        "reference here.",
        ", mit einer Ausnahme: ihre Sekunde ist die der Uhr des Geräts, die hier mit keinem Normal verglichen "
        "wurde.",
    )


def no_conformity(document: Mapping[str, Any]) -> Bilingual:
    """Return why nothing is stated of conformity."""
    return Bilingual(
        f"No statement of conformity is made: no limits were laid down for model {document['model']} when the "
        "calibration was accepted.",
        f"Keine Konformitätsaussage: für das Modell {document['model']} waren keine Grenzen festgelegt, als die "
        "Kalibrierung angenommen wurde.",
    )


def passed(content: CertificateContent) -> Bilingual:
    """Return what PASS means, with the greatest risk of an accepted value where its sigma is known."""
    text = Bilingual(
        "PASS: every limited parameter was accepted.", "PASS: jeder begrenzte Parameter wurde angenommen."
    )
    if content.found is None or not (risks := greatest_risks(content.found)):
        return text
    return text + Bilingual(
        " The true value of an accepted one lies beyond a limit of its tolerance with a probability of at most "
        f"{risks}, computed for \u03bd = ∞.",
        f" Der wahre Wert eines angenommenen liegt mit einer Wahrscheinlichkeit von höchstens {risks}, berechnet "
        "für \u03bd = ∞, jenseits einer Grenze seiner Toleranz.",
    )


def outcome(content: CertificateContent) -> Bilingual:
    """Return of which parameters a verdict is, and what it was at acceptance where that was another."""
    found, model = content.found, content.document["model"]
    assert found is not None
    text = Bilingual(
        f"{plural(len(found.against), 'limited parameter')} of model {model}, by the decision rule stated here",
        f"Zahl begrenzter Parameter {len(found.against)}, Modell {model}, nach der hier genannten "
        "Entscheidungsregel",
    )
    if content.certificate.reasons:
        text = Bilingual(
            "For information only; traceability is not claimed. ",
            "Nur zur Information; Rückführung wird nicht beansprucht. ",
        ) + text  # fmt: skip
    if found.stored == found.word:
        return text
    stored = found.stored.replace("_", " ")
    return text + Bilingual(
        f". At acceptance the verdict was {stored}, with the standard uncertainty of the fit; the statement here "
        "uses the combined uncertainty of this certificate",
        f". Bei der Annahme lautete das Urteil {stored}, mit der Standardunsicherheit der Ausgleichung; die "
        "Aussage hier beruht auf der kombinierten Unsicherheit dieses Scheins",
    )
