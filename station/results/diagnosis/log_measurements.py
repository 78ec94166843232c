"""What to measure next where the recording is no campaign of positions: a log of one or more rests, a rate table.

A table for each kind of recording: by the measurement that its record names, by what drives it, else repetition.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from procedures.effects import CATALOGUE
from procedures.effects.effect import MeasurementName
from procedures.positions import FACES
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis.diagnosis_wording import known_findings
from station.results.diagnosis.next_measurements import (
    DWELL_S,
    FREE,
    SOAK_S,
    Measurement,
    measurement_name,
    next_measurements,
    turns,
)

Recording = Literal["campaign", "rests", "rotation", "rest", "rate table"]
AT_REST = {"soak": [{"attitude": "free", "seconds": SOAK_S}]}
ATTITUDES = {"dwell": [{"attitude": "free", "seconds": DWELL_S}] * FREE}


@dataclass(frozen=True, slots=True)
class Repetition:
    """What a kind of recording can be repeated as: by what separates an error term, by its driver, and else."""

    otherwise: Measurement
    by_name: Mapping[MeasurementName, Measurement] = field(default_factory=dict)
    by_driver: Mapping[str, Measurement] = field(default_factory=dict)


HEATED = Measurement(
    "rest_heated",
    "Leave the unit at rest and record it while it is heated by 15 K or more and cooled again, with plateaus: "
    "effects of time, of temperature and of its rate can then be separated.",
    AT_REST,
)
REST_AGAIN = Measurement(
    "rest_again",
    "Record the unit at rest again, on another day, from the moment when it is switched on: an error that does "
    "not repeat is no error term.",
    AT_REST,
)
LONGER = Measurement(
    "longer_rest",
    "Record the unit at rest several times as long, at one temperature: a random walk grows, a drift goes on.",
    {"soak": [{"attitude": "free", "seconds": 4 * SOAK_S}]},
)
UNDISTURBED = Measurement(
    "rest_undisturbed",
    "Record the unit at rest again with nobody near the stand: a disturbance does not repeat.",
    AT_REST,
)
CHANNEL_CHANGED = Measurement(
    "channel_changed",
    "Leave the unit at rest and change the auxiliary channel on purpose, to and fro, and nothing else.",
    AT_REST,
)
REFERENCE_TIME = Measurement(
    "rest_with_reference_time",
    "Record the unit at rest with reference time (column utc_s), as from a GNSS receiver.",
    AT_REST,
)
OTHER_ATTITUDES = Measurement(
    "other_attitudes",
    "Record more rests, each in an attitude of its own, also between the faces, near 45 deg.",
    ATTITUDES,
)
OTHER_DAY = Measurement(
    "rests_in_another_order",
    "Record the rests again in another order, on another day, with the unit 5 K warmer or colder: effects of time "
    "and of temperature can then be separated.",
    ATTITUDES,
)
OTHER_SPEEDS = Measurement(
    "turns_at_other_speeds",
    "Turn about the same axis again, both ways, at other speeds: an error of the scale factor grows with the "
    "angle.",
    {"turn": turns()},
)
OTHER_RATES = Measurement(
    "other_rates",
    "Record the rate table again with other rates, both ways, in random order, up to the largest rate that the "
    "unit is made for: only there the curves differ.",
)
TABLE_AGAIN = Measurement(
    "table_again",
    "Record the same rates again in random order, on another day: an error that does not repeat is no error term.",
)
TABLE_HEATED = Measurement(
    "table_at_two_temperatures",
    "Record the same rates at two temperatures, 15 K or more apart, with the temperature in a column of its own.",
)
REPETITIONS: Mapping[Recording, Repetition] = {
    "rest": Repetition(
        REST_AGAIN,
        {
            "other_order": HEATED, "channel_moved": CHANNEL_CHANGED, "longer": LONGER, "again": UNDISTURBED,
            "reference_time": REFERENCE_TIME,
        },
        {"temperature": HEATED},
    ),
    "rests": Repetition(OTHER_ATTITUDES, by_driver={"temperature": OTHER_DAY, "time": OTHER_DAY}),
    "rotation": Repetition(OTHER_SPEEDS),
    "rate table": Repetition(
        OTHER_RATES, {"again": TABLE_AGAIN}, {"temperature": TABLE_HEATED, "time": TABLE_AGAIN}
    ),
}  # fmt: skip
AGAIN: Mapping[Recording, Measurement] = {  # of what is left without a cause
    "rest": REST_AGAIN, "rests": OTHER_DAY, "rotation": OTHER_SPEEDS, "rate table": TABLE_AGAIN,
}  # fmt: skip


def recording_of(campaigns: Sequence[LoadedCampaign]) -> Recording:
    """Return what kind of recording the campaigns are together; one with positions is a campaign."""
    every = [one.campaign for one in campaigns]
    if any(one.dwells for one in every):
        return "campaign"
    if any(one.rests or one.sequences or one.moves for one in every):
        return "rests"
    if any(one.turns for one in every):
        return "rotation"
    return "rest" if any(one.soaks for one in every) or not any(one.rate_tables for one in every) else "rate table"


def fitted_to(recording: Recording, finding: Mapping[str, Any]) -> dict[str, Any]:
    """Return a finding whose ``separate_by`` fits this kind of recording; what is sampled has its own."""
    if recording == "campaign" or finding["effect"] not in CATALOGUE:
        return dict(finding)
    return {**finding, "separate_by": separating(recording, finding["effect"]).phrase}


def separating(recording: Recording, name: str) -> Measurement:
    """Return what separates an error term from others in a recording that is no campaign."""
    ways = REPETITIONS[recording]
    driver = CATALOGUE[name].driver if name in CATALOGUE else ""
    return ways.by_name.get(measurement_name(name)) or ways.by_driver.get(driver) or ways.otherwise


def next_in_words(recording: Recording, findings: Sequence[Mapping[str, Any]], of_campaign: str) -> str:
    """Return ``next_measurement`` of a `diagnosis/2`; ``of_campaign`` is a campaign's, empty if none is needed.

    It separates the possible findings; without one it shows whether what is left repeats.
    """
    if recording == "campaign" or not of_campaign:
        return of_campaign
    ways = [each["separate_by"] for each in findings if each["confidence"] == "possible"]
    return "; ".join(dict.fromkeys(ways)) or AGAIN[recording].phrase


def wanted(
    document: Mapping[str, Any], campaigns: Sequence[LoadedCampaign], first: Sequence[Measurement] = ()
) -> list[Measurement]:
    """Return what to measure next: ``first``, then what separates findings, then what cannot be separated here."""
    recording, findings = document["recording"], known_findings(document)
    hidden = [{"effect": name, "confidence": "possible"} for name in document.get("not_separable", {})]
    if recording == "campaign":
        is_certified = all(len(one.campaign.fixture.faces) == len(FACES) for one in campaigns)
        axes = campaigns[0].tables.fixture.imu_axes
        known = next_measurements([*findings, *hidden], axes, is_certified)
    else:
        possible = [one for one in findings if one["confidence"] == "possible"] + hidden
        known = [separating(recording, one["effect"]) for one in possible or findings] or [AGAIN[recording]]
    return list({one.name: one for one in [*first, *known]}.values())
