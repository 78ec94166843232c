"""``placement.label``: dwells recorded under a position in which the cube did not stand.

The accelerometers show the face. An affine fit of raw outputs to nominal up vectors is drawn through four dwells
at a time (random sample consensus, Fischler and Bolles 1981); the one that most dwells agree with decides, and
every dwell that contradicts it is moved to the face that fits it. Tilts, seatings and K2 are hundreds of times
smaller. The gyroscopes show which of its face's two positions it was, or that their bias jumped in that dwell
(`procedures.anomalies.dwell_headings`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.anomalies.dwell_headings import HeadingLikelihood, scale_factors_from_turns
from procedures.arrays import BoolArray, FloatArray
from procedures.bench.sign_errors import earth_signs, reversed_axes
from procedures.campaign.campaign import Campaign, DwellRecord, TurnRecord
from procedures.campaign.observations import channel
from procedures.counts.dwell_means import estimate_rates
from procedures.counts.sample_records import CountSeries
from procedures.frames import AXES
from procedures.gyrocompass import first_position
from procedures.inference import odds
from procedures.inference.priors import ESTABLISHED, NEGLIGIBLE, PRESENT
from procedures.inference.result import CERTAIN, EffectTest, Finding
from procedures.positions import FACES, POSITIONS, face_normal, face_of

EFFECT, JUMP = "placement.label", "gyroscope.jump"
SEED, DRAWS = 20181218, 400  # of the sample consensus: always the same
MAX_RESIDUAL_G = 0.2  # g, as in `procedures.bench.position_checks`: far above any tilt, far below a wrong face
MIN_AGREEING_SHARE = 0.5  # of the dwells that must agree
MIN_DWELLS = 5  # dwells: four are fitted by anything
SCATTER_G = 0.04  # g, 1 sigma of what tilts, bias and scale could be together: a wrong face is 25 times as far off


@dataclass(frozen=True, slots=True, eq=False)
class _Dwells:
    """All dwells of one campaign: raw rates (n, 3) of both triads and 1 sigma, nan where a triad is absent."""

    records: tuple[DwellRecord, ...]
    accel: FloatArray
    gyro: FloatArray
    gyro_std: FloatArray


@dataclass(frozen=True, slots=True)
class Mislabelled:
    """A dwell (by number) that truly stood in ``position``, and ln of the odds that its label is wrong.

    ``is_heading_known`` says whether the data separate the position from its face's other one, ``jump`` how
    probable it is that the label is right and a bias jumped.
    """

    campaign: int
    dwell: int
    position: int
    log_odds: float
    is_heading_known: bool
    jump: float = 0.0


def label_findings(
    campaigns: Sequence[Campaign], found: Sequence[Mislabelled]
) -> tuple[tuple[Finding, ...], tuple[EffectTest, ...]]:
    """Return the findings of dwells that are `find_wrong_labels`, and the test made of the worst."""
    if not any(campaign.dwells for campaign in campaigns):
        return (), ()
    dwells = sum(len(campaign.dwells) for campaign in campaigns)
    worst = max((each.log_odds for each in found), default=_log_odds(0.0, dwells))
    return tuple(_finding(campaigns, each) for each in found), (EffectTest(EFFECT, worst),)


def with_true_labels(campaigns: Sequence[Campaign], found: Sequence[Mislabelled]) -> tuple[Campaign, ...]:
    """Return the campaigns with every mislabelled dwell in the position where it stood."""
    corrected = list(campaigns)
    for each in found:
        campaign = corrected[each.campaign]
        dwells = list(campaign.dwells)
        dwells[each.dwell] = replace(dwells[each.dwell], position=each.position)
        corrected[each.campaign] = replace(campaign, dwells=tuple(dwells))
    return tuple(corrected)


def find_wrong_labels(campaigns: Sequence[Campaign]) -> list[Mislabelled]:
    """Find the wrong labels of each campaign by itself."""
    found = list[Mislabelled]()
    for number, campaign in enumerate(campaigns):
        if not campaign.dwells:
            continue
        dwells = _rates(campaign)
        if (faces := _faces(campaign, dwells)) is not None:
            found += _headings(number, campaign, dwells, *faces)
    return found


def _finding(campaigns: Sequence[Campaign], each: Mislabelled) -> Finding:
    record = campaigns[each.campaign].dwells[each.dwell]
    where = {"position": record.position, "file": record.name}
    std = 0.0 if each.is_heading_known else 1.0  # a face's two positions are neighbours
    label = odds.probability(each.log_odds)
    shares = {EFFECT: label, JUMP: each.jump} if each.jump >= NEGLIGIBLE else {}
    return Finding(
        EFFECT, "procedure", ("actual",), np.array([float(each.position)]), np.array([std]), "position", where,
        label, "the dwell again, in the position it was asked for", shares=shares,
        aliases=tuple(name for name in shares if name != EFFECT),
        joint=min(sum(shares.values()), 1.0) if shares else None,
    )  # fmt: skip


def _log_odds(gain: float, dwells: int) -> float:
    """Return ln of the odds of another position of one of some dwells."""
    return odds.log_odds(gain, (len(POSITIONS) - 1) * dwells)


def _rates(campaign: Campaign) -> _Dwells:
    parts = [triad_rates(campaign.dwells, triad) for triad in ("accelerometer", "gyroscope")]
    return _Dwells(campaign.dwells, parts[0][0], *parts[1])


def triad_rates(dwells: Sequence[DwellRecord], triad: str) -> tuple[FloatArray, FloatArray]:
    """Return mean output (n, 3) per second (or of a rate) and its 1 sigma."""
    rate, std = np.full((2, len(dwells), 3), np.nan)
    here = [i for i, d in enumerate(dwells) if channel(d.series, triad) is not None and len(d.series) > 1]
    for axis in range(3):
        values = [np.asarray(channel(dwells[i].series, triad))[:, axis].astype(float) for i in here]
        for i, estimate in zip(here, estimate_rates(values, 1.0) if here else (), strict=True):
            series = dwells[i].series
            per = 1 / series.period if isinstance(series, CountSeries) else 1.0
            rate[i, axis], std[i, axis] = estimate.rate * per, estimate.std * per
    return rate, std


def _up(campaign: Campaign, faces: Sequence[str]) -> FloatArray:
    return np.stack([campaign.fixture.C_sb @ face_normal(face) for face in faces])


def _faces(campaign: Campaign, dwells: _Dwells) -> tuple[list[str], FloatArray] | None:
    """Return the face on which every dwell stood, the recorded one where nothing else fits; None if undecided.

    With them come the gains (n,) over the faces as recorded.
    """
    named, gains = [face_of(d.position) for d in dwells.records], np.zeros(len(dwells.records))
    seen = np.flatnonzero(np.all(np.isfinite(dwells.accel), axis=1))
    if len(seen) < MIN_DWELLS:
        return named, gains
    design = np.hstack((_up(campaign, [named[i] for i in seen]), np.ones((len(seen), 1))))
    rate = dwells.accel[seen]
    agrees = _consensus(design, rate)
    if agrees is None:
        return None
    solution, *_ = np.linalg.lstsq(design[agrees], rate[agrees], rcond=None)
    per_face = np.hstack((_up(campaign, FACES), np.ones((len(FACES), 1)))) @ solution
    k = np.linalg.norm(solution[:3], axis=0)
    off = np.max(np.abs(rate[:, None] - per_face) / k, axis=2)
    found = list(named)
    for row, i in enumerate(seen):
        if not agrees[row] and off[row].min() < MAX_RESIDUAL_G:
            found[i] = FACES[int(np.argmin(off[row]))]
            gains[i] = (off[row, FACES.index(named[i])] ** 2 - off[row].min() ** 2) / (2 * SCATTER_G**2)
    return found, gains


def _consensus(design: FloatArray, rate: FloatArray) -> BoolArray | None:
    """Mark the dwells of the largest set that one affine map takes to their outputs; None if it is no majority.

    Of two explanations that as many support, the one without a sensor that counts backwards is taken.
    """
    rng, n = np.random.default_rng(SEED), len(design)
    best, most = np.zeros(n, dtype=bool), 0.0
    for _ in range(DRAWS):
        rows = rng.choice(n, 4, replace=False)
        if abs(np.linalg.det(design[rows])) < 0.5:  # whole numbers: four faces that span, or not
            continue
        solution = np.linalg.solve(design[rows], rate[rows])
        k = np.linalg.norm(solution[:3], axis=0)
        if np.any(k < 0.5 * k.max()) or k.max() == 0:
            continue
        agrees = np.max(np.abs(rate - design @ solution) / k, axis=1) < MAX_RESIDUAL_G
        score = float(agrees.sum()) + 0.5 * bool(np.all(np.diag(solution[:3]) > 0))
        if score > most:
            best, most = agrees, score
        if most > n:
            break
    return best if best.sum() >= MIN_DWELLS and best.mean() > MIN_AGREEING_SHARE else None


def _headings(
    number: int, campaign: Campaign, dwells: _Dwells, faces: Sequence[str], gains: FloatArray
) -> Iterator[Mislabelled]:
    """Yield every dwell that is not where it says; ``gains`` (n,) are those of another face."""
    named = [d.position for d in dwells.records]
    moved = [i for i, position in enumerate(named) if face_of(position) != faces[i]]
    start = [_nearest(dwells, faces, moved, i) if i in moved else named[i] for i in range(len(named))]
    compass = HeadingLikelihood.of(campaign, dwells.gyro, dwells.gyro_std, start)
    positions, margins = (start, np.zeros(len(start))) if compass is None else compass.best(start)
    for i, position in enumerate(positions):
        if i in moved:
            is_sure = odds.probability(float(margins[i])) >= ESTABLISHED
            of_face = _log_odds(float(gains[i]), len(start))
            yield Mislabelled(number, i, position if is_sure else start[i], of_face, is_sure)
        elif position != named[i] and compass is not None:
            jump = odds.log_odds(compass.gain_of_jump(named, positions, i), len(start))
            label = _log_odds(float(margins[i]), len(start))
            shares = odds.shares({EFFECT: label, JUMP: jump})
            if shares[EFFECT] >= PRESENT:
                over = label - float(np.logaddexp(0.0, jump))
                yield Mislabelled(number, i, position, over, True, shares[JUMP])


def _nearest(dwells: _Dwells, faces: Sequence[str], moved: Sequence[int], i: int) -> int:
    """Return the position of the dwell on its face that dwell ``i`` is most like: the slab's tilt tells."""
    same = [j for j, face in enumerate(faces) if face == faces[i] and j not in moved]
    if not same:
        return first_position(faces[i])
    off = np.linalg.norm(dwells.accel[same] - dwells.accel[i], axis=1)
    return dwells.records[same[int(np.argmin(off))]].position


