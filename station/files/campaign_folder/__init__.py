"""Campaign folders (`campaign/1`, DESIGN 5): what a station records and what anyone may bring from elsewhere."""

from typing import TYPE_CHECKING

from station.lazily import lazily

if TYPE_CHECKING:
    from station.files.campaign_folder.loaded import LoadedCampaign, LoadedStep, check_for_solve, check_one_unit
    from station.files.campaign_folder.plan_toml import read_plan, write_plan
    from station.files.campaign_folder.reading import read_campaign, read_for_solve
    from station.files.campaign_folder.writing import campaign_tables, write_campaign, write_series, write_tables
    from station.files.sha256sums import append_hash, read_hashes, verify_folder

__all__ = [
    "LoadedCampaign",
    "LoadedStep",
    "append_hash",
    "campaign_tables",
    "check_for_solve",
    "check_one_unit",
    "read_campaign",
    "read_for_solve",
    "read_hashes",
    "read_plan",
    "verify_folder",
    "write_campaign",
    "write_plan",
    "write_series",
    "write_tables",
]
__getattr__ = lazily(
    __name__,
    {
        "LoadedCampaign": "loaded",
        "LoadedStep": "loaded",
        "append_hash": "manifest",
        "campaign_tables": "writing",
        "check_for_solve": "loaded",
        "check_one_unit": "loaded",
        "read_campaign": "reading",
        "read_for_solve": "reading",
        "read_hashes": "manifest",
        "read_plan": "plan_toml",
        "verify_folder": "manifest",
        "write_campaign": "writing",
        "write_plan": "plan_toml",
        "write_series": "writing",
        "write_tables": "writing",
    },
)
