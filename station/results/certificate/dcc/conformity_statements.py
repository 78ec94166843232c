"""The statements of a digital certificate on conformity: the rule of decision, and what came of it."""

from station.results.certificate.certificate_wording import greatest_risks
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.elements import Element, Said, dcc
from station.results.certificate.dcc.statement import statement
from station.text import plural

CONFORMITY = {"PASS": "pass", "FAIL": "fail"}
SAID_CONFORMITY = {"PASS": "erfüllt", "FAIL": "nicht erfüllt", "NOT MEASURED": "nicht gemessen"}


def decision_statements(content: CertificateContent) -> list[Element]:
    """Return rule and outcome; without limits that nothing is said of conformity."""
    found = content.found
    if found is None:
        model = content.document["model"]
        return [
            statement(
                "fog_noConformity",
                Said(
                    f"No statement of conformity is made: no limits were laid down for model {model}.",
                    f"Keine Konformitätsaussage: für das Modell {model} waren keine Grenzen festgelegt.",
                ),
            )
        ]
    word, risks = found.word.replace("_", " "), greatest_risks(found)
    agreed = content.certificate.laboratory.decision.agreed
    rule = Said(*(f"{agreed} " if agreed else "" for _ in range(2))) + Said(
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
    overall = Said(
        f"{word}: {plural(len(found.against), 'limited parameter')} of model {content.document['model']}"
        + ("; for information only, traceability is not claimed" if info else "")
        + f"; at acceptance the verdict was {found.stored.replace('_', ' ')}",
        f"{word} ({SAID_CONFORMITY[word]}), Zahl begrenzter Parameter {len(found.against)}, Modell "
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
