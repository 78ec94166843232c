"""Trace an attitude log's residual to what the model lacks, add it, and compare on rows that were not used.

The first part of the rows is what effects are found in, one at a time, by the calibration's own rules
(`procedures.diagnosis.effect_selection`): Holm over all that were tried, better foretold stretches, plausible
sizes, repeated by stretches left out in turn. The rest, which had no say, is where the mixer runs on the corrected
log.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.attitude_estimate import AttitudeEstimate, estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_gains import Gains
from procedures.attitude.diagnosis.attitude_effects import ATTITUDE_EFFECTS, AttitudeEffect, AttitudeMotion
from procedures.attitude.diagnosis.attitude_evidence import (
    NAMED,
    ResidualWindows,
    evidence_of,
    propagated_residual,
    stretches,
    windows,
)
from procedures.attitude.forward_right_down import inclination
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.effect_selection import (
    MAX_EFFECTS,
    MAX_LOG_P,
    MIN_DENSITY_GAIN,
    AdoptedEffect,
    TestedEffect,
    density_gain,
    next_effect,
    rank_effects,
)
from procedures.diagnosis.equivalent_effects import are_aliases
from procedures.diagnosis.evidence_cache import let_go_at_the_end
from procedures.diagnosis.explained_share import explained_share
from procedures.diagnosis.linear_model import significance
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.result import Confidence, EffectTest, Finding, ResidualRms, Verdict
from procedures.diagnosis.sweep_repeatability import std_of_repeats
from procedures.errors import NotObservable

FITTED_SHARE = 0.6  # of the rows, in time; the rest judges
MIN_WINDOWS = 30
MAX_ERROR_GROWTH = 1.1  # times the error before, on rows that had no say
HELD_BY_AIRSPEED_AID = ("airspeed", "velocity.attack")  # held by that law itself
CONFIDENCE_ORDER: tuple[Confidence, ...] = ("ambiguous", "likely", "established")


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeDiagnosis:
    """What was found; ``corrected`` is the log with it taken off, ``track`` the attitude on that."""

    verdict: Verdict
    findings: tuple[Finding, ...]
    errors: tuple[ResidualRms, ...]
    tried: tuple[EffectTest, ...]
    corrected: AttitudeLog
    track: AttitudeEstimate


@let_go_at_the_end()
def diagnose_attitude(log: AttitudeLog, aid: str, gains: Gains | None, gravity: float) -> AttitudeDiagnosis:
    """Find what the residual between mixer and truth, or gyros and accelerometers, says the model lacks.

    Raises
    ------
    NotObservable
        If the log is too short, or its truth too sparse.
    """
    speed = _speed(log, aid)
    motion = _motion(log, aid)
    has_filter = gains is None and aid in ("airspeed-filter", "gnss")
    base = base_of(motion, aid, has_filter)
    used = np.arange(len(log.t)) < FITTED_SHARE * len(log.t)
    cut = windows(motion, base, gravity, used & _counts(log))
    if len(cut.rows) < MIN_WINDOWS:
        scored = ", scored" if log.scored is not None else ""
        span = f"{cut.rows.shape[1] * log.nominal:g} s without gap"
        what = f"{span}, with roll_rad and pitch_rad{scored}" if cut.has_truth else span
        where = f"in the log's first {FITTED_SHARE:.0%}, which has {len(cut.rows)}"
        raise NotObservable("what the model lacks", [f"{MIN_WINDOWS} stretches of {what}, {where}"])
    free, held = _split(aid, speed is not None, cut.has_truth, has_filter)
    evidence, pool = evidence_of(motion, base, cut, free, held, gravity, aid != "none")
    adopted, tried = _adopt(evidence, pool)

    def judged(
        adopted: Sequence[AdoptedEffect],
    ) -> tuple[tuple[Finding, ...], AttitudeLog, AttitudeEstimate, ResidualRms]:
        findings = tuple(_finding(evidence, each, adopted, pool) for each in adopted)
        corrected = without_effects(motion, findings)
        track = estimate(
            corrected, aid, gains, gravity, learns_motion=False
        )  # which would do without the velocity
        errors = _errors(log, first, track, used, cut)
        if errors is None:
            seen = [(each, base_of(_motion(each, aid), aid, has_filter)) for each in (log, corrected)]
            errors = _apart(seen, used, gravity)
        return findings, corrected, track, errors

    first = estimate(log, aid, gains, gravity, learns_motion=False)
    kept, best = list[AdoptedEffect](), judged(())
    for each in adopted:  # what does not help the mixer, which may hold it already, is not added
        new = judged([*kept, each])
        if new[3].after < best[3].after:
            kept, best = [*kept, each], new
    findings, corrected, after, errors = best
    verdict: Verdict = (
        min((f.confidence for f in findings), key=CONFIDENCE_ORDER.index) if findings else "consistent"
    )
    if (errors.held_out_after or 0.0) > MAX_ERROR_GROWTH * (errors.held_out_before or 0.0):
        verdict = "unexplained"  # it does not foretell the rows that had no say: nothing is taken off
        corrected, after = log, first
    if aid == "none":
        after = estimate(corrected, aid, gains, gravity)  # as a vehicle's, where it still is one
    tests = tuple(EffectTest(t.candidate.effect.name, t.test.statistic, t.log_p, t.log_p_adjusted) for t in tried)
    return AttitudeDiagnosis(verdict, findings, (errors,), tests, corrected, after)


def base_of(motion: AttitudeMotion, aid: str, has_filter: bool) -> FloatArray:
    """Return what a mixer's model adds to gravity (n, 3) [m/s2]: turning at speed, and in a filter braking too."""
    base = np.zeros_like(motion.log.f_b)
    if aid != "none":
        base += np.cross(motion.log.omega_b, motion.speed[:, None] * [1.0, 0.0, 0.0])
    if has_filter:
        base[:, 0] += motion.speed_slope
    return base


