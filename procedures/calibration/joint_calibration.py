"""From campaigns to a solution: both triads, the bench, the residual, and what stayed open."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.bench.position_checks import heading_warnings, refuse_wrong_faces
from procedures.bench.sign_errors import backward_gyroscopes, sign_warnings
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.calibration.residuals import (
    chi2_by_part,
    fit_quality,
    p_value_of,
    step_residuals,
    turn_on_warnings,
)
from procedures.calibration.solution_values import (
    DOUBTFUL_P_VALUE,
    Estimate,
    FitQuality,
    Solution,
    TriadCalibration,
)
from procedures.calibration.triad_calibration import (
    TriadVector,
    moves_vector,
    paper_biases,
    triad_vector,
    with_clock,
)
from procedures.calibration.undetectable_tilt import (
    UndetectableTilt,
    undetectable_tilt_warnings,
    undetectable_tilts,
)
from procedures.campaign.campaign import Campaign, RestRecord, period_std
from procedures.campaign.observations import (
    TriadDwells,
)
from procedures.errors import NotObservable
from procedures.frames import AXES
from procedures.free_positions.free_attitude_fit import solve_with_rests, why_not_by_rests, with_known_faces
from procedures.free_positions.gyroscopes_from_moves import MovesFit, SegmentedSequence, solve_moves
from procedures.twelve_positions.accelerometer_fit import TriadFit, missing_positions, solve_accelerometer
from procedures.twelve_positions.bench_parameters import tilt_names
from procedures.twelve_positions.gyroscope_fit import (
    GyroscopeFit,
    clock_on_accelerometer,
    clock_on_moves,
    measured_latitude,
    solve_gyroscope,
)
from procedures.twelve_positions.rotation_tilt import rotation_tilts
from procedures.units import RAD_PER_ARCSEC

NEVER_EXCITED = ("accelerometer.cross_product", "accelerometer.cubic (with accelerometer.scale_factor)")
FREE_FRAME = (
    "rotation of the frame (no face known; E of the accelerometers is lower triangular: x along sensor x, "
    "y in the plane of sensors x and y)"
)
COMMON_SHARES_TRIED = (1.0, 0.999, 0.99, 0.97, 0.9, 0.7, 0.0)  # of what the triads have in common, tried in turn
EIGENVALUE_ROUNDING = 1e-9  # of a correlation matrix's least eigenvalue
FEW_RESTS = 13  # in attitudes of their own, below which nine numbers leave hardly a degree of freedom


@dataclass(frozen=True, slots=True, eq=False)
class CampaignFits:
    """What was seen and fitted of both triads; None where a triad is absent or not determined.

    ``left_out`` says which channels were dead, and where.

    The gyroscopes' fit is that of turns, ``gyroscope``, or where there is none that of ``moves``.
    """

    campaigns: tuple[Campaign, ...]
    accel: TriadDwells | None
    gyro: TriadDwells | None
    accelerometer: TriadFit | None
    gyroscope: GyroscopeFit | None
    rests: tuple[tuple[int, RestRecord], ...] = ()
    segmented: tuple[SegmentedSequence, ...] = ()
    moves: MovesFit | None = None
    left_out: tuple[str, ...] = ()


def solve(campaigns: Sequence[Campaign]) -> Solution:
    """Solve one unit's campaigns jointly.

    Raises
    ------
    NotObservable
        If neither triad can be solved.
    WrongFace, WrongMounting
        If the accelerometers contradict a dwell's position, or the way the IMU sits in the cube.
    """
    return report(fit(campaigns))


def fit(campaigns: Sequence[Campaign], known: CampaignFits | None = None) -> CampaignFits:
    """Reduce the steps and fit both triads, by the dwells' rates that are ``known``; raises as `solve`."""
    rates = (None, None) if known is None else (known.accel, known.gyro)
    return fit_reduced(reduce_steps(campaigns, *rates))


