"""Tilt of the cube during a manual rotation, by the accelerometers at rest before and after it.

``N = K u + b + s`` (Yao, Hu, He 2018, eq. 1, 2), s the step of the bias at its turn-on, by the dwells and the
upright sensor of that turn-on, else as wide as `TURN_ON_STEP_STD_G`: what is left of the level sensors is the
tilt. Whether debris goes round with the cube (the axis tilts in it) or lies on the slab (the cube wobbles about
its face's normal) cannot be determined: half the tilt is taken, and half of it is 1 sigma; below five sigma none.
Where no dwell says s, each of several turns from one position is taken to tilt by what it lies off their mean.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RestRecord, TurnRecord
from procedures.campaign.observations import TriadDwells, TriadRests, TurnTotal, channel, rest_rates
from procedures.counts.count_rate import MIN_DWELL_SAMPLES
from procedures.counts.sample_records import series_rows
from procedures.frames import AXES
from procedures.positions import cross_axes, face_of
from procedures.twelve_positions.accelerometer_fit import TURN_ON_STEP_STD_G, TriadFit, specific_force
from procedures.twelve_positions.bench_parameters import BenchParameters, Placement, cube_numbers
from procedures.units import RAD_PER_ARCSEC, STANDARD_GRAVITY

SHORTEST_REST_S, LONGEST_REST_S = 1.0, 10.0  # s, of rest at an end
STARTING_S = 0.5  # s, next to the motion: a hand that takes hold
TURNED_SHARE = 1 / 720  # of a revolution: so far a cube at rest seems to turn, by noise and the Earth's rate
MIN_TILT_SIGMAS = 5.0
MIN_TILT_RAD = 5 * RAD_PER_ARCSEC  # rad: seats differ by 1 arcsec
DRIFT_SCATTERS = 2.0  # scatters of the dwells beyond noise, by which a drift may be off in turns that follow them
MAX_TILT_RAD = 0.1  # rad: more is another face, or a fit that has failed
DIFFERENCE_STEP = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class RotationTilt:
    """By how much the up vector was off where dwells put it before and after a turn, (2,) [rad] each.

    Along the face's two other cube axes in x, y, z order; ``std`` (2,) is 1 sigma of their mean, ``noise`` (2,) of
    their difference. ``is_apart``: it lay otherwise than in another turn, and nothing else shows how.
    """

    before: FloatArray
    after: FloatArray
    std: FloatArray
    noise: FloatArray
    is_apart: bool = False

    @property
    def mean(self) -> FloatArray:
        """The tilt (2,) [rad]."""
        return (self.before + self.after) / 2

    @property
    def is_off(self) -> bool:
        """Whether the cube tilted, or came to lie otherwise, by more than chance."""
        off = np.concatenate((self.mean, self.after - self.before))
        limit = np.maximum(MIN_TILT_SIGMAS * np.concatenate((self.std, self.noise)), MIN_TILT_RAD)
        is_beyond = self.is_apart or bool(np.any(np.abs(off) > limit))
        return is_beyond and bool(np.all(np.abs(self.mean) < MAX_TILT_RAD))

    @property
    def axis_std(self) -> FloatArray:
        """1 sigma (2,) [rad] of half the tilt as that of the axis turned about."""
        parts = (self.std, self.mean / 2, (self.after - self.before) / 2)
        total: FloatArray = np.sqrt(np.sum(np.square(parts), axis=0))
        return total


def turn_rests(turns: Sequence[TurnTotal]) -> TriadRests | None:
    """Estimate the accelerometers' rates at rest before and after each turn, two rests of its name after another.

    A turn that was not at rest at both ends has none; None if that is so of all.
    """
    found = list[tuple[int, RestRecord]]()
    for turn in turns:
        series, ends = turn.record.series, _ends(turn)
        if series.accel is not None and ends is not None:
            for rows in ends:
                inside = series.starts[(series.starts > rows.start) & (series.starts < rows.stop)] - rows.start
                rest = series_rows(series, rows, np.concatenate(([0], inside)))
                found.append((turn.campaign, RestRecord(turn.record.name, None, rest)))
    return rest_rates(found, "accelerometer") if found else None


def _ends(turn: TurnTotal) -> tuple[slice, slice] | None:
    """Return the samples at rest before and after it, by the angle that the vertical gyroscope saw."""
    series = turn.record.series
    samples = channel(series, "gyroscope")
    if samples is None:
        return None
    sensor = int(np.argmax(np.abs(turn.total)))
    angle = np.cumsum(samples[:, sensor]) / samples[:, sensor].sum() * turn.record.revolutions
    away = np.flatnonzero(np.abs(angle) > TURNED_SHARE)
    back = np.flatnonzero(np.abs(angle - angle[-1]) > TURNED_SHARE)
    spare, longest = round(STARTING_S / series.period), round(LONGEST_REST_S / series.period)
    least = max(MIN_DWELL_SAMPLES, round(SHORTEST_REST_S / series.period))
    if not len(away) or not len(back):
        return None
    until, since, n = int(away[0]) - spare, int(back[-1]) + 1 + spare, len(series)
    if until < least or n - since < least:
        return None
    return slice(max(0, until - longest), until), slice(since, min(n, since + longest))


def rotation_tilts(
    campaigns: Sequence[Campaign], turns: Sequence[TurnTotal], rests: TriadRests | None,
    dwells: TriadDwells | None, accelerometer: TriadFit | None,
) -> list[RotationTilt | None]:  # fmt: skip
    """Return how the cube tilted in every turn; None where that cannot be determined.

    ``dwells`` are the accelerometers' as they were seen, with the steps of their turn-ons; ``accelerometer`` is
    their fit.
    """
    none: list[RotationTilt | None] = [None] * len(turns)
    if rests is None or dwells is None or accelerometer is None or accelerometer.is_turned_freely:
        return none
    if (
        accelerometer.seen.dwells != dwells.dwells
        or accelerometer.bench.cubes != int(cube_numbers(campaigns).max()) + 1
    ):
        return none
    names = [(number, record.name) for number, record in rests.rests]
    at = [(i, names.index((turn.campaign, turn.record.name))) for i, turn in enumerate(turns)
          if (turn.campaign, turn.record.name) in names]  # fmt: skip
    seen = [turns[i] for i, _ in at]
    tilts = _tilts(campaigns, seen, rests, [j for _, j in at], dwells, accelerometer)
    for (i, _), tilt in zip(at, tilts, strict=True):
        none[i] = tilt
    return none


def _tilts(
    campaigns: Sequence[Campaign], turns: Sequence[TurnTotal], rests: TriadRests, first: Sequence[int],
    dwells: TriadDwells, fitted: TriadFit,
) -> list[RotationTilt]:  # fmt: skip
    """Take off what the fit and the turn-ons' steps say of every turn's rests; ``first`` are their rows."""
    t, model = len(turns), _model(campaigns, turns, fitted)
    rate = np.array([(rests.rate[j], rests.rate[j + 1]) for j in first])
    misfit = 1 + DRIFT_SCATTERS**2 * max(0.0, fitted.fit.chi2 / max(fitted.fit.dof, 1) - 1)
    variance = misfit * np.array([(rests.std[j] ** 2, rests.std[j + 1] ** 2) for j in first])
    g = np.array([campaigns[turn.campaign].sigma.unsettled_accelerometer / STANDARD_GRAVITY for turn in turns])
    unsettled = np.outer(g, fitted.k) ** 2
    x = fitted.fit.x[: 12 + fitted.bench.size]
    expected, J = model(x), _jacobian(model, x)
    off = np.concatenate((rate.mean(axis=1), dwells.rate)) - expected
    noise = np.concatenate((variance.sum(axis=1) / 4 + misfit * unsettled, misfit * fitted.sigma**2))
    step, step_J, step_variance = _steps(campaigns, turns, dwells, off, J, noise, fitted)
    inverse = np.linalg.inv(fitted.K)
    cov = misfit * fitted.fit.covariance[: len(x), : len(x)]
    found, instability = list[RotationTilt](), list[FloatArray]()
    for i, turn in enumerate(turns):
        face = face_of(turn.record.start_position)
        to_tilt = (campaigns[turn.campaign].fixture.C_sb.T @ inverse)[list(cross_axes(face))]
        row = to_tilt @ (J[i] - step_J[i])
        predicted = np.einsum("ip,pq,iq->i", row, cov, row)
        std = np.sqrt(predicted + to_tilt**2 @ (noise[i] + step_variance[i]))
        both = to_tilt @ (rate[i] - expected[i] - step[i]).T
        found.append(RotationTilt(both[:, 0], both[:, 1], std, np.sqrt(to_tilt**2 @ variance[i].sum(axis=0))))
        instability.append(np.sqrt(to_tilt**2 @ (misfit * unsettled[i])))
    assert len(found) == t
    return against_each_other([(turn.campaign, turn.record) for turn in turns], found, instability)


def against_each_other(
    turns: Sequence[tuple[int, TurnRecord]], tilts: Sequence[RotationTilt], instability: Sequence[FloatArray]
) -> list[RotationTilt]:
    """Return tilts in which contradicting turns, whose tilt nothing else determines, are marked as apart.

    Turns from one position in one turn-on have one step of the bias in common.

    Parameters
    ----------
    turns : (campaign, record)
    tilts : of each
    instability : (2,) [rad] of each, 1 sigma of its bias off that of the others of its turn-on
    """
    found = list(tilts)
    alike = [(number, turn.turn_on, turn.start_position) for number, turn in turns]
    for one in dict.fromkeys(alike):
        group = [i for i, other in enumerate(alike) if other == one]
        mean, known = np.array([tilts[i].mean for i in group]), np.min([tilts[i].std for i in group], axis=0)
        apart = np.ptp(mean, axis=0)
        noise = np.max([np.hypot(tilts[i].noise / np.sqrt(2), np.sqrt(2) * instability[i]) for i in group], axis=0)
        if np.any((apart > np.maximum(MIN_TILT_SIGMAS * noise, MIN_TILT_RAD)) & (apart < known)):
            for i in group:
                found[i] = _apart(tilts[i], mean.mean(axis=0), apart / 2)
    return found


def _apart(tilt: RotationTilt, mean: FloatArray, half: FloatArray) -> RotationTilt:
    """Return a tilt [rad] off the ``mean`` (2,) of several, give or take ``half`` (2,) of what parts them."""
    std = np.hypot(half, tilt.noise / 2)
    return replace(tilt, before=tilt.before - mean, after=tilt.after - mean, std=std, is_apart=True)


def _model(
    campaigns: Sequence[Campaign], turns: Sequence[TurnTotal], fitted: TriadFit
) -> Callable[[FloatArray], FloatArray]:
    """Return what maps a fit's parameters (..., p) to rates at rest of turns, then of dwells, (..., t + n, 3)."""
    own, cubes = fitted.bench, cube_numbers(campaigns)
    placed = tuple(
        Placement(turn.campaign, int(cubes[turn.campaign]), turn.record.start_position, 0.0) for turn in turns
    )
    bench = BenchParameters(placed, own.campaigns, own.cubes)

    def rates(x: FloatArray) -> FloatArray:
        shared, K = x[..., 12 : 12 + own.shared], x[..., :9].reshape(*x.shape[:-1], 3, 3)
        level = np.concatenate((shared, np.zeros((*x.shape[:-1], len(placed)))), axis=-1)
        forces = specific_force(bench, level), specific_force(own, x[..., 12 : 12 + own.size])
        return np.concatenate(forces, axis=-2) @ np.swapaxes(K, -1, -2) + x[..., None, 9:12]

    return rates


