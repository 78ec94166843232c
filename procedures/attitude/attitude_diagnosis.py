"""Trace an attitude log's residual to what the model lacks, add it, and compare on rows that were not used.

Causes are found in the first rows, by the inference of a calibration (`procedures.inference`): errors of
the sensors or of the speed, and functions of time, which stand for all that has no name. The rest is held out.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.attitude_effects import (
    ATTITUDE_EFFECTS,
    NAMED,
    AttitudeEffect,
    AttitudeMotion,
    ResidualWindows,
    evidence_of,
    functions_of_time,
    propagated_residual,
    windows,
)
from procedures.attitude.attitude_estimate import AttitudeEstimate, estimate
from procedures.attitude.attitude_log import AttitudeLog, inclination
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.diagnosis.caches import clear_caches
from procedures.errors import NotObservable
from procedures.inference.hypotheses import named
from procedures.inference.posterior import Posterior, posterior
from procedures.inference.result import Finding, ResidualRms, Verdict, verdict_of
from procedures.inference.search import Search

FITTED_SHARE = 0.6  # of the rows, in time; the rest judges
MIN_WINDOWS = 30
MAX_ERROR_GROWTH = 1.1  # times the error before, on rows that had no say
HELD_BY_AIRSPEED_AID = ("airspeed", "velocity.attack")  # held by that filter itself


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeDiagnosis:
    """What was found; ``corrected`` is the log with it corrected, ``track`` the attitude on that."""

    verdict: Verdict
    findings: tuple[Finding, ...]
    errors: tuple[ResidualRms, ...]
    probabilities: Mapping[str, float]
    corrected: AttitudeLog
    track: AttitudeEstimate


@clear_caches()
def diagnose_attitude(
    log: AttitudeLog, aid: str, gains: ComplementaryGains | None, gravity: float
) -> AttitudeDiagnosis:
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
    search = Search(named(evidence, pool).with_functions(functions_of_time(evidence)).on(evidence))
    search.run()
    found = posterior(search)

    def judged(findings: Sequence[Finding]) -> tuple[AttitudeLog, AttitudeEstimate, ResidualRms]:
        corrected = without_effects(motion, findings)
        track = estimate(corrected, aid, gains, gravity, learns_motion=False)  # which would do without velocity
        errors = _errors(log, first, track, used, cut)
        if errors is None:
            seen = [(each, base_of(_motion(each, aid), aid, has_filter)) for each in (log, corrected)]
            errors = _apart(seen, used, gravity)
        return corrected, track, errors

    first = estimate(log, aid, gains, gravity, learns_motion=False)
    findings, best = list[Finding](), judged(())
    for each in _findings(found):  # what does not help the mixer, which may hold it already, is not added
        new = judged([*findings, each])
        if new[2].after < best[2].after:
            taken = 1 - (new[2].after / best[2].after) ** 2
            findings, best = [*findings, replace(each, share=taken)], new
    corrected, after, errors = best
    verdict = verdict_of(findings, is_left=False)
    if (errors.held_out_after or 0.0) > MAX_ERROR_GROWTH * (errors.held_out_before or 0.0):
        verdict = "unexplained"  # it does not predict the rows that had no say: nothing is corrected
        corrected, after = log, first
    if aid == "none":
        after = estimate(corrected, aid, gains, gravity)  # as a vehicle's, where it still is one
    return AttitudeDiagnosis(verdict, tuple(findings), (errors,), found.probabilities, corrected, after)


def _findings(found: Posterior) -> Iterator[Finding]:
    """Yield the causes with a name, the surest first."""
    for cause in found.causes:
        if (of := cause.coefficients) is not None:
            effect, name = of.candidate.effect, cause.hypothesis.name
            yield Finding(
                name, effect.kind, of.names, of.value, of.std, effect.unit, {}, cause.probability,
                effect.separate_by, aliases=tuple(each for each in cause.shares if each != name),
                shares=cause.shares, joint=cause.joint,
            )  # fmt: skip


def base_of(motion: AttitudeMotion, aid: str, has_filter: bool) -> FloatArray:
    """Return what a mixer's model adds to gravity (n, 3) [m/s2]: turning at speed, and in a filter braking too."""
    base = np.zeros_like(motion.log.f_b)
    if aid != "none":
        base += np.cross(motion.log.omega_b, motion.speed[:, None] * [1.0, 0.0, 0.0])
    if has_filter:
        base[:, 0] += motion.speed_slope
    return base


def without_effects(motion: AttitudeMotion, findings: Sequence[Finding]) -> AttitudeLog:
    """Return the log with effects corrected: rates and forces, or the speed where it is the aid's."""
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