def fit_reduced(steps: ReducedSteps) -> CampaignFits:
    """Fit both triads to what the steps say; raises as `solve`."""
    campaigns, accel, gyro, rests = steps.campaigns, steps.accel, steps.gyro, steps.rests
    if labelled := with_known_faces(accel, rests):
        refuse_wrong_faces(labelled, [campaign.fixture.C_sb for campaign in campaigns])
    if rests is not None:
        accelerometer = solve_with_rests(campaigns, accel, rests)
    else:
        accelerometer = solve_accelerometer(campaigns, accel) if accel is not None else None
    gyroscope = None
    if gyro is not None:
        tilts = rotation_tilts(campaigns, steps.turns, steps.turn_rests, accel, accelerometer)
        gyroscope = solve_gyroscope(campaigns, gyro, steps.turns, accelerometer, tilts)
    moves = None
    if gyroscope is None and accelerometer is not None:
        moves = solve_moves(campaigns, steps.segmented, accelerometer)
    if accelerometer is None and gyroscope is None:
        missing = missing_positions(accel or gyro) or ["turns about x, y and z, or a channel that responds"]
        if steps.others:
            missing = why_not_by_rests(campaigns, accel, rests).missing
        if steps.left_out:
            dead = f"a channel that responds ({'; '.join(steps.left_out)})"
            missing = [dead] if accel is None and gyro is None else [*missing, dead]
        raise NotObservable("the scale factor and bias of either triad", missing)
    return CampaignFits(
        campaigns, accel, gyro, accelerometer, gyroscope, steps.others, steps.segmented, moves, steps.left_out
    )  # fmt: skip


def report(fits: CampaignFits) -> Solution:
    """Put the fits into one solution."""
    counts = fits.campaigns[0].counts
    quality = fit_quality(fits.accelerometer, fits.gyroscope.joint if fits.gyroscope else None, fits.moves)
    accel = triad_vector(fits.accelerometer, "accelerometer", fits.accelerometer) if fits.accelerometer else None
    gyro = triad_vector(fits.gyroscope.joint, "gyroscope", fits.accelerometer) if fits.gyroscope else None
    if fits.moves is not None and fits.accelerometer is not None:
        gyro = moves_vector(fits.moves, fits.accelerometer)
    if (std := period_std(fits.campaigns)) > 0:
        accel = accel and with_clock(accel, clock_on_accelerometer(accel.value, counts), std)
        gyro = gyro and with_clock(gyro, clock_on_moves(gyro.value, counts), std)
    on_bench = fits.accelerometer is not None and not fits.accelerometer.is_turned_freely
    slab, parallelism = _bench(fits.accelerometer) if on_bench and fits.accelerometer else (None, None)
    tilts = undetectable_tilts_of(fits, quality)
    names, covariance = joint_covariance(fits, accel, gyro)
    stood, sure = heading_warnings(fits.campaigns, fits.gyroscope.joint) if fits.gyroscope else ([], [])
    return Solution(
        accelerometer=_accelerometer(accel, fits) if accel else None,
        gyroscope=gyro.calibration(counts) if gyro else None,
        slab_tilt=slab, parallelism=parallelism, quality=quality, names=names, covariance=covariance,
        reference_temperature=_mean_temperature(fits),
        residuals=step_residuals(fits.accelerometer, fits.gyroscope),
        not_observable=_not_observable(fits), warnings=(*_warnings(fits, quality, tilts), *stood),
        unused_steps=_unused(fits), turned_off=tuple(sure), undetectable_tilts=tilts,
    )  # fmt: skip


def undetectable_tilts_of(
    fits: CampaignFits, quality: FitQuality, tilted: Collection[tuple[int, str]] = ()
) -> tuple[UndetectableTilt, ...]:
    """Return what tilts would not show in the dwells but those ``tilted``, by campaign's number and name."""
    if fits.accelerometer is None or fits.accelerometer.is_turned_freely:
        return ()
    return undetectable_tilts(fits.accelerometer, fits.gyroscope, quality.noticed_sigmas, tilted)


