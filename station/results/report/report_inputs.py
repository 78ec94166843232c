"""What a report is made from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.uncertainty.budget import ParameterBudget

VERDICTS = ("PASS", "FAIL", "NOT_MEASURED")


@dataclass(frozen=True, slots=True, eq=False)
class ReportContext:
    """A solution, the campaigns behind it and what only the caller knows.

    ``files`` holds the SHA-256 of each input by name; ``created_utc`` is printed as it is: with it, equal
    inputs give equal bytes. ``truth`` (simulated campaigns) is keyed as `Solution.names`, in the units of
    files: ``accelerometer.bias.x`` in g. ``calibration_sha256`` is the head of the database's hash chain.
    ``bench`` adds lines to the conditions, such as a certificate's number and due date. ``budgets`` are the
    uncertainty budgets of the parameters. ``diagnosis`` is the section on what the model lacks, as HTML.
    ``has_limits``: the model has some.
    """

    solution: Solution
    campaigns: tuple[Campaign, ...]
    files: Mapping[str, str]
    software: str
    created_utc: str
    verdict: str = "NOT_MEASURED"
    has_limits: bool = False
    verdict_reason: str = "no limits are stored for this IMU model"
    truth: Mapping[str, float] = field(default_factory=dict)
    calibration_sha256: str | None = None
    bench: Mapping[str, str] = field(default_factory=dict)
    budgets: tuple[ParameterBudget, ...] = ()
    diagnosis: str = ""

    def __post_init__(self) -> None:
        if self.verdict not in VERDICTS:
            raise ValueError(f"verdict {self.verdict!r} is none of {', '.join(VERDICTS)}")
        if not self.campaigns:
            raise ValueError("a report of no campaign, expected at least one")


def report_context(
    solution: Solution,
    campaigns: Sequence[Campaign],
    document: Mapping[str, Any],
    budgets: Sequence[ParameterBudget] = (),
) -> ReportContext:
    """Return the context of a solution and its ``solution/1`` document, which holds the folders' own warnings."""
    origin = document["provenance"]
    return ReportContext(
        solution=replace(
            solution, warnings=tuple(document["warnings"]), unused_steps=tuple(document["unused_steps"])
        ),
        campaigns=tuple(campaigns),
        files=origin["files"],
        software=origin["software"],
        created_utc=origin["created_utc"],
        budgets=tuple(budgets),
    )
