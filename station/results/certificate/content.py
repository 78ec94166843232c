"""What a certificate says, before it is set in HTML or XML: one source, so that they cannot disagree."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from station.results.certificate import certificate_wording, model_statement
from station.results.certificate.as_found import AsFound, as_found
from station.results.certificate.certificate_inputs import Certificate
from station.results.certificate.conformity import Conformity, conformity
from station.results.certificate.printed_results import MeasuredParameter, measured


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
        certificate_wording.references(certificate),
        certificate_wording.deviations(document),
        model_statement.diagnosis_said(document),
        model_statement.taken_as_zero(document),
        [*model_statement.stated(document), certificate_wording.clock_of_the_laboratory(certificate)],
        model_statement.is_timed(document),
        model_statement.is_simulated(document),
    )
