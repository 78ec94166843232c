"""A camera on the planted flight: what it sees, and what is to be found again."""

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import Trajectory
from procedures.fusion.inner.window_terms import Site
from tests.drivers.simulated.camera_tracks import View, simulate_tracks
from tests.procedures.fusion.motions import EARTH, GRAVITY, NOISE, Eight

# the flight's x axis points up: the camera looks along body z, its right is body -y
CAMERA = PinholeCamera(
    458.0, 457.0, 367.0, 248.0, 1.0, np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    np.array([-0.02, -0.06, 0.01]),
)  # fmt: skip
SITE = Site(GRAVITY, EARTH, NOISE)


def path_of(flight: Eight) -> Trajectory:
    """Return the flight at 20 Hz."""
    t = np.arange(0.0, flight.seconds, 0.05)
    return Trajectory(t, flight.p(t), flight.attitude(t).as_quat())


def tracks_of(flight: Eight, seed: int, camera: PinholeCamera = CAMERA, view: View | None = None) -> FeatureTracks:
    """Return what the camera leaves."""
    return simulate_tracks(path_of(flight), camera, view or View(), seed)


def turned(camera: PinholeCamera, turn_deg: float, shift_m: float) -> PinholeCamera:
    """Return a camera whose place is told wrong by so much about and along each axis."""
    wrong = Rotation.from_rotvec(np.radians(turn_deg) * np.ones(3)).as_matrix()
    return PinholeCamera(
        camera.fx, camera.fy, camera.cx, camera.cy, camera.std, camera.C_bc @ wrong, camera.t_bc + shift_m
    )
