"""Images as they came to features that are followed: decoded, followed, without the lens's distortion."""

from collections.abc import Callable
from typing import cast

import numpy as np

from drivers.camera import CameraImage
from procedures.arrays import FloatArray, IntArray
from procedures.fusion.vision.feature_tracker import FeatureTracker, Image, LensModel
from procedures.optional_libraries import opencv

FeaturePositions = tuple[IntArray, FloatArray]
Follow = Callable[[CameraImage], FeaturePositions | None]


class ImageFeatureFollower:
    """Call it with each image in turn; ``spoilt`` counts those that are none, or of another size."""

    def __init__(self, lens: LensModel) -> None:
        self._lens, self._cv = lens, opencv()
        self._follower = FeatureTracker(lens)
        self._shape: tuple[int, ...] | None = None
        self.spoilt = 0

    def __call__(self, image: CameraImage) -> FeaturePositions | None:
        """Return the features (n,) in an image and where they stand (n, 2) [px]; None where it is no image."""
        grey = self._cv.imdecode(np.frombuffer(image.jpeg, np.uint8), self._cv.IMREAD_GRAYSCALE)
        if grey is None or (self._shape is not None and grey.shape != self._shape):
            self.spoilt += 1
            return None
        self._shape = grey.shape
        feature, uv = self._follower.follow(cast("Image", grey))
        return feature, self._lens.straightened(uv)
