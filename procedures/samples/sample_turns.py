"""Errors of the gyroscopes that are periodic in an auxiliary angle while the cube or a table turns.

The rate is far larger, and the Earth's rate and gravity turn with it. What is known of both is subtracted from
every turn first, and off the candidate's columns alike, psi being the angle turned:

    the sensor about the axis:  the rate of an angle that turns along; a line in time, cos psi, sin psi, rate^2
    the two next to it:         the rate that the first one saw; a line in time, cos psi, sin psi, rate^2

A noisy angle's rate as a column would come out too small, so its factor is that of the whole turn. What stays is
averaged over as many samples as the angle's highest harmonic allows: an encoder's noise falls by their number.

About an axis that stands still the Earth's rate and gravity have no part of twice psi or more. The harmonic of a
channel that is once psi is theirs, and left out. So is the sensor about the axis where no channel is the angle
that was turned, since nobody knows what the hand did.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, TurnRecord
from procedures.frames import AXES
from procedures.inference import odds
from procedures.inference.result import Finding, ResidualRms
from procedures.positions import face_normal, face_of
from procedures.samples.held_samples import HeldChannel, Scales, held_channels
from procedures.samples.sample_blocks import AUXILIARY, LEFT_OUT, Fitted, Scores
from procedures.samples.sample_phases import NATURAL, NEAR_NATURAL, ORDERS, WRAP_SHARE, likeliest
from procedures.units import DEG_H_PER_DEG_S

HARMONICS = (8, 32, 128)  # looked at: more where so many are likeliest
RESOLVED = 0.25  # turns of the highest harmonic in a sample, at most
BLOCKS, MIN_BLOCK = 96, 64  # of all turns; samples
MIN_WRAPS = 4  # of a channel, in all
ALONG = 1e-3  # of the turns' rms, by which an angle that turns along leaves a straight line of psi
ONCE = 0.1  # turns of psi: a harmonic so near to one cannot be separated from the Earth's rate
SEPARATE = "turns at another speed: a bearing that wobbles does so in proportion to it"


@dataclass(frozen=True, slots=True, eq=False)
class Turning:
    """A turn: its three gyroscopes, which is about the axis, and the angle ``psi`` (n,) [rad] that it saw."""

    record: TurnRecord
    channels: tuple[HeldChannel, ...]
    own: int
    psi: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Angle:
    """A channel that wraps at ``period``, or goes with psi: ``turns`` (n,) of each recording.

    ``ratio`` is its turns in one of psi, zero where it does not go along.
    """

    name: str
    period: float
    turns: tuple[FloatArray, ...]
    ratio: float

    @property
    def step(self) -> float:
        """The turns in a sample at the usual speed."""
        steps = np.abs(np.concatenate([np.diff(each) for each in self.turns]))
        return float(np.median(steps[steps > steps.max() / 10]))

    def harmonics(self, most: int) -> tuple[int, ...]:
        """Return the harmonics that samples resolve and that neither the Earth's rate nor gravity has."""
        most = max(min(most, int(RESOLVED / self.step)), 1)
        return tuple(h for h in range(1, most + 1) if abs(abs(h * self.ratio) - 1) > ONCE)


def periodic_in_turns(
    campaigns: Sequence[Campaign], scales: Scales
) -> tuple[tuple[Finding, ...], tuple[ResidualRms, ...]]:
    """Return what is periodic in an auxiliary angle while the gyroscopes turn, and their rms without and with it.

    ``scales`` (3,) of a triad are outputs a second in 1 deg/s.
    """
    turns = [each for one in campaigns for turn in one.turns for each in _turning(one, turn, scales)]
    angles = list(_angles(turns))
    along = [angle for angle in angles if angle.ratio]
    best = list[tuple[Angle, dict[int, Fitted]]]()
    for angle in angles:
        tried = {i: _fitted(turns, angle, along, i) for i in range(3)}
        found = {i: fit for i, fit in tried.items() if fit is not None and _log_odds(fit, angles) > 0}
        if found:
            best.append((angle, found))
    if not best:
        return (), ()
    angle, fits = max(best, key=lambda each: sum(_log_odds(fit, angles) for fit in each[1].values()))
    probability = odds.probability(max(_log_odds(fit, angles) for fit in fits.values()))
    return (_finding(turns, angle, fits, probability),), (_rms(turns, angle, along, fits),)


