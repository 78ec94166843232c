"""What a station knows when a campaign is about to begin: limits, references, sites, room on the disk."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from functools import cache
from pathlib import Path
from typing import Any

from fixtures_db.campaign_references import reference
from fixtures_db.database import Database
from fixtures_db.fixtures import fixture_rows
from fixtures_db.model_limits import Limit, limited_models, limits_of
from fixtures_db.schema import CubeRow, SiteRow, SlabRow
from procedures.campaign.plan_steps import Step
from station.guide.disk_space import disk_free, disk_needed


@dataclass(frozen=True, slots=True)
class PriorKnowledge:
    """``references`` of cubes and slabs by kind and id; ``limits`` by model.

    ``sites`` stand with their references. ``usual``: the steps are the usual ones. ``free`` and
    ``needed`` are bytes, None where that is not known.
    """

    today: date
    software: str
    limits: Mapping[str, Sequence[Limit]]
    references: Mapping[tuple[str, str], Mapping[str, Any]]
    sites: Sequence[tuple[SiteRow, Mapping[str, Any]]]
    usual: bool = True
    free: int | None = None
    needed: int | None = None


def read_prior_knowledge(
    database: Database, root: Path, steps: Sequence[Step], rate_hz: float | None, *, usual: bool = True
) -> PriorKnowledge:
    """Return what is known now, for a campaign of ``steps`` that goes beneath ``root``."""
    now = datetime.now(UTC)
    with database.read() as session:
        limits = {model: limits_of(session, model) for model in limited_models(session)}
        found = [reference(row, now) for row in fixture_rows(session, CubeRow)]
        found += [reference(row, now) for row in fixture_rows(session, SlabRow)]
        sites = [(row, reference(row, now)) for row in fixture_rows(session, SiteRow)]
    return PriorKnowledge(
        now.astimezone().date(), _software(), limits, {(one["kind"], one["id"]): one for one in found}, sites,
        usual, disk_free(root), None if rate_hz is None else disk_needed(steps, rate_hz),
    )  # fmt: skip


@cache
def _software() -> str:
    from station.results.solution_json import software_version

    return software_version()
