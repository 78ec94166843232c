"""A solved and stored campaign: simulated, short, in a database of its own."""

from datetime import UTC, datetime
from pathlib import Path

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from fixtures_db.campaigns import accept_step, start_campaign
from fixtures_db.database import Database
from procedures.campaign.plan_steps import turn_steps
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import append_hash
from tests.station.campaign_writing import write_campaign


def recorded(folder: Path, database: Database, seed: int = 1, turned: bool = False, **where: str) -> Path:
    """Record a campaign of the unit SIM-7 into a new folder, each step with its hash and its row.

    ``turned``: with six turns, so that the gyroscopes are solved too.
    """
    truth = Truth.example(7)
    turns = turn_steps(1, 3.0) if turned else ()
    campaign = simulate_campaign(truth, seed, dwell_s=4.0, turns=turns, move_s=5.0)
    write_campaign(folder, campaign, truth.sample_period_s)
    key, now = str(folder.resolve()), datetime.now(UTC)
    files = read_campaign(folder).files
    with database.write() as session:
        start_campaign(session, key, model=truth.model, serial=truth.serial, started_utc=now, **where)
        for name, sha256 in files.items():
            if name != "campaign.toml":
                append_hash(folder, name, sha256)
                accept_step(session, key, name=Path(name).stem, file=name, sha256=sha256, accepted_utc=now)
    return folder
