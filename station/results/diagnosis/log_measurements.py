"""What to measure next where the recording is no campaign of positions: a log of one or more rests, a rate table.

A table for each kind of recording: by the measurement that its record names, by what drives it, else repetition.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects import CATALOGUE
from procedures.effects.effect import MeasurementName
from procedures.positions import FACES
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis.diagnosis_wording import known_findings
from station.results.diagnosis.next_measurements import (
    DWELL_S,
    FREE,
    SOAK_S,
    STATIC,
    Measurement,
    measurement_name,
    next_measurements,
    turns,
)

Recording = Literal["campaign", "rests", "rotation", "rest", "rate table"]
Temperature = Literal["not recorded", "recorded", "cycled"]
CYCLE_K = 15.0  # of heating and of cooling in one recording, that `HEATED` asks for
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
HEATED_SLOWLY = Measurement(
    "rest_heated_slowly",
    "Leave the unit at rest and record it while it is heated and cooled at half the rate of this recording, with "
    "plateaus twice as long: a lag, a rate of the temperature and the temperature itself then differ more.",
    {"soak": [{"attitude": "free", "seconds": 2 * SOAK_S}]},
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
    "Record the rests again in another order, on another day: an error that does not repeat is no error term.",
    ATTITUDES,
)
WARMER = Measurement(
    "rests_at_another_temperature",
    "Record the rests again in another order, with the unit 5 K warmer or colder: effects of time and of "
    "temperature can then be separated.",
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
    "Record the table again in random order, on another day, with more rates where the residual is largest: an "
    "error that repeats at a rate is a function of the rate; one that does not is no error term.",
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
    "rests": Repetition(OTHER_ATTITUDES, by_driver={"temperature": WARMER, "time": WARMER}),
    "rotation": Repetition(OTHER_SPEEDS),
    "rate table": Repetition(
        OTHER_RATES, {"again": TABLE_AGAIN}, {"temperature": TABLE_HEATED, "time": TABLE_AGAIN}
    ),
}  # fmt: skip
AGAIN: Mapping[Recording, Measurement] = {  # of what is left without a cause
    "rest": REST_AGAIN, "rests": OTHER_DAY, "rotation": OTHER_SPEEDS, "rate table": TABLE_AGAIN,
}  # fmt: skip
INSTEAD: Mapping[Temperature, Mapping[str, Measurement]] = {  # of what asks for another temperature
    "not recorded": {HEATED.name: REST_AGAIN, WARMER.name: OTHER_DAY},
    "recorded": {},
    "cycled": {HEATED.name: HEATED_SLOWLY},
}


@dataclass(frozen=True, slots=True)
class Recorded:
    """The kind of a recording, and what is known of the temperature in it."""

    kind: Recording
    temperature: Temperature

    @classmethod
    def of(cls, campaigns: Sequence[LoadedCampaign]) -> "Recorded":
        """Return it of campaigns together."""
        return cls(recording_of(campaigns), temperature_of(campaigns))


def temperature_of(campaigns: Sequence[LoadedCampaign]) -> Temperature:
    """Return what is known of the temperature in campaigns."""
    recorded = list[FloatArray]()
    for one in (each.campaign for each in campaigns):
        for steps in (one.dwells, one.turns, one.rests, one.moves, one.sequences, one.soaks):
            recorded += [step.series.temperature for step in steps]
        recorded += [table.temperature for table in one.rate_tables]
    known = [T[np.isfinite(T)] for T in recorded if np.isfinite(T).any()]
    return "cycled" if any(map(_is_cycled, known)) else "recorded" if known else "not recorded"


def _is_cycled(T: FloatArray) -> bool:
    """Say whether temperatures T (n,) rise and fall by `CYCLE_K`."""
    rise, fall = np.max(T - np.minimum.accumulate(T)), np.max(np.maximum.accumulate(T) - T)
    return bool(min(rise, fall) >= CYCLE_K)


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


def fitted_to(recorded: Recorded, finding: Mapping[str, Any]) -> dict[str, Any]:
    """Return a finding whose ``separate_by`` fits this kind of recording; what is sampled has its own."""
    if recorded.kind == "campaign" or finding["effect"] not in CATALOGUE:
        return dict(finding)
    return {**finding, "separate_by": separating(recorded, finding["effect"]).phrase}


def separating(recorded: Recorded, name: str) -> Measurement:
    """Return what separates an error term from others in a recording that is no campaign."""
    ways = REPETITIONS[recorded.kind]
    driver = CATALOGUE[name].driver if name in CATALOGUE else ""
    found = ways.by_name.get(measurement_name(name)) or ways.by_driver.get(driver) or ways.otherwise
    return INSTEAD[recorded.temperature].get(found.name, found)


def _measurement(recorded: Recorded, finding: Mapping[str, Any]) -> Measurement:
    """Return what a finding's ``separate_by`` asks for, as `fitted_to` has it."""
    if finding["effect"] in CATALOGUE:
        return separating(recorded, finding["effect"])
    words = finding["separate_by"]
    return Measurement(finding["effect"], f"{words[0].upper()}{words[1:]}.")


def _following(recorded: Recorded, findings: Sequence[Mapping[str, Any]]) -> list[Measurement]:
    """Return what separates the possible findings; without one what shows whether the residual repeats."""
    ways = [_measurement(recorded, each) for each in findings if each["confidence"] == "possible"]
    return ways or [AGAIN[recorded.kind]]


def next_in_words(recorded: Recorded, findings: Sequence[Mapping[str, Any]], of_campaign: str) -> str:
    """Return ``next_measurement`` of a `diagnosis/2`; ``of_campaign`` is a campaign's, empty if none is needed."""
    if recorded.kind == "campaign" or not of_campaign:
        return of_campaign
    return "; ".join(dict.fromkeys(each.phrase for each in _following(recorded, findings)))


def wanted(
    document: Mapping[str, Any], campaigns: Sequence[LoadedCampaign], first: Sequence[Measurement] = ()
) -> list[Measurement]:
    """Return what to measure next: ``first``, then ``next_measurement``, then what cannot be separated here.

    Where no next measurement is needed, the findings are confirmed.
    """
    findings, is_needed = known_findings(document), bool(document["next_measurement"])
    possible = [each for each in findings if each["confidence"] == "possible"]
    hidden = [{"effect": name, "confidence": "possible"} for name in document.get("not_separable", {})]
    if document["recording"] == "campaign":
        is_certified = all(len(one.campaign.fixture.faces) == len(FACES) for one in campaigns)
        axes = campaigns[0].tables.fixture.imu_axes
        known = [STATIC["repeat"]] if is_needed and not possible else []
        if hidden or not known:
            known += next_measurements([*findings, *hidden], axes, is_certified)
    else:
        recorded = Recorded(document["recording"], temperature_of(campaigns))
        confirmed = [] if hidden else [_measurement(recorded, each) for each in findings]
        known = _following(recorded, findings) if is_needed or (not confirmed and not hidden) else confirmed
        known = known + [separating(recorded, one["effect"]) for one in hidden]
    return list({one.name: one for one in [*first, *known]}.values())
