"""What is to be known of a single sample: flags, a bit each, alike in every output (docs/how-to/streaming.md)."""

from enum import IntFlag, auto


class Quality(IntFlag):
    """Nothing set: an untroubled sample of a valid calibration."""

    GAP_BEFORE = auto()  # something is missing between the sample before and this one
    BEGUN_ANEW = auto()  # device or port began anew: its time has no relation to what was before
    DEVICE_DOUBTS = auto()  # the device's own status says that it is not well
    SATURATED = auto()  # a count at the end of what the format can hold
    CHANNEL_CONSTANT = auto()  # a channel has put out one value for 10 s though its neighbours move
    TEMPERATURE_MISSING = auto()  # the device says none
    TEMPERATURE_OUTSIDE = auto()  # of the range that the calibration was made in
    EFFECT_LEFT_IN = auto()  # an effect of the calibration could not be taken off
    CALIBRATION_DOUBTED = auto()  # expired, or a reference of it had expired when it was made
    NOMINAL_SCALE = auto()  # no calibration: the maker's scale factors
    UNIT_UNKNOWN = auto()  # the device does not say who it is: the calibration is taken to be its own
    TIME_BY_HOST = auto()  # the device sends no time: it is this machine's
    CLOCK_OFF = auto()  # the device's clock is off another one by more than 0.1 %
    UTC_BY_MESSAGES = auto()  # UTC is by when a receiver's messages came, to milliseconds, not by its pulse
    UNSETTLED = auto()  # effects of the calibration cannot be undone: force, rate or both are NaN


_NAMES: dict[int, list[str]] = {}


def names(flags: int) -> list[str]:
    """Return the names of the flags that are set."""
    if flags not in _NAMES:
        _NAMES[flags] = [str(flag.name).lower() for flag in Quality if flag & flags]
    return _NAMES[flags]
