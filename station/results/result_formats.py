"""The result files: which command writes each, and what each of its keys holds.

`docs/generate.py` makes the reference page of these tables. All results are JSON in UTF-8 without NaN or Infinity.
A key whose value is not known is absent, never zero. Readers should ignore keys that they do not know.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from types import MappingProxyType
from typing import Any

IS_KEY = MappingProxyType({"is_key": True})  # metadata of a field that is the key under which its value stands
IS_NULLABLE = MappingProxyType({"is_nullable": True})  # metadata of a field that is null where it is None


def document_of(result: Any) -> Any:
    """Return a typed result as JSON has it: its fields by name, without those that are None or `IS_KEY`."""
    if is_dataclass(result):
        found = ((one, getattr(result, one.name)) for one in fields(result) if one.metadata != IS_KEY)
        shown = ((one.name, each) for one, each in found if each is not None or one.metadata == IS_NULLABLE)
        return {name: document_of(each) for name, each in shown}
    if isinstance(result, Mapping):
        return {key: document_of(one) for key, one in result.items()}
    if hasattr(result, "tolist"):  # an array
        return result.tolist()
    return [document_of(one) for one in result] if isinstance(result, list | tuple) else result


@dataclass(frozen=True, slots=True)
class ResultFormat:
    """A format: the command that writes it, and by key what the value is; ``format`` itself is not listed."""

    written_by: str
    keys: dict[str, str]
    note: str = ""


NOT_SOLVED = "sentences: what the data do not determine"
WARNINGS = "sentences"

RESULTS: dict[str, ResultFormat] = {
    "solution/1": ResultFormat(
        "station solve CAMPAIGN ... --json OUT",
        {
            "accelerometer": "`scale_factor` {value [3], std [3], unit}, `misalignment` {value 3x3, std 3x3; rows"
            " are sensors}, `bias` [g] of the joint fit; `bias_12_position` and `bias_two_direction` [g], the "
            "estimators of Yao, Hu, He 2018, whose std holds counting noise alone",
            "gyroscope": "`scale_factor` [count/deg], `misalignment`, `bias` [deg/h]",
            "slab": "`tilt_rad`: East and North components of the up vector, seen from the surface plate",
            "fixture": "`parallelism_rad` 3x2: rows are face pairs x, y, z; columns the two other axes",
            "residual": "`accelerometer_rms_g`, `gyroscope_rms_deg_h`; `chi2`, `dof`, `p_value` of the test",
            "effects": "error terms in the model: `name`, `coefficients` {value, std}, `unit`, `units`; of a "
            "user-defined term also `term`, `sha256`, `definition`",
            "covariance": "`names` and `matrix` over all parameters",
            "reference_temperature_c": "25 where the model has a temperature term, else the mean of the campaign",
            "unnoticed_leans": "the smallest tilt of each dwell that would be detected every second time: "
            "`campaign`, `step`, `position`, `lean_arcsec`, and by how many `sigmas` it moves `value`",
            "not_observable": NOT_SOLVED,
            "warnings": WARNINGS,
            "unused_steps": "names of steps that were read and not used",
            "provenance": "`files` with SHA-256, `model`, `serial`, `software`, `created_utc`",
        },
        "std is the standard uncertainty u. Scale factors of a `rate` output are in output/g and output/(deg/s). "
        "Without a certificate of the faces the misalignment refers to the mean cube.",
    ),
    "diagnosis/2": ResultFormat(
        "station diagnose RECORDING ... --json OUT",
        {
            "recording": "`campaign`, `rests`, `rotation`, `rest` or `rate table`: what `next_measurement` fits",
            "verdict": "`consistent`, `established`, `likely`, `ambiguous`, `partly` or `unexplained`",
            "reasons": "why: `code`, `what` it is about, the computed `value`",
            "findings": "the causes that have a name: `effect`, `kind`, `coefficients`, `unit`, `where`, "
            "`probability` of the name, `confidence` (`established` from 0.99, `likely` from 0.9, `possible`), "
            "`joint_probability` that one of the names in `shares` acts, `aliases` (the other names), "
            "`separate_by`, `times_expected` (largest coefficient over the size expected of a fibre-optic IMU), "
            "`error` held out without and with it, `share` of its square, `same_here`, `fault` of a channel "
            "(`wrong row`, `frozen`, `clipped`, `noise`); "
            "of a user-defined term `term`, `sha256`, `definition`; of a proposed one "
            "`latex`, `readings`, `held_out_sigmas`",
            "unnamed": "causes that no known error term explains: `what` each looks like, `note`, `probability`, "
            "`joint_probability`, `shares`",
            "probabilities": "of every error term that was considered",
            "not_separable": "error terms that the model's own parameters absorb here, with what separates them",
            "p_value": "of the residual that stays; `log10_p` where it is too small for a number",
            "log10_p": "its logarithm",
            "searched": "with `--discover`: number of `terms`",
            "error": "quantity, unit, value before and after, the same on held-out data, and how it was held out",
            "parameters": "each parameter before and after, and its shift in standard uncertainties",
            "solution": "solution/1 with the findings in the model; absent where nothing was solved",
            "channels": "of a triad that was not solved: noise, drift and temperature coefficient of each channel",
            "turns": "of rotations that were not solved: `scale_factor`, `turned`, `beyond_whole_turns`, "
            "`at_rest`",
            "turns_mean": "the mean of several rotations",
            "turns_leave_open": "what the rotations do not determine",
            "rests": "of an unsolved sequence: `specific_force_less_gravity_g`",
            "moves": "of an unsolved sequence: `turned_deg` x, y, z, `angle_deg`, `tilted_deg`, `apart_deg`",
            "noise": "the channels of noise/1",
            "widened": "parameters whose expanded uncertainty the residual widens: `expanded_without`, `expanded`",
            "tests": "of labels, knocks and the clock: `effect`, `probability` where it is likeliest",
            "left": "where the residual is largest: `by`, `what`, `size`, `log10_p`",
            "next_measurement": "the measurement that would separate the alternatives",
            "not_observable": NOT_SOLVED,
            "warnings": WARNINGS,
            "provenance": "as in solution/1, where nothing was solved",
            "guessed": "what was concluded about a log from its columns and values",
        },
    ),
    "calibration/1": ResultFormat(
        "station calibrate, and every stored calibration",
        {
            "accelerometer": "as in solution/1: `scale_factor`, `misalignment`, `bias`",
            "gyroscope": "as in solution/1",
            "effects": "error terms of the instrument, as in solution/1",
            "covariance": "`names` and `matrix` of scale factors, misalignment and bias, in products of their "
            "units",
            "reference_temperature_c": "as in solution/1",
            "model": "model name of the unit",
            "serial": "serial number of the unit",
            "software": "name, version and commit",
            "status": "`calibrated`, or `measured` where a reference is missing or has expired",
            "status_reason": "why it is not `calibrated`",
            "operator": "who calibrated",
            "verdict": "`PASS`, `FAIL` or without limits `NO LIMITS`",
            "limits": "`parameter`, `unit`, `low`, `high` of every limit",
            "judged": "every limited value with its verdict",
            "references": "cube, surface plate and other references, with certificate and due date",
            "accepted_utc": "when it was accepted",
            "valid_from": "first day of validity",
            "valid_until": "last day of validity",
            "temperature_range_c": "lowest and highest temperature of the campaign",
            "residual": "as in solution/1",
            "uncertainty": "budget/1 of its parameters",
            "diagnosis": "`verdict` and `findings` on the residual",
            "procedure": "`name`, `steps`, times, and the standard uncertainties that were stated",
            "site": "`latitude_deg`, `height_m`, gravity with its source and standard uncertainty",
            "inputs": "SHA-256 of every recorded file",
            "manifest": "SHA-256 of the list of accepted steps",
            "previous": "SHA-256 of the calibration of this unit before",
            "journal": "`entries` and `sha256` of the newest entry in the journal of the database",
            "used": "SHA-256 over the rows of unit, limits, campaign, cube, surface plate and site that it rests "
            "on",
        },
        "It is applied as u = E^-1 (N / K - D), error terms by iteration.",
    ),
    "budget/1": ResultFormat(
        "station report, station calibrate (budget.json)",
        {
            "coverage": "coverage probability of `expanded`: 0.95",
            "parameters": "`name`, `value`, `unit`, `std` (u), `dof`, `coverage_factor` (k), `expanded` (U), and "
            "`contributions`: `source`, `type` (A or B), `std`, `dof`",
        },
        "An infinite `dof` and a parameter that is not finite are absent.",
    ),
    "noise/1": ResultFormat(
        "station noise RECORDING ... --json OUT",
        {
            "channels": "of every channel that changes: `channel`, `recording`, `seconds`, `rate_hz`, `mean`, "
            "`terms`, `log10_p`, `conditions`, `allan`, `spectrum`, `lines`",
            "left_out": "channels that never change",
            "warnings": WARNINGS,
            "provenance": "as in solution/1",
        },
        "`terms` are `quantisation`, `random_walk`, `bias_instability`, `rate_random_walk`, `rate_ramp`: `value` "
        "with `low` and `high` (95 %), or the bound `below`, or `value` null where it is not determined. "
        "`spectrum` is one-sided. `lines` have `hertz`, `amplitude`, `share` of the variance and `log10_p`.",
    ),
    "planned/1": ResultFormat(
        "station plan --json OUT",
        {
            "minutes": "duration of the plan",
            "usual_minutes": "duration of the usual plan",
            "steps": "in order: `kind` dwell (`axes`, `up`, `seconds`) or turn (`name`, `seconds`)",
            "sigmas": "of each parameter: `parameter`, `unit`, `wanted`, `plan`, `usual`",
            "noise": "by axis `accelerometer_g_sqrt_s`, `gyroscope_deg_sqrt_h`; `wander_deg_h`; `source`",
            "hands_s": "`placing`, the `move` in it, `turn`; `source`",
            "effects": "error terms of the instrument that a diagnosis could detect by this plan and by the usual"
            " one",
        },
    ),
    "means/2": ResultFormat(
        "station diagnose TABLE --as means --json OUT",
        {
            "file": "name of the table",
            "poses": "number of poses",
            "verdict": "as of `diagnosis/2`; `consistent` also where no residual is left to check it",
            "log10_p": "p-value of the residuals against the standard deviations in the table, its logarithm",
            "wrong_poses": "poses that contradict the others: `pose`, `line`, `probability`, `confidence`, "
            "`sigmas`, `off_mg` (specific force less gravity), `is_held_out` (not used), `alternatives`",
            "findings": "error terms of the accelerometers, as of `diagnosis/2`; they are in the values",
            **dict.fromkeys(("unnamed", "probabilities", "not_separable"), "as of `diagnosis/2`"),
            "error": "as of `diagnosis/2`, each pose held out in turn",
            "next_measurement": "as of `diagnosis/2`",
            "accelerometer": "scale factor, misalignment, bias with std; the rms of residuals, of stated noise, "
            "held out; `chi2`, `degrees_of_freedom`",
            "gyroscope": "`bias` {value, std, unit}; `earth_rate_in_bias`",
            "not_observable": NOT_SOLVED,
            "warnings": WARNINGS,
            "guessed": "what was inferred from the file",
            "provenance": "as in solution/1",
        },
    ),
    "applied/1": ResultFormat(
        "station apply INPUT --calibration CALIBRATION --out FILE (FILE.json)",
        {
            "input": "name of what was read",
            "samples": "number of samples that were written",
            "period_s": "the interval that counts were divided by",
            "frame": "`sensor`, `cube` or `frd`",
            "axes": "IMU axes that point forward, right, down; null for those of the frame",
            "units": "of specific force and angular rate",
            "columns": "of the file",
            "mounting": "cube axes along which the IMU axes point, where the campaign states it",
            "calibration": "`model`, `serial`, `accepted_utc`, `status`, `valid_until`, `sha256`",
            "software": "name, version and commit",
            "effects": "error terms that were corrected",
            "warnings": "sentences, also about error terms that were not corrected",
            "spans_s": "[from, to] of every minute",
            "specific_force_std_m_s2": "[x, y, z] a minute: standard uncertainty that the calibration leaves",
            "angular_rate_std_rad_s": "the same of the angular rate",
        },
    ),
    "attitude/1": ResultFormat(
        "station attitude LOG --json OUT",
        {
            "aid": "the aid of the filter",
            "direction": "`forwards` or `both`",
            "parameters": "of the filter",
            "rows": "number of rows",
            "gaps": "gaps in the log",
            "gyro_bias_rad_s": "estimated gyroscope bias with std",
            "rms_deg": "rms error of roll, pitch and inclination, where the log has a reference attitude",
            "sigma_deg": "median standard uncertainty of the inclination",
            "observability": "`open_s`, `determinant_rms_rad3_s3`, `rank_3_share` of the aid",
            "warnings": WARNINGS,
        },
        "The CSV next to it has t_s, roll_rad, pitch_rad, down_x, down_y, down_z (the down vector in body axes).",
    ),
    "tuning/1": ResultFormat(
        "station tune LOG --json OUT",
        {
            "aid": "the aid of the filter",
            "rows": "number of rows",
            "chosen": "the chosen point of `curve`",
            "rms_deg": "rms error with it",
            "held_out_rms_deg": "rms error of each stretch with what the other stretches chose",
            "chosen_without_stretch": "what is chosen without each stretch",
            "curve": "of each point: `tau_s` or `k1` and `k2`, `rms_deg`, `by_stretch_deg`",
            "warnings": WARNINGS,
        },
    ),
    "location/1": ResultFormat(
        "station locate FOLDER --json OUT",
        {
            "source": "what gave the motion: `imu`, `odometry`, `vision` or `wheel`",
            "layers": "how it was computed",
            "initialised_at_s": "when position and attitude were first known",
            "why_not": "why they never were",
            "alignment": "`yaw_deg`, `tilt_deg`, `std`",
            "gyro_bias_rad_s": "estimated gyroscope bias",
            "accel_bias_m_s2": "estimated accelerometer bias",
            "lever_arm_m": "IMU to antenna",
            "time_offset_s": "of the GNSS clock",
            "camera_time_offset_s": "of the camera's clock",
            "camera_time_offset_std_s": "its standard uncertainty",
            "wheel": "`scale`, `scale_std`, `slips_s` [[from, to]], `at_rest_s`",
            "rejected_fixes": "number of GNSS fixes that were not used",
            "solve_ms": "duration of each solution",
            "error_m": "against the reference trajectory, without alignment to it",
            "warnings": WARNINGS,
        },
        "Trajectories are TUM lines `t x y z qx qy qz qw`: East-North-Up, IMU to ENU.",
    ),
    "monitor/1": ResultFormat(
        "station monitor URL --json, a line a reading",
        {
            "t_s": "device time",
            "sample": "number of the sample",
            "roll_deg": "roll",
            "pitch_deg": "pitch",
            "rate_deg_s": "[x, y, z] angular rate",
            "gyro_bias_deg_h": "[x, y, z] estimated gyroscope bias",
            "residual_deg": "angle between the measured and the predicted vertical",
            "mode": "how the unit moves",
            "aid": "the aid of the filter",
            "sigma_deg": "standard uncertainty of the inclination",
            "heading_deg": "heading of the aid",
            "speed_m_s": "speed of the aid",
            "temperature_c": "temperature of the unit",
            "zero_deg": "[roll, pitch] that the screen subtracts; the angles of this line are absolute",
            "alarms": "names of the alarms that are on",
            "at_rest": "`seconds`, `earth`, and errors `calibrated` and `nominal`: `level_deg`, `drift_deg_h`, "
            "`g_error_mg`",
            "laws": "of each filter: `law`, `form`, `roll_deg`, `pitch_deg`, `gyro_bias_deg_h`, `final_bias`, "
            "`note`",
            "difference": "`roll_deg`, `pitch_deg`, ...: the second filter less the first",
            "location": "`state` (located, waiting), `fixes`; waiting: `why`; located: `t_s`, `enu_m`, "
            "`enu_std_m`, `velocity_enu_m_s`, `latitude_deg`, `longitude_deg`, `height_m`, `outliers`, "
            "`fix_age_s`, `heading_deg`, `heading_std_deg`; `camera`, `images_dropped`, `wheel` where there is "
            "one",
        },
    ),
    "stream/1": ResultFormat(
        "station stream URL --to stdout, a line a sample",
        {
            "sequence": "number of the sample",
            "t_s": "device time at the end of its interval",
            "utc_s": "UTC, where a receiver or a pulse gives it",
            "f_x_m_s2": "specific force along x; likewise y, z",
            "f_y_m_s2": "",
            "f_z_m_s2": "",
            "omega_x_rad_s": "angular rate about x; likewise y, z",
            "omega_y_rad_s": "",
            "omega_z_rad_s": "",
            "temperature_c": "temperature of the unit",
            "flags": "names of the quality flags that are set",
            "lost": "samples that were lost before this one",
        },
    ),
    "devices/1": ResultFormat(
        "station devices --json",
        {
            "devices": "of each port: its `url`, what it is and what was recognised on it, and `trouble`",
        },
    ),
    "history/1": ResultFormat(
        "station history SERIAL --json OUT",
        {
            "serial": "serial number of the unit",
            "calibrations": "in order of storing: `sha256`, `model`, `accepted_utc`, `measured_utc`, `status`, "
            "`verdict`, `effects`, `limited`, cube, surface plate, site and operator; `parameters` {value, std, "
            "unit} and `drift` {shift, shift_sigma, p_adjusted} against the calibration before",
            "analysis": "of each model: `model`, `turn_ons`, `first_utc`, `last_utc`, `predicted_utc`, "
            "`predicted_because`, `control_limit`, `left_out`, and `parameters`: `unit`, `calibrations`, "
            "`measured_utc`, `value`, `std`, `limits`, `repeatability`, `chart`, `prediction`, and what is "
            "missing for these (`needs`)",
        },
    ),
    "population/1": ResultFormat(
        "station history --population MODEL --json OUT",
        {
            "model": "model name",
            "units": "number of units",
            "turn_ons": "number of calibrations; a recording that was solved again counts once",
            "false_alarm": "probability that anything stands out in a model where nothing is wrong",
            "left_out": "parameters that could not be compared",
            "parameters": "by name: `unit`, `median`, `spread`, `units` {serial, value, std}, `extremes` {serial,"
            " shift, std, p_adjusted, stands_out}",
            "groups": "cubes, surface plates, sites and operators: `kind`, `id`, `parameter`, `unit`, `shift`, "
            "`std`, `p_value`, `p_adjusted`, `units`, `stands_out`",
            "cannot_tell": "groups that no unit was calibrated both with and without",
        },
    ),
    "resolve/1": ResultFormat(
        "station resolve FOLDER ... --json OUT",
        {
            "software": "name, version and commit",
            "created_utc": "when it was made",
            "campaigns": "of each: `folder`, `outcome` (solved, refused, missing), `before` {kind, name, "
            "software}, `model`, `serial`, `altered` files; where solved `was_kept`, the comparison of every "
            "parameter with the solution before, and of the `diagnosis`; else `reason`, `exit_code`, `host`",
        },
    ),
    "measured-cube/1": ResultFormat(
        "station fixtures measure --json OUT",
        {
            "cube": "its name",
            "measured_utc": "when",
            "values_rad": "by name, tilts and parallelism of the faces",
            "std_rad": "their standard uncertainties",
            "covariance": "`names` and `matrix`",
            "units": "of each IMU: `unit`, `campaigns`, `quadratic_std_g`, `quadratic_left_g`, "
            "`by_quadratic_rad_per_g`",
            "not_observable": NOT_SOLVED,
            "warnings": WARNINGS,
            "consistency": "`chi2`, `dof`, `p_value` of the agreement between IMUs",
            "against_certificate": "`values` {shift_rad, std_rad, shift_sigma}, `chi2`, `p_value`",
            "drift": "`dof`, `values` {shift_rad, shift_sigma, chi2, p_adjusted, trend_rad_per_month, ...}, "
            "`changed`",
        },
    ),
    "tolerance/1": ResultFormat(
        "station fixtures tolerance --json OUT",
        {
            "cube": "its name",
            "side_mm": "its side",
            "tolerance_mm": "of every item of the drawing",
            "cubes_drawn": "number of random cubes",
            "distribution": "of `items` and `directions`",
            "bias": "by estimator [g]: `p1_case`, `worst_case_at_most`, `worst_case_reached`, spread over the "
            "cubes",
            "scale_factor": "relative: worst case and spread",
            "misalignment": "[rad]: spread",
            "wanted": "`estimator` and `bias_g`, where an accuracy was asked for",
            "allowed": "tolerances that give it",
            "would_buy": "what a certificate or a second mounting would improve",
            "set_aside": "of every item that Yao, Hu, He 2018 sets aside: its standard uncertainties",
            "set_aside_together": "all of them together",
        },
    ),
}
