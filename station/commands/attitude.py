"""``station attitude`` and ``tune``: roll and pitch along a log, and the complementary filter tuned on one."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from procedures.units import STANDARD_GRAVITY
from station.commands import Database
from station.commands._log_options import COLUMNS, LogOptions, print_inferred
from station.commands._options import Heading, Latitude, argument, flag, option, refused_as, write_result

if TYPE_CHECKING:
    from procedures.attitude.attitude_estimate import AttitudeEstimate
    from procedures.attitude.attitude_log import AttitudeLog
    from procedures.attitude.complementary_gains import ComplementaryGains


DIRECTIONS = ("forwards", "both")


def attitude(
    log: Annotated[Path, argument("LOG", "A log of rates and specific forces, or attitude-log/1.")],
    aid: Annotated[
        str | None,
        option(
            "AID",
            "none, airspeed, airspeed-filter, gnss, paper-airspeed, paper-airspeed-rate, paper-gnss "
            "or paper-filter. "
            "Without it: airspeed-filter, else gnss, else none.",
        ),
    ] = None,
    tau: Annotated[float | None, option("S", "Time constant of the complementary filter [s].")] = None,
    k1: Annotated[float | None, option("", "K1 of the complementary filter [1/s].")] = None,
    k2: Annotated[float | None, option("", "K2 of the complementary filter [1/s].")] = None,
    gravity: Annotated[float, option("M_S2", "", min=9.7, max=9.9)] = STANDARD_GRAVITY,
    latitude: Latitude = None,
    heading: Heading = None,
    gyro_bias_std: Annotated[
        float | None, option("DEG_H", "Standard uncertainty of the gyros' biases, if known.", min=1e-6)
    ] = None,
    accel_bias_std: Annotated[
        float | None,
        option(
            "UG",
            "Standard uncertainty of the accelerometers' biases, if known: the least uncertainty of the vertical.",
            min=1e-3,
            max=1e6,
        ),
    ] = None,
    gnss_latency: Annotated[float, option("S", "Latency of the velocities.", min=0, max=2)] = 0.0,
    direction: Annotated[
        str, option("WAY", "forwards, as online; both: forwards and backwards, for recordings.")
    ] = "forwards",
    out: Annotated[Path | None, option("OUT.csv", "Write roll, pitch and down vector here.")] = None,
    diagnose: Annotated[
        bool, flag("--diagnose", "Find the error terms that the model lacks, and correct them.")
    ] = False,
    json: Annotated[Path | None, option("OUT", "Write attitude/1 here instead of a summary.")] = None,
    axes: Annotated[
        str | None,
        option("F,R,D", "Sensor axes that point forward, right, down; x,-y,-z (z up), x,y,z of attitude-log/1."),
    ] = None,
    accel_convention: Annotated[
        str | None, option("WORD", "At rest +1 g points up (force) or down (gravity: as iOS).")
    ] = None,
    *,
    columns: Annotated[LogOptions, COLUMNS],
    db: Database = None,
) -> None:
    """Compute roll and pitch along a log of rates and specific forces.

    LOG is any table that `station diagnose` and `station noise` read: columns and units come from its header or
    from the options, and every inference is printed. A file with the header of attitude-log/1 may also hold an
    airspeed, a velocity, a heading and truth (docs/explanation/attitude.md).

    airspeed-filter and gnss are one Kalman filter of attitude, velocity and biases. none is the same filter
    without a velocity, or, with --tau or --k1 and --k2, the complementary filter. airspeed is the complementary
    filter with forward speed and remembered angle of attack. The paper- aids are the filter as printed (K1 0.08,
    K2 0.0125), for reproduction: with forward speed, with changes of airspeed or GNSS velocity, and with the
    velocity filter. Errors are given in deg if the log has truth.

    --direction both also runs the filter backwards from the end and uses the weighted mean of both: each row then
    also uses later data.

    --diagnose finds which error terms the model lacks. It uses the first 60 % of the log, and the residual between
    mixer and truth (without truth: between gyros and accelerometers). OUT.csv is then the corrected attitude, and
    the error before and after is that of the other 40 %.

    Exit code 2 if the log lacks what the aid needs; 3 if it cannot be read, its specific force has no gravity, or
    its rates do not match the axes and unit in which gravity rotates.

    Example: station attitude phone.csv --axes y,x,-z --out attitude.csv
    """
    gains = _gains(tau, k1, k2)
    if direction not in DIRECTIONS:
        raise typer.BadParameter(
            f"found {direction!r}, expected {' or '.join(DIRECTIONS)}", param_hint="--direction"
        )
    if diagnose and direction == "both":
        raise typer.BadParameter("found both with --diagnose, which is forwards only", param_hint="--direction")
    from station.files.atomic_file import refuse_own

    refuse_own((out, json), (log,))
    read = _read(log, columns, axes, accel_convention)
    from dataclasses import replace

    import numpy as np

    from procedures.units import RAD_S_PER_DEG_H
    from station.attitude.attitude_json import write_track

    chosen = _chosen_aid(aid, gains, read, log, is_both=direction == "both")
    if heading is not None and read.heading is None:
        given = np.full(len(read.t), np.nan)
        given[0] = np.radians(heading)
        read = replace(read, heading=given)
    if diagnose:
        track, document, text = _diagnosed(read, chosen, gains, gravity)
    else:
        known: dict[str, float | None] = {
            "gravity": gravity,
            "latitude": None if latitude is None else float(np.radians(latitude)),
            "gyro_bias_std": None if gyro_bias_std is None else gyro_bias_std * RAD_S_PER_DEG_H,
            "force_bias_std": None if accel_bias_std is None else accel_bias_std * 1e-6 * STANDARD_GRAVITY,
            "fix_latency": gnss_latency,
        }
        track, document, text = _estimated(read, chosen, gains, direction, known)
    if out is not None:
        write_track(out, read, track)
    write_result(document, text, json, f"attitude of {log}, attitude/1")
    if out is not None:
        typer.echo(f"{out}: roll, pitch and down vector of {log}")


def _chosen_aid(
    aid: str | None, gains: "ComplementaryGains | None", read: "AttitudeLog", log: Path, *, is_both: bool
) -> str:
    """Return the aid asked for or the best that the log allows; raise `typer.BadParameter` if it is impossible."""
    import numpy as np

    from procedures.attitude.attitude_estimate import AID_COLUMN, AIDS, default_aid, takes_gains
    from procedures.attitude.kalman.kalman_filter import AID_CODE

    chosen = aid or default_aid(read)
    if chosen not in AIDS:
        raise typer.BadParameter(f"found {chosen!r}, expected one of {', '.join(AIDS)}", param_hint="--aid")
    needed = getattr(read, AID_COLUMN[chosen]) if chosen in AID_COLUMN else read.omega_b
    if needed is None or not np.isfinite(needed).any():
        raise typer.BadParameter(f"{chosen} needs {AID_COLUMN[chosen]}, which {log} has not", param_hint="--aid")
    if gains is not None and not takes_gains(chosen):
        raise typer.BadParameter(
            f"{chosen} has no gains; they belong to the complementary filter", param_hint="--tau"
        )
    if gains is not None and gains.k1 * read.nominal > 1:
        found = f"K1 {gains.k1:g} with samples {read.nominal:g} s apart"
        raise typer.BadParameter(f"{found}, expected a product of at most 1", param_hint="--tau")
    if is_both and (gains is not None or chosen not in AID_CODE):
        found = f"{chosen} is the complementary filter, forwards only; both needs the Kalman filter"
        raise typer.BadParameter(f"{found}: {', '.join(AID_CODE)} without gains", param_hint="--direction")
    return chosen


def _diagnosed(
    read: "AttitudeLog", aid: str, gains: "ComplementaryGains | None", gravity: float
) -> "tuple[AttitudeEstimate, dict[str, Any], str]":
    """Return the corrected attitude with its document and text, after the diagnosis."""
    from procedures.attitude.attitude_diagnosis import diagnose_attitude
    from station.attitude.attitude_json import (
        attitude_diagnosis_document,
        attitude_diagnosis_text,
        attitude_document,
        attitude_text,
    )

    traced = diagnose_attitude(read, aid, gains, gravity)
    document = attitude_document(read, traced.track) | {"diagnosis": attitude_diagnosis_document(traced)}
    is_whole = not traced.findings or traced.corrected is read
    which = "the log as it is" if is_whole else "the log after correction"
    found = attitude_diagnosis_text(document["diagnosis"])
    return traced.track, document, f"{found}\n\nattitude of {which}:\n{attitude_text(read, document)}"


def _estimated(
    read: "AttitudeLog",
    aid: str,
    gains: "ComplementaryGains | None",
    direction: str,
    known: dict[str, float | None],
) -> "tuple[AttitudeEstimate, dict[str, Any], str]":
    """Return the attitude forwards or in both directions, with its document and text."""
    from functools import partial

    from procedures.attitude.attitude_estimate import estimate, estimate_both_directions
    from station.attitude.attitude_json import attitude_document, attitude_text

    run: Any = estimate_both_directions if direction == "both" else partial(estimate, gains=gains)
    track = run(read, aid, **known)
    document = attitude_document(read, track, direction)
    return track, document, attitude_text(read, document)


def _read(log: Path, options: LogOptions, axes: str | None, convention: str | None) -> "AttitudeLog":
    from station.attitude.general_log import CONVENTIONS, read_any_log
    from station.calibrated.output_frame import body_axes

    if convention is not None and convention not in CONVENTIONS:
        expected = f"found {convention!r}, expected {' or '.join(CONVENTIONS)}"
        raise typer.BadParameter(expected, param_hint="--accel-convention")
    with refused_as("--axes"):
        C = None if axes is None else body_axes(axes)
    read = read_any_log(log, options.columns() if options.given else None, C, convention)
    print_inferred(read.guesses, read.notes)
    return read.log


def _gains(tau: float | None, k1: float | None, k2: float | None) -> "ComplementaryGains | None":
    if tau is not None and (k1 is not None or k2 is not None):
        raise typer.BadParameter("give --tau, or --k1 and --k2, not both", param_hint="--tau")
    if (k1 is None) != (k2 is None):
        raise typer.BadParameter("give both --k1 and --k2", param_hint="--k1")
    from procedures.attitude.complementary_gains import ComplementaryGains

    with refused_as("--k1" if tau is None else "--tau"):
        if tau is not None:
            return ComplementaryGains.of_time_constant(tau)
        return None if k1 is None or k2 is None else ComplementaryGains(k1, k2)


def tune(
    log: Annotated[Path, argument("LOG", "A CSV file of attitude-log/1 with truth.")],
    aid: Annotated[str, option("AID", "none, airspeed or a paper- aid of `station attitude`.")] = "none",
    gains: Annotated[bool, flag("--gains", "Search K1 and K2 separately instead of one time constant.")] = False,
    gravity: Annotated[float, option("M_S2", "", min=9.7, max=9.9)] = STANDARD_GRAVITY,
    json: Annotated[Path | None, option("OUT", "Write tuning/1 here instead of the curve.")] = None,
    db: Database = None,
) -> None:
    """Choose the complementary filter's time constant [s] or gains [1/s] by cross-validation; show the curve.

    The filter runs over the log with every candidate; its inclination error against the log's truth is computed
    over scored rows. Each fifth of the rows is evaluated with the candidate that the other four choose.

    Exit code 3 if the log breaks a rule of attitude-log/1, 5 if it has no truth.

    Example: station tune drive.csv --aid airspeed
    """
    from procedures.attitude.attitude_estimate import AID_COLUMN, AIDS, takes_gains
    from station.attitude.attitude_log import read_log
    from station.files.atomic_file import refuse_own

    refuse_own((json,), (log,))
    lawful = [name for name in AIDS if takes_gains(name)]
    if aid not in lawful:
        raise typer.BadParameter(f"found {aid!r}, expected one of {', '.join(lawful)}", param_hint="--aid")
    read = read_log(log)
    if aid in AID_COLUMN and getattr(read, AID_COLUMN[aid]) is None:
        raise typer.BadParameter(f"{aid} needs {AID_COLUMN[aid]}, which {log} has not", param_hint="--aid")
    from procedures.attitude.gain_tuning import grid_of_gains, grid_of_taus
    from procedures.attitude.gain_tuning import tune as search
    from station.attitude.attitude_json import tuning_document, tuning_text

    found = search(read, aid, grid_of_gains() if gains else grid_of_taus(), gravity)
    document = tuning_document(found, aid, by_tau=not gains)
    write_result(document, tuning_text(document), json, f"gains for {log}, tuning/1")
