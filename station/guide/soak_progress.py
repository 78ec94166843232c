"""What a soak shows besides its seconds: the temperature, how far it went, the time left."""

import math

from station.guide.view import SoakView
from station.stream.live.stillness import Block


class SoakTemperature:
    """Follows the temperature of a soak's blocks; devices that say none leave it unknown."""

    def __init__(self) -> None:
        self._now, self._low, self._high = math.nan, math.inf, -math.inf

    def take(self, block: Block) -> None:
        """Take a second of the stream."""
        if not math.isnan(block.temperature):
            self._now = block.temperature
            self._low, self._high = min(self._now, self._low), max(self._now, self._high)

    def view(self, left_s: float) -> SoakView:
        """Return what is shown, with ``left_s`` seconds to go."""
        if math.isnan(self._now):
            return SoakView(left_s=left_s)
        return SoakView(temperature_c=self._now, low_c=self._low, high_c=self._high, left_s=left_s)


def soak_in_words(soak: SoakView) -> str:
    """Return it for people: ``24.3 degC (21.0 to 24.3 so far), 8 min left``."""
    left = f"{soak.left_s / 60:.0f} min left" if soak.left_s >= 90 else f"{soak.left_s:.0f} s left"
    if soak.temperature_c is None or soak.low_c is None or soak.high_c is None:
        return f"temperature not known, {left}"
    return f"{soak.temperature_c:.1f} degC ({soak.low_c:.1f} to {soak.high_c:.1f} so far), {left}"