def _log_odds(fit: Fitted, angles: Sequence[Angle]) -> float:
    """Return ln of the odds of one of three sensors and some angles."""
    return odds.log_odds(fit.gain, 3 * len(angles))


def _turning(campaign: Campaign, turn: TurnRecord, scales: Scales) -> Iterator[Turning]:
    has_auxiliary = any(name.startswith(AUXILIARY) for name in turn.series.extra)
    if "gyroscope" not in scales or len(turn.series.starts) > 1 or not has_auxiliary:
        return
    channels = tuple(each for each in held_channels(turn, scales) if each.triad == "gyroscope")
    if len(channels) == 3:
        up = campaign.fixture.C_sb @ face_normal(face_of(turn.start_position))
        own = int(np.argmax(np.abs(up)))
        yield Turning(turn, channels, own, np.radians(np.cumsum(channels[own].rate) * turn.series.period))


def _angles(turns: Sequence[Turning]) -> Iterator[Angle]:
    names = [name for name in turns[0].record.series.extra if name.startswith(AUXILIARY)] if turns else []
    for name in names:
        values = [turn.record.series.extra.get(name) for turn in turns]
        known = [v for v in values if v is not None and np.isfinite(v).all() and np.ptp(v) > 0]
        if len(known) == len(turns) and (period := _period(known, turns)) is not None:
            unwrapped = tuple(np.unwrap(v, period=period) / period for v in known)
            yield Angle(name.removeprefix(AUXILIARY), period, unwrapped, _ratio(unwrapped, turns))


def _period(values: Sequence[FloatArray], turns: Sequence[Turning]) -> float | None:
    """Return where a channel wraps, or the full turn of one that goes on with psi; None of others."""
    steps = np.abs(np.concatenate([np.diff(v) for v in values]))
    span = max(float(v.max()) for v in values) - min(float(v.min()) for v in values)
    wraps = steps > WRAP_SHARE * span
    if MIN_WRAPS <= wraps.sum() < len(steps) / 8:
        found = max(float(np.median(steps[wraps]) + np.median(steps[~wraps])), span)
        return next((one for one in NATURAL if abs(found / one - 1) < NEAR_NATURAL), found)
    whole = (360.0, 2 * np.pi, 1.0)
    return next((one for one in whole if abs(abs(_ratio([v / one for v in values], turns)) - 1) < 0.01), None)


def _ratio(angles: Sequence[FloatArray], turns: Sequence[Turning]) -> float:
    """Return how often an angle [turns] turns in one of psi, zero where it does not go along."""
    psi = np.concatenate([turn.psi - turn.psi.mean() for turn in turns]) / (2 * np.pi)
    angle = np.concatenate([each - each.mean() for each in angles])
    ratio = float(psi @ angle / (psi @ psi))
    return ratio if np.std(angle - ratio * psi) < ALONG * np.std(angle) else 0.0


def _unexplained(
    turn: Turning, number: int, sensor: int, along: Sequence[Angle], columns: FloatArray
) -> FloatArray | None:
    """Return a sensor's rate and ``columns`` (n, k) less what is known, (n, 1 + k); None where the hand is not."""
    n, rate, turned = len(turn.psi), turn.channels[sensor].rate, turn.channels[turn.own].rate
    scaled = turned / np.max(np.abs(turned))
    known = [np.ones(n), np.linspace(-1, 1, n), np.cos(turn.psi), np.sin(turn.psi), scaled**2]
    if sensor == turn.own:
        if not along:
            return None
        angle = along[0].turns[number]
        whole = np.column_stack((angle, np.ones(n), np.arange(n)))
        factor = np.linalg.lstsq(whole, np.cumsum(rate), rcond=None)[0][0]
        rate = rate - factor * np.diff(angle, prepend=2 * angle[0] - angle[1])
    else:
        known.append(scaled)
    both, A = np.column_stack((rate, columns)), np.stack(known, axis=1)
    found: FloatArray = both - A @ np.linalg.lstsq(A, both, rcond=None)[0]
    return found


