"""Signs that contradict each other: sensors that count backwards, rotations and positions recorded reversed.

A sensor's own term of E is near -1 where its sign is inverted, or its turns or positions are exchanged. The
Earth's rate w in the dwells separates these: with K of the turns a gyroscope at rest puts out ``b + a K w``, a =
+1 where turns and dwells agree. Reversed turns leave a = -1 in both parts of w, positions upside down in the
vertical one. Where no face ties the accelerometers' frame, two gyroscopes backwards may be one accelerometer.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TriadDwells
from procedures.frames import AXES
from procedures.geodesy import earth_rate_n
from procedures.positions import nominal_C_lb
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit

MIN_OWN_AXIS_SHARE = 0.8  # of a row of E that must lie along the sensor's own axis for its sign to mean anything
MIN_SIGN_SIGMAS = 6.0  # sigmas of a from zero
MAX_OFF_UNIT = 0.3  # of a from +-1, in addition to four of its sigmas
MIN_SIGN_DWELLS = 6  # dwells


@dataclass(frozen=True, slots=True, eq=False)
class EarthSigns:
    """a (2, 3) of each gyroscope with 1 sigma (2, 3): by the Earth's rate, vertical and horizontal part."""

    value: FloatArray
    std: FloatArray

    def of_turns(self, sensors: Sequence[int]) -> int:
        """Return +1 or -1 as the dwells agree with the turns' directions or contradict them; 0 if undetermined."""
        signs = {_sign(a[sensors], std[sensors]) for a, std in zip(self.value, self.std, strict=True)} - {0}
        whole = _sign(self.value[:, sensors].ravel(), self.std[:, sensors].ravel())
        return whole if signs == {whole} else 0

    def of_faces(self, sensors: Sequence[int]) -> int:
        """Return +1 or -1 as the dwells agree with the faces that their positions name; 0 if undetermined."""
        return _sign(self.value[0, sensors], self.std[0, sensors])


def _sign(a: FloatArray, std: FloatArray) -> int:
    use = np.isfinite(std)
    if not use.any():
        return 0
    weight = std[use] ** -2.0
    mean, sigma = float(weight @ a[use] / weight.sum()), float(weight.sum() ** -0.5)
    sign = 1 if mean > 0 else -1
    return sign if abs(mean) > MIN_SIGN_SIGMAS * sigma and abs(mean - sign) < max(MAX_OFF_UNIT, 4 * sigma) else 0


def earth_signs(
    campaigns: Sequence[Campaign],
    dwells: Sequence[tuple[int, int]],
    rate: FloatArray,
    std: FloatArray,
    K: FloatArray,
) -> EarthSigns:
    """Compare the gyroscopes' rates in dwells with the Earth's.

    Parameters
    ----------
    dwells : campaign and position of each of n dwells
    rate, std : (n, 3) [output/s], 1 sigma by counting noise; scatter beyond it widens a's
    K : (3, 3) [output/deg], IMU axes, as the turns have it
    """
    parts = np.array([_earth(campaigns[number], position) for number, position in dwells]).reshape(-1, 2, 3)
    first = np.array([float(number == n) for number, _ in dwells for n in range(len(campaigns))])
    own_bias = first.reshape(len(dwells), len(campaigns))
    own_bias = own_bias[:, own_bias.any(axis=0)]
    found = np.array([_ratio(parts @ K[q], own_bias, rate[:, q], std[:, q]) for q in range(3)])
    return EarthSigns(found[:, :, 0].T, found[:, :, 1].T)


def _earth(campaign: Campaign, position: int) -> FloatArray:
    """Return the Earth's rate (2, 3) [deg/s] in IMU axes at a position: vertical part, horizontal part."""
    omega = np.degrees(earth_rate_n(campaign.site.latitude))
    C = campaign.fixture.C_sb @ nominal_C_lb(position).T
    return np.array([C[:, 2] * omega[2], C[:, 1] * omega[1]])


def _ratio(parts: FloatArray, bias: FloatArray, rate: FloatArray, std: FloatArray) -> FloatArray:
    """Return a and its 1 sigma (2, 2) of both parts (n, 2) of a sensor's output; infinite where not seen."""
    A = np.hstack((parts, bias))
    unknown = np.tile([0.0, np.inf], (2, 1))
    size = np.linalg.norm(A, axis=0)
    if len(A) < max(MIN_SIGN_DWELLS, A.shape[1] + 2) or np.any(size[2:] == 0):
        return unknown
    use = np.concatenate((size[:2] > 0, np.ones(bias.shape[1], dtype=bool)))
    scaled = A[:, use] / size[use]
    if np.linalg.cond(scaled) > 1e3:
        return unknown
    x, *_ = np.linalg.lstsq(scaled, rate, rcond=None)
    left = rate - scaled @ x
    variance = max(float(left @ left) / (len(A) - int(use.sum())), float(np.mean(std**2)))
    sigma = np.sqrt(np.diag(np.linalg.inv(scaled.T @ scaled)) * variance)
    found = unknown.copy()
    number = int(use[:2].sum())
    found[use[:2]] = np.stack((x[:number], sigma[:number]), axis=1) / size[:2][use[:2], None]
    return found


