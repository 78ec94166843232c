"""All that a certificate is made from, and what of it decides what it may be called."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date, datetime
from typing import Any

from fixtures_db.campaigns import is_expired
from fixtures_db.hash_chain import GENESIS
from fixtures_db.verification import Anchor
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.model_statement import is_simulated


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
        said = [self.document["status_reason"]] if self.document.get("status_reason") else []
        if self.document["status"] != "calibrated" and not said:
            said = ["the calibration was stored as measured"]
        said += [text for text in expired(self.document) if not any(text in known for known in said)]
        return said

    @property
    def title(self) -> str:
        """What it is."""
        name = "Measurement report" if self.reasons else "Calibration certificate"
        return f"{name} of a simulated unit" if is_simulated(self.document) else name


def expired(document: Mapping[str, Any]) -> list[str]:
    """Say which references of a calibration/1 had run out when its last step was accepted."""
    measured = datetime.fromisoformat(document["procedure"]["ended_utc"]).date()
    dated = [(one, one.get("due_date")) for one in document.get("references", ())]
    return [
        f"the certificate of {one['kind']} {one['id']} expired on {due}"
        for one, due in dated
        if due is not None and is_expired(date.fromisoformat(due), measured)
    ]