def without_effects(motion: AttitudeMotion, findings: Sequence[Finding]) -> AttitudeLog:
    """Return the log with effects taken off: rates and forces, or the speed where it is the aid's."""
    log, rate, force = motion.log, motion.log.omega_b.copy(), motion.log.f_b.copy()
    airspeed = None if log.airspeed is None else log.airspeed.copy()
    for found in findings:
        effect = NAMED[found.effect]
        if effect.is_of_aid and airspeed is not None:
            change = motion.speed if effect.name == "aid.scale" else motion.speed_slope
            airspeed = airspeed + found.value[0] * change
            continue
        rate -= 0.0 if effect.rate is None else effect.rate(motion) @ found.value
        force -= 0.0 if effect.force is None else effect.force(motion) @ found.value
    return replace(log, omega_b=rate, f_b=force, airspeed=airspeed)


def _speed(log: AttitudeLog, aid: str) -> FloatArray | None:
    """Return the forward speed (n,) of a log, held over rows without; None where it has none."""
    if log.airspeed is not None and aid != "gnss" and np.isfinite(log.airspeed).any():
        values = log.airspeed
    elif log.velocity is not None and np.isfinite(log.velocity).all(axis=1).any():
        values = np.linalg.norm(log.velocity, axis=1)
    else:
        return None
    known = np.isfinite(values)
    return np.interp(log.t, log.t[known], values[known])


def _motion(log: AttitudeLog, aid: str) -> AttitudeMotion:
    speed = _speed(log, aid)
    return AttitudeMotion.of(log, np.zeros(len(log.t)) if speed is None else speed)


def _counts(log: AttitudeLog) -> BoolArray:
    return np.ones(len(log.t), bool) if log.scored is None or log.roll is None else log.scored


