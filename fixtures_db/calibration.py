"""A solution as calibration/1: what is applied to counts, ``u = E^-1 (N / k - D)``. Pure formatting."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from fixtures_db.model_limits import Limit
from procedures.calibration.solution_values import Solution, TriadCalibration
from procedures.frames import TRIADS

FORMAT = "calibration/1"
_MAPPINGS = ("residual", "procedure", "site", "uncertainty", "diagnosis")  # of `CalibrationFacts`
STATUSES = ("calibrated", "measured")


@dataclass(frozen=True, slots=True)
class CalibrationFacts:
    """What a calibration states besides its numbers.

    ``inputs`` holds the SHA-256 of each file used, by name; ``software`` is name, version and commit;
    ``temperature_range_c`` the least and the greatest temperature seen, None if never measured; ``status`` is
    ``measured`` where a reference lacked or had expired, ``status_reason`` says which. ``verdict`` is the one
    against ``limits``, the model's as they were then; None where nobody judged. ``judged`` holds what each limit
    was held against. What a certificate needs and only the station knew is there too: ``residual`` as in
    solution/1, how it was measured (``procedure``), where (``site``) and with what (``references``), and
    ``uncertainty``, a budget/1 of its parameters; ``diagnosis`` is the verdict on the residual with its findings;
    all JSON-ready.
    """

    model: str
    serial: str
    software: str
    inputs: Mapping[str, str]
    accepted_utc: datetime
    valid_from: datetime
    valid_until: datetime | None = None
    temperature_range_c: tuple[float, float] | None = None
    status: str = "calibrated"
    status_reason: str = ""
    operator: str = ""
    verdict: str | None = None
    limits: tuple[Limit, ...] = ()
    judged: tuple[Mapping[str, Any], ...] = ()
    residual: Mapping[str, Any] = field(default_factory=dict)
    procedure: Mapping[str, Any] = field(default_factory=dict)
    site: Mapping[str, Any] = field(default_factory=dict)
    references: tuple[Mapping[str, Any], ...] = ()
    uncertainty: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[Mapping[str, Any], ...] = field(default=())
    diagnosis: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise ValueError(f"calibration status {self.status!r} is none of {', '.join(STATUSES)}")


def calibration_document(solution: Solution, facts: CalibrationFacts, previous: str) -> dict[str, Any]:
    """Return calibration/1 as JSON-ready values; what was not estimated is left out.

    ``previous`` is the SHA-256 of the calibration accepted before this one, 64 zeros for the first.
    """
    document: dict[str, Any] = {
        "format": FORMAT,
        "model": facts.model,
        "serial": facts.serial,
        "software": facts.software,
        "status": facts.status,
        "accepted_utc": utc_text(facts.accepted_utc),
        "valid_from": utc_text(facts.valid_from),
        "effects": [dict(effect) for effect in facts.effects],
        "inputs": dict(facts.inputs),
        "previous": previous,
    }
    may_lack = {
        **{name: getattr(facts, name) for name in ("status_reason", "operator", "verdict")},
        **{name: dict(getattr(facts, name)) for name in _MAPPINGS},
        **{name: [dict(entry) for entry in getattr(facts, name)] for name in ("judged", "references")},
        "valid_until": facts.valid_until and utc_text(facts.valid_until),
        "temperature_range_c": facts.temperature_range_c and list(facts.temperature_range_c),
        "accelerometer": solution.accelerometer and _triad(solution.accelerometer),
        "gyroscope": solution.gyroscope and _triad(solution.gyroscope),
    }
    document |= {name: value for name, value in may_lack.items() if value}
    if facts.verdict is not None:
        document["limits"] = [
            {key: value for key, value in asdict(limit).items() if value is not None} for limit in facts.limits
        ]
    if solution.reference_temperature is not None:
        document["reference_temperature_c"] = solution.reference_temperature
    if (covariance := _covariance(solution)) is not None:
        document["covariance"] = covariance
    return document


def _covariance(solution: Solution) -> dict[str, Any] | None:
    """Return names and matrix of what is applied, each in the products of its units; None if it is not finite."""
    rows = [i for i, name in enumerate(solution.names) if name.split(".")[0] in TRIADS]
    matrix = solution.covariance[np.ix_(rows, rows)] if rows else np.empty((0, 0))
    if not rows or not np.isfinite(matrix).all():
        return None
    return {"names": [solution.names[i] for i in rows], "matrix": matrix.tolist()}


def _triad(triad: TriadCalibration) -> dict[str, Any]:
    estimates = {name: getattr(triad, name) for name in ("scale_factor", "misalignment", "bias")}
    return {
        name: {"value": one.value.tolist(), "std": one.std.tolist(), "unit": one.unit}
        for name, one in estimates.items()
    }


def utc_text(moment: datetime) -> str:
    """Return a moment as written in files: ISO 8601, UTC, ending in Z; refuse one without a time zone."""
    if moment.tzinfo is None:
        raise ValueError(f"{moment!r} has no time zone; expected an aware datetime")
    return moment.astimezone(UTC).isoformat().replace("+00:00", "Z")
