"""What a diagnosis returns: verdict, findings, the error before and after, what was tried."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import log
from typing import Literal

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.left_pattern import LeftPattern
from procedures.diagnosis.residual_rows import Evidence
from procedures.effects.effect import Kind
from procedures.uncertainty.sources import ByTriad

Confidence = Literal["established", "likely", "ambiguous"]
Verdict = Literal["consistent", "established", "likely", "ambiguous", "partly", "unexplained"]
WITHOUT_CAUSE = ".bias_walk"  # a form of what is left, which explains nothing of where it comes from
PARTLY_SHARE = 0.5  # of the excess held out, from which a finding says something of what is left
UNEXPLAINED_LOG_P = log(0.01)  # of the global test, below which the residual is more than noise
WEAKEST_LAST: tuple[Verdict, ...] = ("consistent", "established", "likely", "ambiguous", "partly", "unexplained")


class Because(StrEnum):
    """Why a verdict is what it is, or why a finding is ambiguous; what the value of such a `Reason` is."""

    RESIDUAL = "residual_exceeds_noise"  # log10 p of the global test
    CURVE = "curve_predicts_better"  # ln predictive density by which a smooth curve is better on held-out rows
    WALK = "random_walk_as_likely"  # no value
    AMBIGUOUS = "finding_ambiguous"  # no value
    LIKELY = "finding_likely"  # no value
    STRUCTURE = "samples_keep_structure"  # share of the samples' variance that a table by phase explains more
    MOTION = "rests_move"  # by how much the parts of a rest differ beyond noise [g]
    ALTERNATIVE = "alternative"  # no value
    PATTERN = "leaves_a_pattern"  # share of the excess that the finding explains
    SMALL_SHARE = "small_share"  # share of the excess that the finding explains
    NOT_SIGNIFICANT = "not_significant"  # log10 p, corrected for all that was tried
    MEMORY = "another_memory"  # no value
    NOT_DETERMINED = "nonlinear_part_not_determined"  # no value
    SINGLE_STEP = "may_be_a_single_step"  # no value
    NEIGHBOUR = "two_steps_close_together"  # no value
    TOGETHER = "beside_an_ambiguous_one"  # no value


@dataclass(frozen=True, slots=True)
class Reason:
    """A reason as it is: its code, the effect or curve that it is about, and the value computed, if any."""

    code: Because
    what: str = ""
    value: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """An effect found: its coefficients by key with 1 sigma, in ``unit``, and how sure its name is.

    ``aliases`` could take its place; ``separate_by`` is the measurement that separates them. ``log_p`` is
    adjusted for all that was tried, None where it was not tested; ``gain`` is what rows held out gained by it (ln
    predictive density); ``sign_flip_p`` checks it without a distribution (`procedures.diagnosis.sign_flip_test`),
    None where signs could not tell. ``share`` (0 to 1) is how much of what noise does not explain it does, on
    rows held out (`procedures.diagnosis.explained_share`), None where none were held out. ``reasons`` say why it
    is ambiguous. ``same_here`` are effects whose columns are this one's in a recording at one attitude that
    calibrates nothing: the finding is of the output there, whatever its name.
    """

    effect: str
    kind: Kind
    coefficients: tuple[str, ...]
    value: FloatArray
    std: FloatArray
    unit: str
    where: Mapping[str, object]
    confidence: Confidence
    aliases: tuple[str, ...]
    separate_by: str
    log_p: float | None
    gain: float
    shape: str = ""
    sign_flip_p: float | None = None
    share: float | None = None
    reasons: tuple[Reason, ...] = ()
    same_here: tuple[str, ...] = ()

    def doubted(self, code: Because, what: str = "", value: float | None = None) -> "Finding":
        """Return the finding as ambiguous, for one reason more."""
        return replace(self, confidence="ambiguous", reasons=(*self.reasons, Reason(code, what, value)))


@dataclass(frozen=True, slots=True)
class EffectTest:
    """An effect that was tried: statistic (chi-square over its coefficients), ln p, and ln p adjusted by Holm."""

    effect: str
    statistic: float
    log_p: float
    log_p_adjusted: float


@dataclass(frozen=True, slots=True)
class TooLarge:
    """An effect that would explain what is left but for its size: so many ``times`` what is plausible."""

    effect: str
    times: float


@dataclass(frozen=True, slots=True)
class ResidualRms:
    """A residual's rms [unit] before and after, in the campaign and on what was left out."""

    quantity: str
    unit: str
    before: float
    after: float
    held_out_before: float | None
    held_out_after: float | None