def _jacobian(model: Callable[[FloatArray], FloatArray], x: FloatArray) -> FloatArray:
    """Return (m, 3, p) by differences."""
    scale = np.where(np.arange(len(x)) < 12, np.max(np.abs(x[:12])), 1.0) * DIFFERENCE_STEP
    ahead, behind = model(x + np.stack((np.diag(scale), -np.diag(scale))))
    found: FloatArray = np.moveaxis(ahead - behind, 0, -1) / (2 * scale)
    return found


def _steps(
    campaigns: Sequence[Campaign], turns: Sequence[TurnTotal], dwells: TriadDwells, off: FloatArray, J: FloatArray,
    variance: FloatArray, fitted: TriadFit,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return each turn's step of the bias (t, 3), what it takes of the parameters (t, 3, p), its variance (t, 3).

    By weighted means of what says it, ``off`` (t + n, 3) with ``J`` (t + n, 3, p) and ``variance`` (t + n, 3).
    """
    of = [(turn.campaign, turn.record.turn_on) for turn in turns]
    of += [(number, dwell.turn_on) for number, dwell in dwells.dwells]
    mounted = [campaigns[turn.campaign].fixture.C_sb[:, AXES.index(turn.record.axis)] for turn in turns]
    upright = np.rint(mounted) != 0
    says = np.concatenate((upright, np.ones((len(of) - len(turns), 3), dtype=bool)))
    plausible = (TURN_ON_STEP_STD_G * fitted.k) ** 2
    steps, columns, left = [], [], []
    for i in range(len(turns)):
        same = np.array([other == of[i] for other in of])
        weight = np.where(same[:, None] & says, 1 / variance, 0.0)
        total = weight.sum(axis=0) + 1 / plausible
        steps.append((weight * off).sum(axis=0) / total)
        columns.append((weight[..., None] * J).sum(axis=0) / total[:, None])
        left.append(1 / total)
    return np.array(steps), np.array(columns), np.array(left)