def joint_covariance(
    fits: CampaignFits, accel: TriadVector | None, gyro: TriadVector | None
) -> tuple[tuple[str, ...], FloatArray]:
    """Return n names and covariance (n, n), in the units of `Solution`: accelerometer, slab, faces, gyroscope.

    The triads meet in the tilts alone: the gyroscopes took them from the accelerometers, so what the two have in
    common is the gyroscopes' regression on the tilts times the tilts' covariance with the rest.
    """
    names: tuple[str, ...] = ()
    blocks, tilts, own_K = np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0))
    if accel is not None and fits.accelerometer is not None:
        joint = fits.accelerometer
        index, bench_names = _bench_index(joint)
        names = (*accel.names, *bench_names)
        J = np.zeros((len(names), len(joint.fit.x)))
        J[:15] = accel.jacobian
        J[np.arange(15, len(names)), index] = 1.0
        blocks = J @ joint.fit.covariance @ J.T
        blocks[:15, :15] = accel.covariance
        tilts = joint.fit.covariance[12 : 12 + joint.bench.shared] @ J.T
        own_K = joint.fit.covariance[:12] @ J.T
    if gyro is not None and fits.moves is not None:
        common = gyro.jacobian @ fits.moves.by_accelerometer @ own_K
        return (*names, *gyro.names), np.block([[blocks, common.T], [common, gyro.covariance]])
    if gyro is None or fits.gyroscope is None:
        return names, blocks
    if not names:
        return gyro.names, gyro.covariance
    own = fits.gyroscope.joint.fit.covariance
    shared = slice(12, 12 + len(tilts))
    given = own[shared, shared]
    if fits.accelerometer is not None and fits.accelerometer.bench.skew_known():  # gyroscopes may see it
        given = fits.accelerometer.fit.covariance[shared, shared]
    regression = gyro.jacobian @ own[:, shared] @ np.linalg.pinv(given, hermitian=True)
    return (*names, *gyro.names), _joined(blocks, regression @ tilts, gyro.covariance)


def _joined(first: FloatArray, common: FloatArray, second: FloatArray) -> FloatArray:
    """Return both covariances in one; ``common`` (n2, n1) gives way where they do not leave room for all of it.

    The tilts' covariance is not to the last digit the same in both fits, and the second holds more than came
    through them: taken as it is, a correlation could come out a thousandth beyond one.
    """
    size = np.sqrt(np.concatenate((np.diag(first), np.diag(second))))
    for share in COMMON_SHARES_TRIED:
        whole: FloatArray = np.block([[first, share * common.T], [share * common, second]])
        correlation = whole / np.where(size > 0, size, 1.0) / np.where(size > 0, size, 1.0)[:, None]
        if np.linalg.eigvalsh(correlation)[0] > -EIGENVALUE_ROUNDING:
            break
    return whole


def _bench_index(joint: TriadFit) -> tuple[IntArray, tuple[str, ...]]:
    """Where slab tilt (2) and parallelism (6) of the first campaign stand in the fit, and their names."""
    if joint.is_turned_freely:
        return np.zeros(0, dtype=np.int64), ()
    first = joint.bench.placements[0].cube if joint.bench.placements else 0
    cube = 12 + joint.bench.cube_slice(first).start
    names = ("slab.tilt.east", "slab.tilt.north", *(f"fixture.parallelism.{n}" for n in tilt_names()))
    return np.array([12, 13, *range(cube, cube + 6)]), names


def _bench(joint: TriadFit) -> tuple[Estimate, Estimate]:
    """Slab tilt of the first campaign and parallelism of its cube, as the accelerometers found them."""
    index, _ = _bench_index(joint)
    value, std = joint.fit.x[index], np.sqrt(np.diag(joint.fit.covariance)[index])
    parallelism = Estimate(value[2:].reshape(3, 2), std[2:].reshape(3, 2), "rad")
    return Estimate(value[:2], std[:2], "rad"), parallelism


def _accelerometer(vector: TriadVector, fits: CampaignFits) -> TriadCalibration:
    assert fits.accelerometer is not None
    twelve, two = paper_biases(fits.accelerometer)
    calibration = vector.calibration(fits.campaigns[0].counts)
    return replace(calibration, bias_12_position=twelve, bias_two_direction=two)