def backwards(K: FloatArray) -> list[int]:
    """Return the sensors that ``K`` (3, 3), any unit, has inverted; none where one lies along another's axis."""
    E = K / np.linalg.norm(K, axis=1)[:, None]
    own = np.diag(E)
    return np.flatnonzero(own < 0).tolist() if np.all(np.abs(own) > MIN_OWN_AXIS_SHARE) else []


def sign_warnings(
    campaigns: Sequence[Campaign],
    accelerometer: TriadFit | None,
    gyroscope: GyroscopeFit | None,
    gyro: TriadDwells | None,
) -> list[str]:
    """Name the sensors that count backwards, and what else would look so."""
    accel_back = backwards(accelerometer.K) if accelerometer is not None else []
    gyro_back = backwards(gyroscope.joint.K) if gyroscope is not None else []
    if not accel_back and not gyro_back:
        return []
    signs = None
    if gyroscope is not None and gyro is not None:
        dwells = [(number, dwell.position) for number, dwell in gyro.dwells]
        signs = earth_signs(campaigns, dwells, gyro.rate, gyro.std, gyroscope.joint.K)
    C_sb = campaigns[0].fixture.C_sb
    found = []
    for sensors in _together(gyro_back):
        found.append(_of_gyroscopes(sensors, C_sb, 0 if signs is None else signs.of_turns(sensors)))
    for sensors in _together(accel_back):
        is_known = signs is not None and not set(sensors) & set(gyro_back)
        found.append(_of_accelerometers(sensors, C_sb, signs.of_faces(sensors) if is_known and signs else 0))
    return found


def _together(back: list[int]) -> list[list[int]]:
    """Return the sensors that have one cause: all three, or each alone."""
    return [back] if len(back) == 3 else [[q] for q in back]


def _who(kind: str, sensors: Sequence[int]) -> tuple[str, str]:
    if len(sensors) == 3:
        return f"the {kind}s' signs are", f"all three {kind}s count"
    name = f"{kind} {AXES[sensors[0]]}"
    return f"the sign of {name} is", f"{name} counts"


def _of_gyroscopes(sensors: Sequence[int], C_sb: FloatArray, sign: int) -> str:
    who, they = _who("gyroscope", sensors)
    turns = "all turns are" if len(sensors) == 3 else f"the turns about {cube_axis(C_sb, sensors[0])} are"
    if sign < 0:
        return (
            f"{turns} labelled with the opposite direction: by them {they} backwards, by the Earth's rate in the "
            f"dwells forwards; correct their direction"
        )
    if sign > 0:
        return f"{who} inverted: {they} backwards in the turns, and under the Earth's rate in the dwells"
    return (
        f"{turns} labelled with the opposite direction, or {who} inverted: by them {they} backwards, and the "
        f"Earth's rate in the dwells does not determine which; check the direction of one rotation"
    )


def _of_accelerometers(sensors: Sequence[int], C_sb: FloatArray, sign: int) -> str:
    axis, (who, they) = cube_axis(C_sb, sensors[0]), _who("accelerometer", sensors)
    faces = "all positions are recorded upside down"
    if len(sensors) < 3:
        faces = f"the positions with {axis} up and those with {axis} down are exchanged"
    if sign > 0:
        return f"{who} inverted: {they} backwards, and the Earth's rate in the dwells confirms the positions"
    if sign < 0:
        return f"{faces}: by them {they} backwards, and the Earth's rate in the dwells is that of the other faces"
    return f"{who} inverted, or {faces}: {they} backwards; check one position with {axis} up"


def cube_axis(C_sb: FloatArray, sensor: int) -> str:
    """Return the cube axis along which a sensor lies; ``C_sb`` (3, 3) takes cube to IMU axes."""
    return AXES[int(np.argmax(np.abs(C_sb[sensor])))]


def reversed_axes(K: FloatArray, signs: EarthSigns, C_sb: FloatArray) -> BoolArray:
    """Mark the cube axes (3,) the turns about which are, for certain, recorded in the opposite direction.

    ``K`` (3, 3) [output/deg] is in IMU axes, ``C_sb`` (3, 3) takes the cube's axes to them.
    """
    marked = np.zeros(3, dtype=bool)
    for sensors in _together(backwards(K)):
        if signs.of_turns(sensors) < 0:
            marked[[AXES.index(cube_axis(C_sb, q)) for q in sensors]] = True
    return marked


def backward_gyroscopes(K: FloatArray, *, is_turned_freely: bool) -> list[str]:
    """Say which gyroscopes count backwards relative to gravity.

    ``K`` (3, 3) [output/deg] is in the accelerometers' frame, which ``is_turned_freely`` where no face ties it.
    """
    back = backwards(K)
    if not back:
        return []
    if len(back) == 3:
        return [
            "all three gyroscopes count backwards relative to gravity: the triad is left-handed; check their signs"
        ]
    if len(back) == 1:
        return [
            f"gyroscope {AXES[back[0]]} counts backwards: its scale factor is negative to that of the others, the "
            "triad is left-handed; check its sign"
        ]
    x, y = (AXES[i] for i in back)
    other = next(axis for i, axis in enumerate(AXES) if i not in back)
    instead = f", or accelerometer {other} does" if is_turned_freely else ""
    return [
        f"gyroscopes {x} and {y} count backwards{instead}: relative to gravity their scale factors are negative"
    ]
