"""A campaign as read from a folder: what a solve needs, what else the folder says, the effects it is solved with.

Effects are those that the folder lists and those that a command names.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from procedures.arrays import FloatArray
from procedures.campaign.campaign import MAX_CLOCK_PPM, RATE_SIGMAS, Campaign, clock_rate, false_rate, is_known
from procedures.counts.reference_time import ClockRate
from procedures.errors import ErrorCode
from procedures.units import PPM_PER_ONE
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, CampaignTable, EffectsTable, StepTable
from station.files.campaign_folder.sample_series import WARN_PERIOD_DEVIATION, StepData
from station.files.opening import open_inside
from station.files.toml_file import Key, line_of

if TYPE_CHECKING:
    from station.files.effect_file import EffectFile  # with the catalogue: a solve without effects does without

MAX_PERIOD_DEVIATION = 1e-2  # relative, docs/how-to/campaign-folder.md


@dataclass(frozen=True, slots=True, eq=False)
class LoadedStep:
    """A step of any kind with its data: a series, or for a turntable the columns of its points, each (n,).

    ``lines`` (n,) are those of the points in the user's file, None where a point is no line.
    """

    kind: str
    table: StepTable
    data: StepData | None
    points: Mapping[str, FloatArray] = field(default_factory=dict)
    lines: Sequence[int] | None = None

    @property
    def label(self) -> str:
        """The step in words: its kind, its attitude if it is not one of the twelve positions, its file."""
        up, attitude = getattr(self.table, "up", None), getattr(self.table, "attitude", None)
        where = f" up={up}" if up else f" attitude={attitude}" if attitude else ""
        return f"{self.kind}{where} ({self.table.file})"


@dataclass(frozen=True, slots=True, eq=False)
class LoadedCampaign:
    """A folder's campaign; ``files`` maps each file's name to its sha256; it is solved with its ``effects``.

    ``guesses`` is what was guessed of logs that it was made of, as text. ``output_name`` is the unit of a log's
    gyroscope as its header has it, where it is none of rates, as mV.
    """

    folder: Path
    tables: CampaignTable
    campaign: Campaign
    steps: tuple[LoadedStep, ...]
    files: Mapping[str, str]
    warnings: tuple[str, ...]
    unused_steps: tuple[str, ...]
    effects: "tuple[EffectFile, ...]" = ()
    guesses: tuple[str, ...] = ()
    output_name: str = ""


def check_one_unit(campaigns: Sequence[LoadedCampaign]) -> None:
    """Refuse campaigns that cannot be solved jointly: of other units or outputs, or with a recording in common.

    Raises
    ------
    DataRefused
        Naming the first campaign or file that does not fit, and what it does not fit.
    """
    first, seen = campaigns[0], dict[str, Path]()
    for other in campaigns:
        if (found := _unit(other)) != (expected := _unit(first)):
            file = other.folder / "campaign.toml"
            raise DataRefused(file, None, found, f"{expected} as in {first.folder}", "solve each unit by itself")
        names = {step.table.file for step in other.steps}
        for sha256, file in ((other.files[name], other.folder / name) for name in sorted(names)):
            if sha256 in seen:
                raise DataRefused(file, None, f"the same bytes as in {seen[sha256]}", "each recording once")
            seen[sha256] = file


def _unit(loaded: LoadedCampaign) -> str:
    imu = loaded.tables.imu
    return f"{imu.model} {imu.serial} with {'rates' if imu.output == 'rate' else 'counts'}"


def off_period(rate: ClockRate) -> float:
    """Return by how much of itself a sample lasts longer than the device says, from reference time."""
    return 1 / (1 + rate.ppm / PPM_PER_ONE) - 1


def clock_sentence(period: float, off: float, by: str = "reference time") -> str:
    """Say a sample period [s] that another clock shows to be ``off`` (relative)."""
    return (
        f"clock.rate: by {by} a sample lasts {period * (1 + off):.9g} s, {off:+.2%} off "
        f"sample_period_s = {period:.9g}"
    )


def clock_warnings(tables: CampaignTable, campaign: Campaign) -> list[str]:
    """Return what reference time (``utc_s``) alongside the rows says of the sample period, beyond 0.1 %.

    Where it cannot determine as much, or is no time [s] of these rows, a warning says so.
    """
    if (pace := false_rate(campaign)) is not None:
        return [
            f"clock.rate: utc_s is no time [s] of these rows: it moves by {pace:.3g} while t_s moves by 1 s, "
            "expected 1; correct its unit or direction, or remove the column; it is not used"
        ]
    rate = clock_rate(campaign)
    if rate is None:
        return []
    open_to = RATE_SIGMAS * rate.std / PPM_PER_ONE
    if not is_known(rate):
        return [
            f"clock.rate: reference time determines it only to +-{open_to:.2%} (4 sigma), because it was read "
            f"with delays of up to {rate.delay:.2g} s; record on a computer with less load, or longer"
        ]
    off = off_period(rate)
    return [clock_sentence(tables.imu.sample_period_s, off)] if abs(off) - open_to > WARN_PERIOD_DEVIATION else []


def _advice(rate: ClockRate) -> str:
    if abs(rate.ppm) > MAX_CLOCK_PPM:
        return "check the sync line and the declared rate, and that t_s and utc_s are in seconds of the same rows"
    if not is_known(rate):
        return "check the sync line and the declared rate; record longer, so that the rate is known"
    return "check the sync line and the declared rate, or run `station diagnose` (it names clock.rate)"


def check_for_solve(loaded: LoadedCampaign) -> None:
    """Refuse what only a diagnosis may still use: a mean sample period more than 1 % off its nominal.

    It is looked at in the device's own time and, where rows hold it, in reference time.

    Raises
    ------
    DataRefused
        Naming the first such file and both periods.
    """
    rate = clock_rate(loaded.campaign)
    if (
        rate is not None
        and abs(off := off_period(rate)) - RATE_SIGMAS * rate.std / PPM_PER_ONE > MAX_PERIOD_DEVIATION
    ):
        raise DataRefused(
            loaded.folder / "campaign.toml",
            None,
            clock_sentence(loaded.tables.imu.sample_period_s, off),
            "the sample period within 1 %",
            _advice(rate),
            ErrorCode.SAMPLE_RATE,
        )
    nominal = loaded.tables.imu.sample_period_s
    for step in loaded.steps:
        if step.data is not None and abs(step.data.series.period / nominal - 1) > MAX_PERIOD_DEVIATION:
            raise DataRefused(
                loaded.folder / step.table.file,
                None,
                f"a mean sample period of {step.data.series.period:.9g} s",
                f"sample_period_s = {nominal:.9g} within 1 %",
                "correct sample_period_s or run `station diagnose` (it may name clock.rate)",
                ErrorCode.SAMPLE_RATE,
            )


def folder_effects(folder: Path, table: EffectsTable | None, lines: dict[Key, int]) -> "dict[str, EffectFile]":
    """Return the `effect/1` files that a folder lists, by their names in it.

    Raise `DataRefused` if one leads outside, is no `effect/1`, or has another hash than is stated.
    """
    if table is None:
        return {}
    from station.files.effect_file import MAX_BYTES, each_once, effect_in

    found: dict[str, EffectFile] = {}
    for name, stated in zip(table.files, table.sha256 or [""] * len(table.files), strict=True):
        with open_inside(folder, name, folder / CAMPAIGN_TOML, line_of(("effects", "files"), lines)) as stream:
            content = stream.read(MAX_BYTES + 1)
        found[name] = effect_in(content, folder / name)
        if stated and found[name].sha256 != stated:
            expected = f"{stated} as {CAMPAIGN_TOML} states"
            remedy = "bring back the file that was recorded"
            raise DataRefused(folder / name, None, f"sha256 {found[name].sha256}", expected, remedy)
    each_once([(folder / name, one) for name, one in found.items()])
    return found


def with_effects(campaigns: Sequence[LoadedCampaign], files: Sequence[Path]) -> list[LoadedCampaign]:
    """Return campaigns with effects from files alongside their own; their hashes stand with those of all files.

    Raise `DataRefused` if a file is no `effect/1`, or two that differ have one name.
    """
    if not files and not any(one.effects for one in campaigns):
        return list(campaigns)
    from station.files.effect_file import each_once, read_effect

    read = {str(path): read_effect(path) for path in files}
    first, *others = campaigns
    whole = [(one.folder, effect) for one in campaigns for effect in one.effects]
    each_once([*whole, *((Path(path), effect) for path, effect in read.items())])
    hashes = {path: effect.sha256 for path, effect in read.items()}
    more = replace(first, effects=(*first.effects, *read.values()), files={**first.files, **hashes})
    return [more, *others]


def effects_of(campaigns: Sequence[LoadedCampaign]) -> "tuple[EffectFile, ...]":
    """Return the effects that campaigns are solved with together, each once."""
    if not any(one.effects for one in campaigns):
        return ()
    from station.files.effect_file import each_once

    return each_once([(one.folder, effect) for one in campaigns for effect in one.effects])