OPPOSITE = {"+": "-", "-": "+"}


def with_true_directions(campaigns: Sequence[Campaign]) -> tuple[tuple[Campaign, ...], tuple[Finding, ...]]:
    """Return the campaigns with the turns that are wrongly labelled for certain turned round, and the findings."""
    corrected, findings = list[Campaign](), list[Finding]()
    for campaign in campaigns:
        axes = _wrong_axes(campaign)
        wrong = [turn for turn in campaign.turns if turn.axis in axes]
        turns = tuple(_other_way(turn) if turn in wrong else turn for turn in campaign.turns)
        corrected.append(replace(campaign, turns=turns) if wrong else campaign)
        findings += [_turn_finding([turn.name for turn in wrong])] if wrong else []
    return tuple(corrected), tuple(findings)


def _wrong_axes(campaign: Campaign) -> str:
    K = scale_factors_from_turns(campaign)
    if K is None or not np.all(np.linalg.norm(K, axis=1) > 0):
        return ""
    rate, std = triad_rates(campaign.dwells, "gyroscope")
    seen = np.flatnonzero(np.all(np.isfinite(rate) & np.isfinite(std), axis=1))
    dwells = [(0, campaign.dwells[i].position) for i in seen.tolist()]
    signs = earth_signs([campaign], dwells, rate[seen], std[seen], K)
    marked = reversed_axes(K, signs, campaign.fixture.C_sb)
    return "".join(axis for axis, it_is in zip(AXES, marked, strict=True) if it_is)


def _other_way(turn: TurnRecord) -> TurnRecord:
    return replace(turn, direction=OPPOSITE[turn.direction])


def _turn_finding(names: Sequence[str]) -> Finding:
    return Finding(
        EFFECT, "procedure", ("direction",), np.array([-1.0]), np.array([0.0]), "direction", {"file": list(names)},
        CERTAIN, "the turns again, in the direction they are asked for",
    )  # fmt: skip