def _mean_temperature(fits: CampaignFits) -> float | None:
    dwells = [d.series.temperature for c in fits.campaigns for d in c.dwells]
    values = np.concatenate([*dwells, *(rest.series.temperature for _, rest in fits.rests), np.zeros(0)])
    values = values[np.isfinite(values)]
    return float(values.mean()) if len(values) else None


def _not_observable(fits: CampaignFits) -> tuple[str, ...]:
    found = []
    for triad, solved in (("accelerometer", fits.accelerometer), ("gyroscope", fits.gyroscope or fits.moves)):
        if solved is None:
            found += [f"{triad}.{part}" for part in ("scale_factor", "misalignment", "bias")]
    if fits.accelerometer is not None:
        moves_show_skew = fits.gyroscope is not None and fits.gyroscope.moves is not None
        found += _left_open(fits.accelerometer, moves_show_skew)
    return tuple(found)


def _left_open(accelerometer: TriadFit, moves_show_skew: bool) -> list[str]:
    """Name what the accelerometers' steps do not show, in addition to parameters of a triad that was left out.

    Moves between placements show a cube's skew to the gyroscopes; the cube's turning as a whole stays open.
    """
    bench = accelerometer.bench
    if accelerometer.is_turned_freely:
        assumed = accelerometer.rests.assumed if accelerometer.rests is not None else ()
        return [FREE_FRAME, *(f"accelerometer.{name} (the rests are too close to the faces)" for name in assumed)]
    held = [axis for axis, it_is in zip(AXES, bench.held_pairs(0), strict=True) if it_is]
    found = [f"fixture.perpendicularity.{n} (with misalignment)" for n in tilt_names() if n[0] in held]
    if bench.skew_known() or moves_show_skew:
        pairs = [(a, c) for a, c in ("xy", "xz", "yz") if a in held and c in held]
        found = [f"fixture.perpendicularity.{a}.{c} less {c}.{a} (with misalignment)" for a, c in pairs]
    if bench.skew_seen:
        return found
    if held:
        found.append("accelerometer.quadratic (with accelerometer.bias and fixture.parallelism)")
    return [*found, *NEVER_EXCITED]


def _warnings(fits: CampaignFits, quality: FitQuality, tilts: Sequence[UndetectableTilt]) -> tuple[str, ...]:
    found = list(fits.left_out)
    if quality.p_value < DOUBTFUL_P_VALUE:
        found.append(_excess(fits, quality))
    if fits.accel is not None and fits.accelerometer is None:
        found.append(f"accelerometer not solved: {_why_not(fits.accel)}")
    if (joint := fits.accelerometer) is not None and joint.is_turned_freely and len(fits.rests) < FEW_RESTS:
        numbers = 9 - len(joint.rests.assumed if joint.rests is not None else ())
        found.append(
            f"accelerometer: {len(fits.rests)} rests determine {numbers} parameters: the residual can hardly test "
            f"them, and a small one proves nothing; record {FEW_RESTS} attitudes or more"
        )
    if fits.gyro is not None and fits.gyroscope is None and fits.moves is None:
        lacking = [a for a in AXES if not any(t.axis == a for c in fits.campaigns for t in c.turns)]
        what = (
            f"no turn about {', '.join(lacking)}" if lacking else "a channel is dead, or rotations were not used"
        )
        found.append(f"gyroscope not solved: its scale factor is unknown ({what})")
    found += sign_warnings(fits.campaigns, fits.accelerometer, fits.gyroscope, fits.gyro)
    if fits.moves is not None and fits.accelerometer is not None:
        is_free = fits.accelerometer.is_turned_freely
        found += backward_gyroscopes(fits.moves.K, is_turned_freely=is_free)
    found += [f"{each.record.name}: no rest found in it" for each in fits.segmented if not each.rests]
    if fits.gyroscope is not None:
        found += _turn_warnings(fits.gyroscope)
        found += _site_warnings(fits.gyroscope)
    found += undetectable_tilt_warnings(tilts)
    return (*found, *turn_on_warnings(fits.campaigns, fits.accelerometer, fits.gyroscope), *_few_counts(fits))