@dataclass(frozen=True, slots=True)
class TableSensor:
    """A gyroscope on rate tables: scale factor [output/(deg/s)], bias [deg/h] and offset [output] with 1 sigma.

    The bias holds the Earth's rate along the table's axis. The offset is what is put out at rest: the same as the
    bias, in outputs. ``is_offset`` says that it is the output's zero point, as 2.5 V of an analogue one, no rate.
    """

    axis: str
    scale: float
    scale_std: float
    bias: float
    bias_std: float
    offset: float = 0.0
    offset_std: float = 0.0
    is_offset: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class FoldedResidual:
    """A sensor's samples by the ``phase`` (n,) [turns] of a periodic finding, in ``unit``: means and 1 sigma.

    Of a finding that is not periodic, ``coordinate`` says in words what ``phase`` is instead, with its unit.
    """

    effect: str
    about: str
    triad: str
    axis: int
    unit: str
    phase: FloatArray
    before: FloatArray
    after: FloatArray
    sigma: FloatArray
    coordinate: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredEffect:
    """An effect that was declared: coefficients (k,) with 1 sigma, in ``unit``; last what is not linear."""

    effect: str
    coefficients: tuple[str, ...]
    value: FloatArray
    std: FloatArray
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class BenchAlone:
    """Fits, solution, what stays within the dwells by triad, and what was declared, as in `Diagnosis`."""

    fits: CampaignFits
    solution: Solution
    unexplained: ByTriad | None
    declared: tuple[DeclaredEffect, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """The whole: ``before`` and ``after`` are the fits without and with the effects, with the evidence of each.

    ``log_p`` is the global test's after all accepted effects. ``added`` are the effects in the model, ``values``
    their coefficients (k,) each as they were fitted. ``unexplained`` is what stays by triad within the dwells
    (`procedures.diagnosis.unexplained_residual.within_dwells`), and by how much it may have moved the values
    (`procedures.diagnosis.moved_by_curves`), None where the global test leaves nothing;
    ``unexplained_before`` is the same without the effects. ``left`` says where what the
    global test leaves shows most (`procedures.diagnosis.left_pattern`).
    ``clock`` is the relative 1 sigma of the clock's rate by which times were put right, None where they were not;
    it is in the sigmas of both solutions. ``on_table`` are the gyroscopes that rate tables turned, ``folded`` the
    samples by the phase of each periodic finding. ``too_large``
    are effects that nothing but their size speaks against, where more than noise is left. ``declared`` are the
    effects that were in the model from the start, ``declared_before`` the same without the findings; warnings of
    both solutions say which could not be. ``bench_alone`` is solved with what was found
    of bench and procedure, where an effect of the instrument is in doubt beside it. ``looked_at`` are the
    campaigns without what was cut out of their soaks. ``unnamed`` say which findings something without a name
    predicts better: the cause is then another, whatever the global test says. ``in_samples`` say what periodic
    errors leave in the samples.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    tried: tuple[EffectTest, ...]
    errors: tuple[ResidualRms, ...]
    before: CampaignFits
    after: CampaignFits
    evidence: Evidence
    solution_before: Solution
    solution: Solution
    log_p: float
    next_measurement: str
    added: tuple[Candidate, ...] = ()
    values: tuple[FloatArray, ...] = ()
    unexplained: ByTriad | None = None
    unexplained_before: ByTriad | None = None
    left: tuple[LeftPattern, ...] = ()
    clock: float | None = None
    on_table: tuple[TableSensor, ...] = ()
    too_large: tuple[TooLarge, ...] = ()
    folded: tuple[FoldedResidual, ...] = ()
    declared: tuple[DeclaredEffect, ...] = ()
    declared_before: tuple[DeclaredEffect, ...] = ()
    bench_alone: BenchAlone | None = None
    looked_at: tuple[Campaign, ...] = ()
    unnamed: tuple[Reason, ...] = ()
    in_samples: tuple[Reason, ...] = ()

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Return why the verdict is what it is, each reason as it was computed."""
        found = list[Reason]()
        if self.log_p < UNEXPLAINED_LOG_P:
            found.append(Reason(Because.RESIDUAL, value=self.log_p / log(10)))
        found += (*self.unnamed, *self.in_samples)
        for code, confidence in ((Because.AMBIGUOUS, "ambiguous"), (Because.LIKELY, "likely")):
            if code is Because.AMBIGUOUS or not found:
                found += [Reason(code, each.effect) for each in self.findings if each.confidence == confidence]
        return tuple(found)

    @property
    def is_calibrated(self) -> bool:
        """Say whether a triad is solved, or a gyroscope on a rate table: else there is no solution."""
        return bool(self.solution.accelerometer or self.solution.gyroscope or self.on_table)


def verdict_with_excess(findings: Sequence[Finding]) -> Verdict:
    """Return the verdict where more than noise is left: whether a finding explains at least half of the excess."""
    return (
        "partly"
        if any((each.share or 0.0) >= PARTLY_SHARE for each in findings if not each.effect.endswith(WITHOUT_CAUSE))
        else "unexplained"
    )


def combine_diagnoses(bench: Diagnosis, tables: Diagnosis) -> Diagnosis:
    """Return the bench's diagnosis with what the tables found; fits and evidence are the bench's.

    The p-value is the smaller one times two (Bonferroni).
    """
    findings = _told_once(bench.findings, tables.findings)
    verdict = max((bench.verdict, tables.verdict), key=WEAKEST_LAST.index)
    verdict = verdict_with_excess(findings) if verdict in {"partly", "unexplained"} else verdict
    next_measurement = "; ".join(filter(None, (bench.next_measurement, tables.next_measurement)))
    return replace(
        bench, verdict=verdict, findings=findings, tried=(*bench.tried, *tables.tried),
        errors=(*bench.errors, *tables.errors), log_p=min(min(bench.log_p, tables.log_p) + log(2), 0.0),  # of two
        next_measurement=next_measurement, left=(*bench.left, *tables.left), on_table=tables.on_table,
        too_large=(*bench.too_large, *tables.too_large), unnamed=(*bench.unnamed, *tables.unnamed),
    )  # fmt: skip


def with_file_names(tables: Diagnosis) -> Diagnosis:
    """Return a diagnosis of rate tables whose findings say which files they are of."""
    names = [table.name for each in tables.before.campaigns for table in each.rate_tables]
    where = {"file": names[0] if len(names) == 1 else names}
    return replace(
        tables, findings=tuple(replace(each, where={**each.where, **where}) for each in tables.findings)
    )


def _told_once(bench: Sequence[Finding], tables: Sequence[Finding]) -> tuple[Finding, ...]:
    sure = {each.effect for each in bench if each.confidence != "ambiguous"}
    added = [each for each in tables if each.effect not in sure]
    better = {each.effect for each in added if each.confidence != "ambiguous"}
    return (*(each for each in bench if each.effect not in better), *added)
