"""What a certificate is made from, and its numbers: one source for HTML and XML, so that they cannot disagree.

Its fixed sentences are those of `sentences`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime
from typing import Any

from fixtures_db.campaigns import day_of, is_expired
from fixtures_db.hash_chain import GENESIS
from fixtures_db.verification import Anchor
from station.results.certificate import model_statement
from station.results.certificate.conformity import AsFound, Conformity, as_found, conformity, greatest_risk
from station.results.certificate.dcc.names import Bilingual
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.missing_statements import COMMIT
from station.results.certificate.model_statement import is_simulated, is_timed, residual_in_words
from station.results.certificate.printed_results import MeasuredParameter, measured
from station.text import decimals, fixed, significant


@dataclass(frozen=True, slots=True)
class ReplacedCertificate:
    """The certificate whose place a new one takes (ISO/IEC 17025:2017, 7.8.8), and why.

    ``sha256`` is that of its XML, of its HTML where it had none. ``changed`` are the labels of the printed fields
    that differ, None where they were not compared.
    """

    number: str
    issued_utc: datetime
    sha256: str
    reason: str
    changed: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class Certificate:
    """A certificate to be printed; equal ones give equal bytes.

    ``document`` is calibration/1 with the hash ``sha256``; ``previous`` and its hash are those of the unit's
    calibration before it, None for the first. ``heads`` are those of the database's chains before it.
    """

    number: str
    issued_utc: datetime
    document: Mapping[str, Any]
    sha256: str
    laboratory: Laboratory
    heads: Anchor = field(default_factory=Anchor)
    previous: Mapping[str, Any] | None = None
    previous_sha256: str = GENESIS
    replaced: ReplacedCertificate | None = None

    @property
    def reasons(self) -> list[str]:
        """Why it is no calibration certificate; empty if it is one."""
        stated = [self.document["status_reason"]] if self.document.get("status_reason") else []
        if self.document["status"] != "calibrated" and not stated:
            stated = ["the calibration was stored as measured"]
        stated += [text for text in expired(self.document) if not any(text in known for known in stated)]
        return stated

    @property
    def title(self) -> Bilingual:
        """What it is."""
        certificate = Bilingual("Calibration certificate", "Kalibrierschein")
        name = Bilingual("Measurement report", "Messbericht") if self.reasons else certificate
        of = Bilingual(" of a simulated unit", " eines simulierten Geräts")
        return name + of if is_simulated(self.document) else name


def expired(document: Mapping[str, Any]) -> list[str]:
    """Say which references of a calibration/1 had run out when its last step was accepted."""
    measured = day_of(datetime.fromisoformat(document["procedure"]["ended_utc"]))
    dated = [(one, one.get("due_date")) for one in document.get("references", ())]
    return [
        f"the certificate of {one['kind']} {one['id']} expired on {due}"
        for one, due in dated
        if due is not None and is_expired(date.fromisoformat(due), measured)
    ]


METRE_PER_S2 = "m/s\u00b2"
NB = "\u00a0"


def greatest_risks(found: Conformity) -> str:
    """Return for each guard band factor the greatest risk of an accepted value; empty if none has a sigma."""
    guards = sorted({one.limit.guard_band for one in found.against if one.std})
    return ", ".join(f"{100 * greatest_risk(r):.2g}{NB}% (r\u00a0=\u00a0{r:g})" for r in guards)


def deviations(document: Mapping[str, Any]) -> list[str]:
    """Return what was done otherwise than the procedure says, or stood out."""
    procedure = document["procedure"]
    stated = list(procedure.get("deviations", ()))
    stated += [residual_in_words(document, text) for text in procedure.get("warnings", ())]
    if (found := COMMIT.search(document["software"])) and found["dirty"]:
        stated.append("the software had uncommitted changes")
    return stated


def conditions(certificate: Certificate) -> list[tuple[str, str]]:
    """Return label and text of the conditions of measurement."""
    document, lab = certificate.document, certificate.laboratory
    site = document["site"]
    where = f"latitude {site['latitude_deg']:.4f}\u00b0"
    if "height_m" in site:
        where += f", height {site['height_m']:g}{NB}m"
    lines = [("Site", f"{site['id']}: {where}" if "id" in site else where), ("Local gravity", gravity(site))]
    if span := document.get("temperature_range_c"):
        lines.append(("Temperature of the unit", span_text(span, "\u00b0C")))
    if "reference_temperature_c" in document:
        lines.append(("Results refer to", f"{document['reference_temperature_c']:.1f}{NB}\u00b0C of the unit"))
    if span := lab.environment.temperature_c:
        lines.append(("Temperature of the laboratory", span_text(span, "\u00b0C")))
    if span := lab.environment.humidity_percent:
        lines.append(("Relative humidity", span_text(span, "%")))
    return lines


def gravity(site: Mapping[str, Any]) -> str:
    """Return gravity with its standard uncertainty."""
    std = site["gravity_std_m_s2"]
    value = fixed(site["gravity_m_s2"], max(decimals(std), 0))
    return f"{value}{NB}{METRE_PER_S2}, standard uncertainty {significant(std)}{NB}{METRE_PER_S2}"


def clock_of_the_laboratory(certificate: Certificate) -> tuple[str, str]:
    """Return label and text of what the laboratory says of its clock: a statement, no part of this measurement."""
    text = certificate.laboratory.traceability.time_base
    return "Laboratory\u2019s clock", f"{text}; stated by the laboratory, the device was not compared with it"


def references(certificate: Certificate) -> list[dict[str, str]]:
    """Return what the results are traceable to: quantity, reference, by whom, when, until when."""
    document, lab = certificate.document, certificate.laboratory
    known = {one["kind"]: one for one in document["references"]}
    cube, slab, survey, site = known["cube"], known["slab"], known.get("site", {}), document["site"]
    side = f", side {cube['side_mm']:g}{NB}mm" if "side_mm" in cube else ""
    source = site.get("gravity_source") or lab.traceability.gravity_source
    is_undated = not survey.get("measured_utc") and not str(source).startswith("normal gravity")  # a formula
    dated = {"measured": "date of survey not stated"} if is_undated else {}
    if is_timed(document):  # whatever clock the laboratory has
        timed = "GNSS time, recorded with the counts", document["procedure"]["ended_utc"][:10]
    else:
        timed = "the device\u2019s own clock, compared with no reference", "not compared"
    return [
        _reference("Angle", f"cube {cube['id']}{side}", cube),
        _reference("Level", f"slab {slab['id']}", slab),
        _reference("Gravity", f"g at {survey.get('id', 'the slab')}", survey) | {"source": source or ""} | dated,
        _reference("Time", "second", {}) | {"source": timed[0], "measured": timed[1]},
    ]


def minute(moment: str | datetime) -> str:
    """Return a moment to the minute, in UTC."""
    text = moment if isinstance(moment, str) else moment.isoformat()
    return f"{text[:10]} {text[11:16]} UTC"


def span_text(span: Sequence[float], unit: str) -> str:
    """Return a range."""
    low, high = (f"{end:.1f}" for end in span)
    return f"{low}{NB}{unit}" if low == high else f"{low} to {high}{NB}{unit}"


def _reference(quantity: str, what: str, one: Mapping[str, Any]) -> dict[str, str]:
    return {
        "quantity": quantity,
        "what": what,
        "source": one.get("source") or "",
        "measured": one.get("measured_utc", "")[:10],
        "due": one.get("due_date", ""),
        "certificate": one.get("certificate", ""),
    }


@dataclass(frozen=True, slots=True, eq=False)
class CertificateContent:
    """A certificate with what follows from its calibration: results, conformity, comparison with the one before.

    ``found`` is None without limits, ``before`` for the first calibration of a unit. ``deviations`` and
    ``taken_as_zero`` are sentences; ``references`` are lines by column.
    """

    certificate: Certificate
    results: Mapping[str, MeasuredParameter]
    found: Conformity | None
    before: AsFound | None
    references: list[dict[str, str]]
    deviations: list[str]
    diagnosis: list[str]
    taken_as_zero: list[str]
    stated: list[tuple[str, str]]
    is_timed: bool
    is_simulated: bool

    @property
    def document(self) -> Mapping[str, Any]:
        """The calibration/1."""
        return self.certificate.document


def content_of(certificate: Certificate) -> CertificateContent:
    """Return what a certificate says; nothing is `missing` of its document."""
    document, results = certificate.document, measured(certificate.document)
    before = None
    if certificate.previous is not None:
        before = as_found(document, certificate.previous, certificate.previous_sha256)
    return CertificateContent(
        certificate,
        results,
        conformity(document, results),
        before,
        references(certificate),
        deviations(document),
        model_statement.diagnosis_in_words(document),
        model_statement.taken_as_zero(document),
        [*model_statement.stated(document), clock_of_the_laboratory(certificate)],
        model_statement.is_timed(document),
        model_statement.is_simulated(document),
    )
