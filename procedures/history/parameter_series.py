"""One parameter of one unit over its calibrations."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationSeries:
    """When each calibration was made [day], what it found and its own 1 sigma, all (n,); times do not decrease.

    Raises
    ------
    ValueError
        If shapes differ, something is not finite, a sigma is not positive or a time decreases.
    """

    day: FloatArray
    value: FloatArray
    std: FloatArray

    def __post_init__(self) -> None:
        if not self.day.shape == self.value.shape == self.std.shape == (len(self.day),):
            raise ValueError(f"shapes {self.day.shape}, {self.value.shape}, {self.std.shape}, expected one (n,)")
        if not all(np.isfinite(part).all() for part in (self.day, self.value, self.std)):
            raise ValueError("a time, value or sigma that is not finite, expected all finite")
        if (self.std <= 0).any() or (np.diff(self.day) < 0).any():
            raise ValueError("a sigma of 0 or less, or a time before the last, expected neither")

    def __len__(self) -> int:
        return len(self.day)
