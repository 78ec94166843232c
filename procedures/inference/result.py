"""What a diagnosis returns: verdict, findings, the error before and after, what was tried."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import log
from typing import Literal

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.effects.effect import Kind
from procedures.evidence.candidates import Candidate
from procedures.evidence.residual_patterns import LeftPattern
from procedures.evidence.residual_rows import Evidence
from procedures.inference.priors import Confidence, word
from procedures.uncertainty.sources import ByTriad

Fault = Literal["", "wrong row", "frozen", "clipped", "noise"]
Verdict = Literal["consistent", "established", "likely", "ambiguous", "partly", "unexplained"]
CERTAIN = 1.0  # probability of what stands in the samples, as a value that never changes
UNEXPLAINED_LOG_P = log(0.01)  # of the global test, below which the residual is more than noise


class Because(StrEnum):
    """Why a verdict is what it is; what the value of such a `Reason` is."""

    RESIDUAL = "residual_exceeds_noise"  # log10 p of the global test
    NAMELESS = "cause_without_a_name"  # probability
    AMBIGUOUS = "finding_ambiguous"  # probability of the name
    LIKELY = "finding_likely"  # probability of the name
    STRUCTURE = "samples_keep_structure"  # share of the samples' variance that a table by phase explains more
    MOTION = "rests_move"  # by how much the parts of a rest differ beyond noise [g]


@dataclass(frozen=True, slots=True)
class Reason:
    """A reason as it is: its code, the effect or function that it is about, and the value computed, if any."""

    code: Because
    what: str = ""
    value: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """An effect found: its coefficients by key with 1 sigma, in ``unit``, and how sure its name is.

    ``probability`` is that of the name, ``shares`` those of all names that the cause may have, its own included;
    ``joint`` is the probability that one of them acts. ``aliases`` are the other names; ``separate_by`` is the
    measurement that separates them. ``errors`` are those held out of what the effect acts on, without and with it.
    ``share`` (0 to 1) is by how much of their squares it reduces them. ``same_here`` are effects whose columns are
    this one's in a recording at one attitude that calibrates nothing: the finding is of the output there, whatever
    its name. ``fault`` is of a disturbance what of the channel fails. ``times_expected`` is the largest
    coefficient over the size that its catalogue expects.
    """

    effect: str
    kind: Kind
    coefficients: tuple[str, ...]
    value: FloatArray
    std: FloatArray
    unit: str
    where: Mapping[str, object]
    probability: float
    separate_by: str
    shape: str = ""
    share: float | None = None
    aliases: tuple[str, ...] = ()
    shares: Mapping[str, float] = field(default_factory=dict)
    joint: float | None = None
    errors: tuple["ResidualRms", ...] = ()
    same_here: tuple[str, ...] = ()
    times_expected: float | None = None
    fault: Fault = ""

    @property
    def confidence(self) -> Confidence:
        """The word for the probability of the name."""
        return word(self.probability)

    def or_else(self, *names: str) -> "Finding":
        """Return the finding as one of several causes that are as likely."""
        return replace(
            self, aliases=names, probability=self.probability / (1 + len(names)), joint=self.probability
        )


@dataclass(frozen=True, slots=True)
class EffectTest:
    """An effect that was looked for before the inference, and ln of the odds of where it is likeliest."""

    effect: str
    log_odds: float


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
class Unnamed:
    """A cause that no name is likely for: ``what`` it looks like, how probable that is, what it may be instead.

    ``note`` says where and how, ``shares`` are by name the probabilities of all that it may be. ``errors`` are
    held out of the rows on which it acts, without and with it.
    """

    what: str
    probability: float
    joint: float
    note: str
    shares: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """The whole: ``before`` and ``after`` are the fits without and with the effects, with the evidence of each.

    ``log_p`` is the global test's after all named causes. ``added`` are the effects in the model, ``values``
    their coefficients (k,) each as they were fitted. ``unnamed`` are the causes without a name,
    ``probabilities`` those of every name that was considered, ``not_separable`` the names that the model's own
    parameters take wholly, with the measurement that separates each. ``unexplained`` is what stays by triad within
    the dwells (`procedures.evidence.residual_patterns.within_dwells`), None where the global test leaves
    nothing; ``unexplained_before`` is the same without the effects. ``left`` says where what is left shows most
    (`procedures.evidence.residual_patterns`).
    ``clock`` is the relative 1 sigma of the clock's rate by which times were put right, None where they were not;
    it is in the sigmas of both solutions. ``on_table`` are the gyroscopes that rate tables turned, ``folded`` the
    samples by the phase of each periodic finding. ``declared`` are the effects that were in the model from the
    start, ``declared_before`` the same without the findings; warnings of both solutions say which could not be.
    ``bench_alone`` is solved with what was found of bench and procedure, where an effect of the instrument is in
    doubt next to it. ``looked_at`` are the campaigns without what was cut out of their soaks. ``other_reasons``
    are no cause in the model: rests that move, what periodic errors leave in the samples.
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
    unnamed: tuple[Unnamed, ...] = ()
    probabilities: Mapping[str, float] = field(default_factory=dict)
    not_separable: Mapping[str, str] = field(default_factory=dict)
    added: tuple[Candidate, ...] = ()
    values: tuple[FloatArray, ...] = ()
    unexplained: ByTriad | None = None
    unexplained_before: ByTriad | None = None
    left: tuple[LeftPattern, ...] = ()
    clock: float | None = None
    on_table: tuple[TableSensor, ...] = ()
    folded: tuple[FoldedResidual, ...] = ()
    declared: tuple[DeclaredEffect, ...] = ()
    declared_before: tuple[DeclaredEffect, ...] = ()
    bench_alone: BenchAlone | None = None
    looked_at: tuple[Campaign, ...] = ()
    other_reasons: tuple[Reason, ...] = ()

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Return why the verdict is what it is, each reason as it was computed."""
        found = list[Reason]()
        if self.log_p < UNEXPLAINED_LOG_P:
            found.append(Reason(Because.RESIDUAL, value=self.log_p / log(10)))
        found += [Reason(Because.NAMELESS, each.what, each.joint) for each in self.unnamed]
        found += self.other_reasons
        for code, confidence in ((Because.AMBIGUOUS, "possible"), (Because.LIKELY, "likely")):
            if code is Because.AMBIGUOUS or not found:
                such = [each for each in self.findings if each.confidence == confidence]
                found += [Reason(code, each.effect, each.probability) for each in such]
        return tuple(found)

    @property
    def is_calibrated(self) -> bool:
        """Say whether a triad is solved, or a gyroscope on a rate table: else there is no solution."""
        return bool(self.solution.accelerometer or self.solution.gyroscope or self.on_table)


def verdict_of(findings: Sequence[Finding], *, is_left: bool) -> Verdict:
    """Return the verdict; ``is_left`` says that the findings leave more than noise."""
    words = {each.confidence for each in findings}
    if is_left:
        return "partly" if words - {"possible"} else "unexplained"
    if "possible" in words:
        return "ambiguous"
    return "likely" if "likely" in words else "established" if words else "consistent"


def combine_diagnoses(bench: Diagnosis, tables: Diagnosis) -> Diagnosis:
    """Return the bench's diagnosis with what the tables found; fits and evidence are the bench's.

    The p-value is the smaller one times two (Bonferroni).
    """
    findings = _reported_once(bench.findings, tables.findings)
    is_left = bool({bench.verdict, tables.verdict} & {"partly", "unexplained"})
    next_measurement = "; ".join(filter(None, (bench.next_measurement, tables.next_measurement)))
    return replace(
        bench, verdict=verdict_of(findings, is_left=is_left), findings=findings,
        tried=(*bench.tried, *tables.tried), errors=(*bench.errors, *tables.errors),
        log_p=min(min(bench.log_p, tables.log_p) + log(2), 0.0),  # of two
        next_measurement=next_measurement, left=(*bench.left, *tables.left), on_table=tables.on_table,
        unnamed=(*bench.unnamed, *tables.unnamed), other_reasons=(*bench.other_reasons, *tables.other_reasons),
        probabilities={**tables.probabilities, **bench.probabilities},
    )  # fmt: skip


def with_file_names(tables: Diagnosis) -> Diagnosis:
    """Return a diagnosis of rate tables whose findings say which files they are of."""
    names = [table.name for each in tables.before.campaigns for table in each.rate_tables]
    where = {"file": names[0] if len(names) == 1 else names}
    return replace(
        tables, findings=tuple(replace(each, where={**each.where, **where}) for each in tables.findings)
    )


def _reported_once(bench: Sequence[Finding], tables: Sequence[Finding]) -> tuple[Finding, ...]:
    sure = {each.effect for each in bench if each.confidence != "possible"}
    added = [each for each in tables if each.effect not in sure]
    better = {each.effect for each in added if each.confidence != "possible"}
    return (*(each for each in bench if each.effect not in better), *added)
