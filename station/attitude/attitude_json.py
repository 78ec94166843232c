"""`attitude/1` and the CSV of an attitude track; docs/reference/file-formats.md."""

from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import AttitudeEstimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.forward_right_down import inclination, roll_pitch_of
from procedures.frames import wrapped
from procedures.units import DEG_H_PER_DEG_S
from station.files.atomic_file import replace_file
from station.text.plural import plural

FORMAT = "attitude/1"
AXES_UNIT = "rad/s"


def attitude_document(log: AttitudeLog, track: AttitudeEstimate, direction: str = "forwards") -> dict[str, Any]:
    """Return a track as `attitude/1`: JSON-ready, what was not estimated left out; ``direction`` as asked for."""
    bias: dict[str, Any] = {"value": track.gyro_bias.tolist(), "unit": AXES_UNIT}
    if track.gyro_bias_std is not None:
        bias["std"] = track.gyro_bias_std.tolist()
    document: dict[str, Any] = {
        "format": FORMAT, "aid": track.aid, "direction": direction, "parameters": dict(track.parameters),
        "rows": len(log.t), "gaps": [list(gap) for gap in log.gaps], "gyro_bias_rad_s": bias,
    }  # fmt: skip
    if (rms := rms_deg(log, track.down)) is not None:
        document["rms_deg"] = rms
    if track.sigma is not None:
        document["sigma_deg"] = float(np.degrees(np.median(track.sigma)))
    if track.observability is not None:
        seen = track.observability
        document["observability"] = {
            "open_s": seen.open_s, "determinant_rms_rad3_s3": seen.determinant_rms, "rank_3_share": seen.rank_3
        }  # fmt: skip
    return document | {"warnings": [*_of_gaps(log), *track.warnings]}


def rms_deg(log: AttitudeLog, down: FloatArray) -> dict[str, float] | None:
    """Return rms errors [deg] of ``down`` (n, 3) over scored rows with truth; without that column, all."""
    truth = log.true_down
    if truth is None or log.roll is None or log.pitch is None:
        return None
    rows = np.isfinite(truth).all(axis=1)
    if log.scored is not None:
        rows &= log.scored
    if not rows.any():
        return None
    roll, pitch = roll_pitch_of(down[rows])
    errors = {
        "roll": wrapped(roll - log.roll[rows]),
        "pitch": pitch - log.pitch[rows],
        "inclination": inclination(down[rows], truth[rows]),
    }
    return {name: float(np.degrees(np.sqrt(np.mean(error**2)))) for name, error in errors.items()}


def write_track(path: Path, log: AttitudeLog, track: AttitudeEstimate) -> None:
    """Write a row per input row: ``t_s,roll_rad,pitch_rad,down_x,down_y,down_z``.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    roll, pitch = roll_pitch_of(track.down)
    rows = zip(log.t.tolist(), roll.tolist(), pitch.tolist(), *track.down.T.tolist(), strict=True)
    text = "".join("{:.15g},{:.7f},{:.7f},{:.9f},{:.9f},{:.9f}\n".format(*row) for row in rows)
    replace_file(path, ("t_s,roll_rad,pitch_rad,down_x,down_y,down_z\n" + text).encode())


def attitude_text(log: AttitudeLog, document: dict[str, Any]) -> str:
    """Return an `attitude/1` as people read it."""
    bias = np.degrees(document["gyro_bias_rad_s"]["value"]) * DEG_H_PER_DEG_S
    std = document["gyro_bias_rad_s"].get("std")
    lines = [f"{document['rows']} rows, {log.t[-1] - log.t[0]:.1f} s, aid {document['aid']}"]
    if document["direction"] == "both":
        lines[0] += ", forwards and backwards"
    lines.append("gyro bias " + " ".join(f"{b:.1f}" for b in bias) + " deg/h")
    if std is not None:
        lines[-1] += "  (u " + " ".join(f"{s:.1f}" for s in np.degrees(std) * DEG_H_PER_DEG_S) + ")"
    if "rms_deg" in document:
        lines.append("error rms " + ", ".join(f"{name} {v:.3f} deg" for name, v in document["rms_deg"].items()))
    if "sigma_deg" in document:
        lines.append(f"standard uncertainty of the vertical, median {document['sigma_deg']:.3f} deg")
    if "observability" in document:
        seen = document["observability"]
        lines.append(
            f"velocity filter ran {seen['open_s']:.1f} s, observable in {100 * seen['rank_3_share']:.0f} % of it "
            f"(determinant rms {seen['determinant_rms_rad3_s3']:.3g} rad3/s3)"
        )
    return "\n".join([*lines, *(f"warning: {warning}" for warning in document["warnings"])])


def _of_gaps(log: AttitudeLog) -> list[str]:
    gaps = log.gaps
    if not gaps:
        return []
    longest = max(end - start for start, end in gaps)
    return [f"{plural(len(gaps), 'gap')} in t_s, the first at {gaps[0][0]:.6g} s, the longest of {longest:.3g} s"]
