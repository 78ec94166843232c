"""What ``station locate`` does with a folder that was read."""

from pathlib import Path
from typing import Any

from procedures.errors import NotObservable
from station.files.atomic_file import write_json
from station.files.fusion_folder import FusionLog, write_tum
from station.locate.location_json import location_document
from station.locate.source_choice import default_source, locate
from station.text.plural import plural


def locate_folder(
    log: FusionLog, source: str | None, layers: int, out: Path | None, batch: Path | None, json: Path | None
) -> str:
    """Locate, write what was asked for, and return a summary, empty where a JSON was asked for.

    Raises
    ------
    NotObservable
        If it never could be initialised; the JSON is written and says why.
    """
    source = source or default_source(log)
    located = locate(log, source, layers)
    document = location_document(located, source, log.truth)
    if json is not None:
        write_json(json, document)
    if located.begun_at is None:
        raise NotObservable(f"{log.folder}: position and heading", (located.why_not,))
    if out is not None:
        write_tum(out, located.online)
    if batch is not None:
        write_tum(batch, located.smoothed)
    return "" if json is not None else location_text(document, located.fixes)


def location_text(document: dict[str, Any], fixes: int) -> str:
    """Return the lines of a readable summary; ``fixes`` is how many there were."""
    layers = "one layer" if document["layers"] == 1 else "two layers"
    lines = [f"source                {document['source']}, {layers}"]
    lines.append(f"initialised at        {document['initialised_at_s']:.2f} s")
    for name, unit in (("yaw", "deg"), ("tilt", "deg")):
        if f"{name}_deg" in document.get("alignment", {}):
            value, std = (part[f"{name}_deg"] for part in (document["alignment"], document["alignment"]["std"]))
            lines.append(f"{name + ' found then':<22}{value:.2f} +- {std:.2f} {unit}")
    for key, name, unit in (
        ("gyro_bias_rad_s", "gyro bias", "rad/s"),
        ("accel_bias_m_s2", "accelerometer bias", "m/s2"),
        ("lever_arm_m", "lever arm", "m"),
    ):
        if key in document:
            lines.append(f"{name:<22}{', '.join(f'{part:.4g}' for part in document[key])} {unit}")
    if "time_offset_s" in document:
        lines.append(f"GNSS time offset      {document['time_offset_s'] * 1e3:.1f} ms")
    if "camera_time_offset_s" in document:
        std = document.get("camera_time_offset_std_s")
        said = "" if std is None else f" +- {std * 1e3:.1f}"
        lines.append(f"camera time offset    {document['camera_time_offset_s'] * 1e3:.1f}{said} ms")
    if wheel := document.get("wheel"):
        slipped = f"slipped {plural(len(wheel['slips_s']), 'time')}, at rest for {wheel['at_rest_s']:.0f} s"
        lines.append(f"wheel scale factor    {wheel['scale']:.5f} +- {wheel['scale_std']:.5f}, {slipped}")
    lines.append(f"rejected fixes        {document['rejected_fixes']} of {fixes}")
    for name, said in (("online", "error, online"), ("batch", "error, smoothed")):
        if error := document.get("error_m", {}).get(name):
            lines.append(f"{said:<22}mean {error['mean']:.3f} m, largest {error['max']:.3f} m, without alignment")
    return "\n".join(lines + [f"warning: {warning}" for warning in document["warnings"]])
