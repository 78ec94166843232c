"""From campaign folders to a measured cube."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy.orm import Session

from fixtures_db.campaigns import known_campaign, last_accepted
from fixtures_db.hash_chain import canonical, digest
from procedures.bench.cube_measurement import measure_cube
from procedures.campaign.measured_cube import PARALLELISM
from procedures.frames import face_of
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, check_for_solve, check_one_unit
from station.results.cube_measurement.known_faces import CubeStudy, known_of


def read_campaigns(cube_id: str, folders: Sequence[Path]) -> list[LoadedCampaign]:
    """Read campaigns of any units that were recorded with one cube.

    Raises
    ------
    DataRefused
        If a folder breaks a rule, names another cube, or holds a recording that another one has.
    """
    loaded = [read_campaign(folder) for folder in folders]
    for one in loaded:
        check_for_solve(one)
        if (found := one.tables.fixture.id) != cube_id:
            raise DataRefused(
                one.folder / CAMPAIGN_TOML, None, f"fixture.id {found!r}", f"{cube_id!r}", "name its campaigns"
            )
    for unit in dict.fromkeys(unit_of(one) for one in loaded):
        check_one_unit([one for one in loaded if unit_of(one) == unit])
    return loaded


def study(
    session: Session, cube_id: str, loaded: Sequence[LoadedCampaign], quadratic_std: float, on: datetime | None
) -> CubeStudy:
    """Measure a cube; ``on`` is when, the last step of the campaigns that the database knows if not given."""
    known = known_of(session, cube_id)
    found = measure_cube([one.campaign for one in loaded], quadratic_std)
    campaigns: dict[str, dict[str, str]] = {}
    for one in loaded:
        campaigns.setdefault(unit_of(one), {})[one.folder.resolve().name] = digest(canonical(one.files))
    moments = [last_accepted(row) for one in loaded if (row := known_campaign(session, str(one.folder.resolve())))]
    unused = [f"{one.folder}: {each.name} is not used" for one in loaded for each in one.campaign.sequences]
    moment = on or max(moments, default=datetime.now(UTC))
    is_whole = set(PARALLELISM) <= set(found.cube.names)
    lacking = [] if is_whole else [said for one in loaded for said in _lacking(one)]
    return CubeStudy(cube_id, found, moment, campaigns, (*found.warnings, *lacking, *unused), known)


def unit_of(loaded: LoadedCampaign) -> str:
    """Return model and serial number."""
    return f"{loaded.campaign.model} {loaded.campaign.serial}"


def _lacking(loaded: LoadedCampaign) -> list[str]:
    """Say which of the twelve positions a campaign lacks, with the face that each has up."""
    there = {dwell.position for dwell in loaded.campaign.dwells}
    lacks = [f"{p} ({face_of(p)})" for p in range(1, 13) if p not in there]
    return [f"{loaded.folder}: no dwell in position {', '.join(lacks)}"] if lacks else []
