"""The start of a guided calibration: the set-up remembered, what can be chosen, and a look at a port."""

import os
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import platformdirs
from pydantic import ValidationError

from drivers.errors import DriverError
from drivers.ports import list_ports
from drivers.url_files import anchored
from drivers.wire import ALL_CHANNELS
from fixtures_db.campaigns import is_expired
from fixtures_db.cubes import cubes
from fixtures_db.database import Database
from fixtures_db.slabs import slabs
from procedures.frames import AXES
from procedures.records import RateBlock, SampleBlock, block_rows
from station.campaign_folder.atomic import replace_file
from station.errors import cannot_write
from station.guide.unfinished import unfinished
from station.guide.view import Check, Choice, Setup, Start
from station.live.counted import RATE_UNIT
from station.live.stillness import TICKS, Block, block_of

if TYPE_CHECKING:
    from station.reader.look import Seen

LOOK_S = 2.0
RECORD_INSTEAD = "record its steps with `station record` and solve them as a campaign folder"
TICK_S = 0.1
BAD_SHARE = 0.01  # of the frames; beyond it the line is not good enough to begin


def setup_file() -> Path:
    """Return where the last set-up is kept: the user's configuration, or the folder ``STATION_CONFIG`` names."""
    folder = os.environ.get("STATION_CONFIG")
    return (Path(folder) if folder else platformdirs.user_config_path("fog-station")) / "setup.json"


def load_setup() -> Setup:
    """Return the last set-up; the default one where there is none or it cannot be read."""
    try:
        return Setup.model_validate_json(setup_file().read_bytes())
    except (OSError, ValidationError):
        return Setup()


def save_setup(setup: Setup) -> None:
    """Remember a set-up; raise `CannotWrite` if the place cannot be written."""
    path, setup = (
        setup_file(),
        setup.model_copy(update={"url": anchored(setup.url), "gnss": anchored(setup.gnss, "receiver")}),
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path.parent, error) from error
    replace_file(path, (setup.model_dump_json(indent=1) + "\n").encode())


def start_view(database: Database, setup: Setup) -> Start:
    """Return what can be chosen: ports, cubes and slabs with their certificates, unfinished campaigns."""
    with database.read() as session:
        known = [(cube.id, f"{cube.side_mm:g} mm", cube.due_date) for cube in cubes(session)]
        stones = [(slab.id, "", slab.due_date) for slab in slabs(session)]
    return Start(
        setup=setup,
        ports=tuple(_ports()),
        cubes=tuple(_reference(*each) for each in known),
        slabs=tuple(_reference(*each) for each in stones),
        unfinished=tuple(unfinished(database)),
    )


def check_port(url: str, seconds: float = LOOK_S) -> Check:
    """Look at what a port sends; what is wrong with it stands in ``text``, with what to do. Never raises."""
    from station.reader.look import look

    try:
        seen = look(url, seconds)
    except (DriverError, OSError) as error:
        return Check(url=url, is_good=False, text=str(error))
    counters = seen.counters
    bad = counters.bad_crc + counters.bad_length
    remedies = _remedies(seen, bad)
    return Check(
        url=url,
        is_good=not remedies,
        format=seen.format,
        model=seen.model or "",
        serial=seen.serial or "",
        rate_hz=seen.rate_hz,
        frames=seen.frames,
        bad_frames=bad,
        noise=noise_in_words(seen.samples, seen.rate_hz),
        text="; ".join(remedies) or "frames come as they should",
    )


def noise_in_words(samples: SampleBlock, rate_hz: float | None) -> str:
    """Say how much the counts of tenths of a second scatter within a second, by triad the greatest channel."""
    size = round(rate_hz) if rate_hz else 0
    seconds = len(samples) // size if size >= TICKS else 0
    if not seconds:
        return "less than a second came: too short to say the noise"
    variance = np.mean([_second(samples, i * size, size).variance for i in range(seconds)], axis=0)
    gyro, accel = np.sqrt(variance).reshape(2, 3).max(axis=1)
    if isinstance(samples, RateBlock):
        gyro, accel = (value / (RATE_UNIT * TICK_S) for value in (gyro, accel))
        return f"gyroscopes {gyro:.2g}, accelerometers {accel:.2g} rms of 0.1 s, in the device's units"
    return f"gyroscopes {gyro:.2g}, accelerometers {accel:.2g} counts rms in 0.1 s"


def _second(samples: SampleBlock, first: int, size: int) -> Block:
    rows = block_rows(samples, slice(first, first + size))
    return block_of(rows, first, 1 / size, is_broken=False, is_anew=False)


def _remedies(seen: "Seen", bad: int) -> list[str]:
    counters, said = seen.counters, list[str]()
    if bad > BAD_SHARE * (seen.frames + bad):
        said.append(
            f"{bad} of {seen.frames + bad} frames are damaged, expected under {BAD_SHARE:.0%}; check cable, "
            f"ground and termination"
        )
    if counters.counter_jumps:
        said.append(
            f"frames are missing in {counters.counter_jumps} places, expected none; check that the baud rate is "
            f"high enough and nothing else reads the port"
        )
    if counters.bad_status:
        said.append(
            f"the device reports a fault in {counters.bad_status} of {seen.frames} frames, expected none; "
            f"let it warm up, or see its manual"
        )
    for triad, values in (("gyro", seen.samples.gyro), ("accelerometer", seen.samples.accel)):
        said += [
            f"{triad} {AXES[i]} puts out nothing, expected counts; check the unit"
            for i in range(3)
            if not values[:, i].any() and f"{triad[0]}{AXES[i]}" in seen.channels
        ]
    if missing := sorted(ALL_CHANNELS - seen.channels):
        said.append(f"{seen.format} sends no {', '.join(missing)}, expected six channels; {RECORD_INSTEAD}")
    return said


def _ports() -> Sequence[Choice]:
    return [
        Choice(
            key=f"serial://{port.device}",
            title=f"{port.device} {port.description}".strip(),
            note=f"serial number {port.serial_number}" if port.serial_number else "",
        )
        for port in list_ports()
    ]


def _reference(name: str, size: str, due: date | None) -> Choice:
    if due is None:
        note = "no certificate date"
    else:
        note = f"certificate {'expired on' if is_expired(due, date.today()) else 'due'} {due}"
    return Choice(key=name, title=f"{name} {size}".strip(), note=note)
