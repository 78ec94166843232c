"""Gains of the complementary filter (You and Lee 1, 15)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ComplementaryGains:
    """K1 [1/s] pulls the attitude towards the accelerometer's, K2 [1/s] learns the gyro bias from the rest.

    The loop is ``s^2 + K1 s + K1 K2`` (You and Lee eq. 1): natural frequency ``sqrt(K1 K2)``, damping
    ``sqrt(K1 / K2) / 2``.
    """

    k1: float
    k2: float

    def __post_init__(self) -> None:
        if not (self.k1 > 0 and self.k2 >= 0):
            raise ValueError(f"gains are K1 = {self.k1:g}, K2 = {self.k2:g}, expected K1 > 0 and K2 >= 0")

    @classmethod
    def of_time_constant(cls, tau: float) -> "ComplementaryGains":
        """Return the critically damped gains of a time constant [s]: You and Lee eq. 15."""
        if not tau > 0:
            raise ValueError(f"the time constant is {tau:g} s, expected more than 0")
        return cls(2 / tau, 1 / (2 * tau))


PAPER_GAINS = ComplementaryGains(0.08, 0.0125)  # You and Lee, section 4: printed next to (15), but not of its form
