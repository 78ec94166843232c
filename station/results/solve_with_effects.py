"""A plain solve of recorded campaigns, with the effects that they are solved with."""

from collections.abc import Sequence
from typing import Any

from procedures.calibration.joint_calibration import solve
from procedures.calibration.solution_values import Solution
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, effects_of


def solved(campaigns: Sequence[LoadedCampaign]) -> tuple[Solution, Sequence[LoadedCampaign], list[dict[str, Any]]]:
    """Return what `station.results.solution_json.solution_document` takes: solution, campaigns, effects.

    Raises
    ------
    NotObservable
        If neither triad can be solved.
    """
    files = effects_of(campaigns)
    if not files:
        return solve([one.campaign for one in campaigns]), campaigns, []
    from procedures.diagnosis.declared_effects import solve_declared  # the loop, heavy: only where it is needed
    from station.results.diagnosis.diagnosis_json import effect_entries
    from station.results.diagnosis.magnetic_field import with_magnetic_field

    campaigns = [with_magnetic_field(one) for one in campaigns]
    found = solve_declared([one.campaign for one in campaigns], [file.term for file in files])
    return found.solution, campaigns, effect_entries(found.effects, files)
