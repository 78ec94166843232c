"""From findings to the plan of what to measure next, as files of `plan/1`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

from station.files.atomic_file import replace_file
from station.files.campaign_folder.plan_toml import FORMAT
from station.files.toml_writing import toml_text
from station.results.diagnosis.next_measurements import (
    CERTIFICATE,
    MEASUREMENTS,
    REMOUNTED,
    REPEAT,
    Make,
    Measurement,
)

WIDTH = 100


def next_measurements(
    findings: Sequence[Mapping[str, Any]], imu_axes: Sequence[str], is_certified: bool = False
) -> list[Measurement]:
    """Return what would separate each ambiguous finding, or confirm those not of the bench, each once.

    A finding's own measurement comes first; where it has no steps, that of one of its aliases which has.
    ``imu_axes`` is how the IMU was mounted in the cube; if that ``is_certified``, no certificate is asked for.
    """
    doubtful = [finding for finding in findings if finding["confidence"] == "ambiguous"]
    found = dict[str, Measurement]()
    for finding in doubtful or [finding for finding in findings if finding["kind"] != "bench"]:
        names = [finding["effect"], *finding.get("aliases", [])]
        ways = [[make(finding, imu_axes) for make in _of(name, is_certified)] for name in names]
        best = next((each for each in ways if each[0].steps), ways[0])
        found |= {one.name: one for one in best if one.name not in found}
    return list(found.values()) or [REPEAT({}, imu_axes)]


def _of(name: str, is_certified: bool) -> tuple[Make, ...]:
    wanted = MEASUREMENTS.get(name, (REPEAT,))
    return REMOUNTED if is_certified and CERTIFICATE in wanted else wanted


def write_plans(path: Path, wanted: Sequence[Measurement]) -> list[Path]:
    """Write measurements as `plan/1`, the first to ``path``, others beside it; return the files.

    What has no steps is a remark in the first.

    Raises
    ------
    CannotWrite
        If a file cannot be written.
    """
    with_steps = [one for one in wanted if one.steps] or list(wanted[:1])
    besides = [f"Besides: {one.say}" for one in wanted if one not in with_steps]
    files = [path, *(path.with_name(f"{path.stem}_{i}{path.suffix}") for i in range(2, len(with_steps) + 1))]
    for file, one in zip(files, with_steps, strict=True):
        said = [one.say, *(besides if file == path else [])]
        remarks = "".join(f"# {line}\n" for text in said for line in wrap(text, WIDTH))
        replace_file(file, (remarks + toml_text(_tables(one))).encode())
    return files


def _tables(one: Measurement) -> dict[str, Any]:
    fixture = {"fixture": {"imu_axes": list(one.imu_axes)}} if one.imu_axes else {}
    return {"format": FORMAT, **fixture, **{kind: list(steps) for kind, steps in one.steps.items()}}
