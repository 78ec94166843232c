"""What campaigns left open of a cube, and what would close it."""

import numpy as np

from procedures.campaign.measured_cube import PARALLELISM, SKEW, CubeMeasurement, common_and_difference
from procedures.frames import AXES

TURNING = (
    "how the cube is turned as a whole (half the difference of perpendicularity q_ac and q_ca): "
    "only a certificate of its datum faces determines its axes"
)
NO_SKEW = (
    "skew of the cube (perpendicularity of its pairs of faces): indistinguishable from the IMU's misalignment; "
    "separated by a campaign with the IMU re-mounted, turned by 90 deg in the cube, or by a dozen rests in free "
    "attitudes"
)


def by_quadratic(measured: CubeMeasurement) -> list[str]:
    """Return the axes x, y, z of the cube along which mean parallelism is left to the plausible range of K2."""
    names, H = common_and_difference(measured.cube.names)
    total = np.diag(H @ measured.cube.covariance @ H.T)
    noise = np.diag(H @ measured.noise @ H.T)
    open_ = [name for name, t, n in zip(names, total, noise, strict=True) if "mean" in name and n < t / 2]
    return [axis for axis in AXES if any(name.endswith(f".{axis}") for name in open_)]


def not_observable(measured: CubeMeasurement) -> list[str]:
    """Return what was left open, each with what would separate it."""
    found = [_no_parallelism(name) for name in PARALLELISM if name not in measured.cube.names]
    missing = [name for name in SKEW if name not in measured.cube.names]
    found += (
        [NO_SKEW]
        if len(missing) == len(SKEW)
        else [f"{name}, not determined beyond its prior" for name in missing]
    )
    for axis in by_quadratic(measured):
        others = " or ".join(other for other in AXES if other != axis)
        found.append(
            f"mean parallelism along {axis}: indistinguishable from bias and K2 of the sensor along {axis}; "
            f"separated by a campaign with the IMU re-mounted, turned by 90 deg about {others}, or by more units"
        )
    return [*found, TURNING]


def _no_parallelism(name: str) -> str:
    pair = name.split(".")[1]
    return f"{name}, not determined beyond its prior: needs dwells with {pair} up and with {pair} down"
