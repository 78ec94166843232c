"""The bench as it truly stands: site, slab, cube and the seat of each position.

Built from a `Truth`; bench and procedure effects replace its fields. What a campaign *states* is the truth's
value, what the sensors *feel* is the world's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.frames import FACES, C_bn, face_normal, face_of, rotation, vertical_rotation
from procedures.units import STANDARD_GRAVITY


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Site, slab, cube and seats; SI and radians.

    ``faces`` (6, 2) [rad] by `procedures.frames.FACES`; ``C_sb`` (3, 3) cube axes to IMU axes; ``seatings``
    rotation vectors (3,) [rad] in cube axes by position; ``labels`` the position where the cube truly is, by
    the one recorded; ``clock_ppm`` how fast the device's clock runs. ``heading_std``, ``closure_std`` and
    ``seat_std`` [rad] are 1 sigma by which headings, closures and seats scatter beyond what is stated.
    """

    latitude: float
    gravity: float
    magnetic_n: FloatArray
    faces: FloatArray
    slab_tilt: FloatArray
    azimuth: float
    C_sb: FloatArray
    seatings: Mapping[int, FloatArray] = field(default_factory=dict)
    labels: Mapping[int, int] = field(default_factory=dict)
    clock_ppm: float = 0.0
    heading_std: float = 0.0
    closure_std: float = 0.0
    seat_std: float = 0.0

    @property
    def f_n(self) -> FloatArray:
        """Specific force at rest (3,) [g], East-North-Up."""
        return np.array([0.0, 0.0, self.gravity / STANDARD_GRAVITY])

    @property
    def omega_ie_n(self) -> FloatArray:
        """Earth rate (3,) [deg/s], East-North-Up."""
        omega: FloatArray = np.degrees(earth_rate_n(self.latitude))
        return omega

    def attitude(self, position: int, heading: float = 0.0, seated: bool = True) -> FloatArray:
        """Return ``C_bn`` (3, 3), East-North-Up to the cube, when asked to rest in ``position`` 1..24.

        ``heading`` [rad] counter-clockwise from nominal. A planted seating error or wrong label acts only when
        ``seated``: a turn begins from a seat of its own.
        """
        actual = self.labels.get(position, position) if seated else position
        up_tilt = self.faces[FACES.index(face_of(actual))]
        C = C_bn(actual, self.slab_tilt, up_tilt, heading) @ vertical_rotation(self.azimuth)
        if seated and position in self.seatings:
            return rotation(self.seatings[position]) @ C
        return C

    def slab_normal_n(self) -> FloatArray:
        """Return the slab's normal (3,), East-North-Up: the axis of every hand turn."""
        from_east, from_north = self.slab_tilt
        # up seen from the slab is (e, n, ..): the normal seen from level leans the other way
        C_nl = vertical_rotation(-self.azimuth) @ rotation(np.array([from_north, -from_east, 0.0]))
        normal_n: FloatArray = C_nl[:, 2]
        return normal_n


def imu_from_cube(imu_axes: tuple[str, str, str]) -> FloatArray:
    """Return the rotation ``C_sb`` (3, 3): its rows are the cube axes, such as ``-y``, of IMU x, y, z."""
    return np.array([face_normal(f"{name[1]}_{'up' if name[0] == '+' else 'down'}") for name in imu_axes])
