"""Where a unit is, as it is shown and reported."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Location:
    """Where the unit is, East-North-Up of the first fix [m], as of ``t``; ``why`` says what is still missing.

    ``heading`` is of forward, from north [deg]; sigmas are of each axis. ``track`` and outlying fixes ``far`` are
    places East, North; ``fix_age`` [s] is how long before ``t`` the newest fix was that counts in it. ``camera``
    and ``wheel`` say how one does, as text, empty where there is none; of the camera's images
    ``images_dropped`` came too late to count.
    """

    why: str = ""
    is_located: bool = False
    t: float = 0.0
    enu: tuple[float, float, float] = (0.0, 0.0, 0.0)
    enu_std: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    heading: float | None = None
    heading_std: float | None = None
    latitude: float = 0.0
    longitude: float = 0.0
    height: float = 0.0
    fixes: int = 0
    outliers: int = 0
    fix_age: float = 0.0
    track: tuple[tuple[float, float], ...] = ()
    far: tuple[tuple[float, float], ...] = ()
    camera: str = ""
    images_dropped: int = 0
    wheel: str = ""
