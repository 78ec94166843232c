"""``station locate``: IMU, GNSS and odometry of a fusion folder to a trajectory."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument, option


class Source(StrEnum):
    """What moved between the fixes."""

    inertial = "inertial"
    odometry = "odometry"
    vision = "vision"


def locate(
    folder: Annotated[Path, argument("FOLDER", "A folder of fusion/1.")],
    source: Annotated[
        Source | None,
        option("", "Default: inertial where [imu] is, else odometry; vision: camera tracks and IMU."),
    ] = None,
    images: Annotated[
        Path | None, option("DIR", "Follow features through these, or a camera, into [tracks].")
    ] = None,
    seconds: Annotated[float, option("S", "How long to follow --images [s].", min=0)] = float("inf"),
    layers: Annotated[
        int, option("", "1: GNSS position in the IMU's own window; inertial only.", min=1, max=2)
    ] = 2,
    out: Annotated[Path | None, option("TRAJ.tum", "Write the online trajectory here.")] = None,
    batch: Annotated[Path | None, option("BATCH.tum", "Write the smoothed trajectory here.")] = None,
    json: Annotated[Path | None, option("OUT", "Write location/1 here instead of a summary.")] = None,
    db: Database = None,
) -> None:
    """Compute a trajectory: position and attitude, East-North-Up, from IMU, odometry or camera and GNSS.

    Trajectories are TUM lines `t x y z qx qy qz qw` in s and m; quaternions rotate the IMU's axes to
    East-North-Up. The online trajectory uses only data up to each pose and begins when heading and tilt are known;
    the smoothed one uses all data. If the folder has a [truth], position errors in m are reported, without
    alignment. A vehicle's wheel speed in m/s is used if the folder has a [wheel]: docs/how-to/locate-wheel.md.

    --images DIR holds images.csv (`t_s,file`) and the images it names; or it is a camera such as /dev/video0 or a
    video file. The tracks are written to the file of [tracks] and replace it; the source is then vision.

    Exit code 2 if an extra is missing, 3 if the folder breaks a rule of fusion/1, 5 if it could not be
    initialised; the reason is printed.

    Example: station locate drives/2026-05-11 --out track.tum --json location.json
    """
    from station.files.atomic_file import refuse_own
    from station.files.fusion_folder import read_fusion
    from station.files.fusion_folder.fusion_reading import files_of
    from station.locate.locate_folder import locate_folder

    refuse_own((out, batch, json), files_of(folder))
    if images is not None:
        from station.locate.tracks_from_images import images_of, make_tracks

        refuse_own((out, batch, json), images_of(images))
        make_tracks(folder, images, seconds)
        source = source or Source.vision
    log = read_fusion(folder)
    text = locate_folder(log, source and source.value, layers, out, batch, json)
    if text:
        typer.echo(text)