def _split(
    aid: str, has_speed: bool, has_truth: bool, has_filter: bool
) -> tuple[tuple[AttitudeEffect, ...], tuple[AttitudeEffect, ...]]:
    """Return the effects to try, and those that the filter estimates itself."""
    fit = [e for e in ATTITUDE_EFFECTS if (has_speed or not e.needs_speed) and (has_truth or not e.needs_truth)]
    fit = [e for e in fit if not (has_filter and e.name == "velocity.rate")]
    fit = [e for e in fit if (not e.is_of_aid and e.name != "velocity.forward") or e.is_of_aid == (aid != "none")]
    held = tuple(e for e in fit if (has_filter and e.of_velocity) or (aid, e.name) == HELD_BY_AIRSPEED_AID)
    return tuple(e for e in fit if e not in held), held


def _adopt(evidence: Evidence, pool: dict[str, list[Candidate]]) -> tuple[list[AdoptedEffect], list[TestedEffect]]:
    adopted, tried = list[AdoptedEffect](), list[TestedEffect]()
    for _ in range(MAX_EFFECTS):
        found = rank_effects(evidence, pool, adopted)
        tried = tried or found
        new = next_effect(evidence, found, adopted, stretches(evidence))
        if new is None:
            break
        adopted.append(new)
    return adopted, tried


def _finding(
    evidence: Evidence, each: AdoptedEffect, adopted: Sequence[AdoptedEffect], pool: dict[str, list[Candidate]]
) -> Finding:
    candidate, left_out = each.candidate, stretches(evidence)
    beside = [other.term for other in adopted if other is not each]
    inside = {other.candidate.effect.name for other in adopted}
    fit = candidate.fit(evidence, beside)
    test, gain = significance(evidence, fit), density_gain(evidence, candidate, beside, left_out)
    others = {name: way.term for name, (way,) in pool.items() if name not in inside}
    aliases = tuple(compress(others, are_aliases(evidence, fit, list(others.values()))))
    log_p = min(test.log_p + np.log(len(pool)), 0.0)
    is_sure = log_p < MAX_LOG_P and gain > MIN_DENSITY_GAIN
    confidence: Confidence = "ambiguous" if aliases else "established" if is_sure else "likely"
    std = np.maximum(test.std, std_of_repeats(evidence, fit, left_out))
    effect = candidate.effect
    return Finding(
        effect.name, effect.kind, candidate.columns.coefficients, test.value, std, effect.unit, {}, confidence,
        aliases, effect.separate_by, log_p, gain, share=explained_share(evidence, candidate, beside, left_out),
    )  # fmt: skip


def _errors(
    log: AttitudeLog, before: AttitudeEstimate, after: AttitudeEstimate, used: BoolArray, cut: ResidualWindows
) -> ResidualRms | None:
    truth = log.true_down
    if truth is None or not cut.has_truth:
        return None
    rows = np.isfinite(truth).all(axis=1) & _counts(log)
    parts = (rows & used, rows & ~used)
    angles = [inclination(track.down[part], truth[part]) for part in parts for track in (before, after)]
    return _rms("inclination of the mixer against truth", angles)


def _apart(seen: Sequence[tuple[AttitudeLog, FloatArray]], used: BoolArray, gravity: float) -> ResidualRms:
    angles = list[FloatArray]()
    for part in (used, ~used):
        for log, base in seen:
            motion = AttitudeMotion.of(log, np.zeros(len(log.t)))
            cut = windows(motion, base, gravity, part)
            left, _ = propagated_residual(motion, cut, np.zeros((len(log.t), 3, 0)))
            angles.append(np.linalg.norm(left, axis=1))
    return _rms("gyro-propagated against accelerometer attitude, over a window", angles)


def _rms(name: str, angles: Sequence[FloatArray]) -> ResidualRms:
    """Return the rms of angles [rad]: before and after, and both again of the rows that had no say."""
    rms = [float(np.degrees(np.sqrt(np.mean(part**2)))) if len(part) else None for part in angles]
    return ResidualRms(name, "deg", rms[0] or 0.0, rms[1] or 0.0, *rms[2:])