def _parts(
    turns: Sequence[Turning], angle: Angle, along: Sequence[Angle], sensor: int, harmonics: Sequence[int]
) -> Iterator[FloatArray]:
    """Yield of every block the sensor's rate and the angle's columns (m, 1 + k), less what is known."""
    # as many samples as a quarter turn of the highest harmonic takes
    together = int(np.clip(RESOLVED / (max(harmonics) * angle.step), 1, MIN_BLOCK // 4))
    size = max(sum(len(turn.psi) for turn in turns) // BLOCKS, MIN_BLOCK)
    for number, turn in enumerate(turns):
        powers = np.exp(2j * np.pi * angle.turns[number])[:, None] ** np.array(harmonics)
        columns = np.stack((powers.real, powers.imag), axis=2).reshape(len(powers), -1)
        left = _unexplained(turn, number, sensor, along, columns)
        if left is not None:
            blocks = max(len(left) // size, 1)
            whole = len(left) // together * together
            means = left[:whole].reshape(-1, together, left.shape[1]).mean(axis=1)
            yield from np.array_split(means, min(blocks, len(means)))


def _fitted(turns: Sequence[Turning], angle: Angle, along: Sequence[Angle], sensor: int) -> Fitted | None:
    """Return a sensor's fit at the likeliest number of harmonics."""
    fit: Fitted | None = None
    for most in HARMONICS:
        if not (harmonics := angle.harmonics(most)):
            continue
        parts = list(_parts(turns, angle, along, sensor, harmonics))
        if len(parts) < LEFT_OUT:
            break
        gram = np.array([part[:, 1:].T @ part[:, 1:] for part in parts])
        score = np.array([part[:, 1:].T @ part[:, :1] for part in parts])
        scores = Scores(gram, score, np.array([part[:, :1].T @ part[:, 0] for part in parts]))
        fit, _ = likeliest(scores, 0, sum(len(part) for part in parts))
        if fit is None or fit.order < max(order for order in ORDERS if order <= len(harmonics)):
            break
    return fit


def _finding(turns: Sequence[Turning], angle: Angle, fits: dict[int, Fitted], probability: float) -> Finding:
    names = [
        f"g{AXES[sensor]}.{part}{h}"
        for sensor, fit in fits.items()
        for h in angle.harmonics(HARMONICS[-1])[: fit.order]
        for part in ("cos", "sin")
    ]
    value = np.concatenate([fit.value for fit in fits.values()]) * DEG_H_PER_DEG_S
    std = np.concatenate([np.sqrt(np.diag(fit.covariance)) for fit in fits.values()]) * DEG_H_PER_DEG_S
    used = angle.harmonics(HARMONICS[-1])[: max(fit.order for fit in fits.values())]
    shape = f"period {angle.period:.6g} of {angle.name} while it turns, harmonics {', '.join(map(str, used))}"
    where: dict[str, object] = {"file": [turn.record.name for turn in turns][:3], "channel": angle.name}
    return Finding(
        "auxiliary.periodic", "procedure", tuple(names), value, std, "deg/h", where, probability,
        SEPARATE, shape, max(fit.share for fit in fits.values()),
    )  # fmt: skip


def _rms(turns: Sequence[Turning], angle: Angle, along: Sequence[Angle], fits: dict[int, Fitted]) -> ResidualRms:
    """Return the rms of the sensors that it acts on, less what is known, without it, with it, and left out."""
    found = list[tuple[float, float, float]]()
    for sensor, fit in fits.items():
        harmonics = angle.harmonics(HARMONICS[-1])[: fit.order]
        part = np.concatenate(list(_parts(turns, angle, along, sensor, harmonics)))
        before = float(np.mean(part[:, 0] ** 2))
        after = float(np.mean((part[:, 0] - part[:, 1 : 1 + len(fit.value)] @ fit.value) ** 2))
        found.append((before, after, before * (1 - fit.share)))
    before, after, left_out = DEG_H_PER_DEG_S * np.sqrt(np.mean(found, axis=0))
    name = "gyroscope samples while turning"
    return ResidualRms(name, "deg/h", float(before), float(after), float(before), float(left_out))
