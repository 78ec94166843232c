"""The statements of a digital certificate: what it is, traceability, uncertainty, amendment, conformity."""

from station.results.certificate import sentences
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.elements import Element, dcc, worded
from station.results.certificate.dcc.names import Bilingual, joined

CONFORMITY = {"PASS": "pass", "FAIL": "fail"}
CONFORMITY_TEXT = {"PASS": "erfüllt", "FAIL": "nicht erfüllt", "NOT MEASURED": "nicht gemessen"}


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