def _why_not(accel: TriadDwells) -> str:
    missing = missing_positions(accel)
    return f"missing {', '.join(missing)}" if missing else "a channel does not respond to gravity"


def _excess(fits: CampaignFits, quality: FitQuality) -> str:
    """Return whose residuals exceed counting noise, as far as one of the parts alone shows it."""
    gyroscope = fits.gyroscope.joint if fits.gyroscope else None
    parts = chi2_by_part(fits.accelerometer, gyroscope, fits.moves)
    beyond = {name: each for name, each in parts.items() if p_value_of(*each) < DOUBTFUL_P_VALUE}
    is_of_some = 0 < len(beyond) < len(parts)
    chi2, dof = map(sum, zip(*beyond.values(), strict=True)) if is_of_some else (quality.chi2, quality.dof)
    whose = f" of the {' and '.join(beyond)}" if is_of_some else ""
    return (
        f"residuals{whose} exceed counting noise (chi-square {chi2:.4g} at {dof} degrees of freedom): "
        f"{'their' if whose else 'the'} uncertainties are too small; run `station diagnose`"
    )


def _turn_warnings(gyroscope: GyroscopeFit) -> list[str]:
    found = [f"{name}: samples were lost during the rotation; it is not used" for name in gyroscope.broken]
    found += gyroscope.moves.moves.left_out if gyroscope.moves else []
    for turn, shape in zip(gyroscope.turns, gyroscope.geometry, strict=True):
        if shape.open_ends:
            taken = np.degrees(shape.closure_std)
            found.append(
                f"{turn.record.name}: less than 2 s of rest at an end; its closure error is assumed to be "
                f"{taken:.2g} deg"
            )
    for turn, tilt in zip(gyroscope.turns, gyroscope.tilts, strict=True):
        if tilt is not None and tilt.is_off:
            off, left = (float(np.linalg.norm(each)) / RAD_PER_ARCSEC for each in (tilt.mean, tilt.axis_std))
            found.append(
                f"{turn.record.name}: the cube tilted by {off:.0f} arcsec during the rotation: its axis is known "
                f"only to {left:.0f} arcsec; lift it, wipe cube and plate, and rotate again"
            )
    return found


def _site_warnings(gyroscope: GyroscopeFit) -> list[str]:
    seen = measured_latitude(gyroscope)
    if seen is None or not seen.contradicts:
        return []
    value, std, stated = np.degrees([seen.value, seen.std, seen.stated])
    return [
        f"the gyroscopes measure the Earth's rate of latitude {value:.1f} deg (u = {std:.2g}), but latitude "
        f"{stated:.2f} deg is stated, {seen.sigmas:.0f} u away: check the latitude, the time base and the "
        "headings of the positions"
    ]


def _few_counts(fits: CampaignFits) -> list[str]:
    found = []
    for triad, seen in (("accelerometer", fits.accel), ("gyroscope", fits.gyro)):
        for (_, dwell), row in zip(seen.dwells, seen.estimates, strict=True) if seen else ():
            for axis, estimate in zip(AXES, row, strict=True):
                if estimate.interval is not None:
                    low, high = estimate.interval
                    found.append(
                        f"{dwell.name}: {triad} {axis} shows {'one' if estimate.edges else 'no'} count edge; "
                        f"its rate is only known to lie in [{low:.3g}, {high:.3g}] count/s"
                    )
    return found


def _unused(fits: CampaignFits) -> tuple[str, ...]:
    rests = [rest.name for c in fits.campaigns for rest in c.rests] if fits.accelerometer is None else []
    rests += [each.record.name for each in fits.segmented if fits.accelerometer is None or not each.rests]
    if fits.gyroscope is None:
        return (*rests, *(turn.name for campaign in fits.campaigns for turn in campaign.turns))
    return (*rests, *fits.gyroscope.broken)
