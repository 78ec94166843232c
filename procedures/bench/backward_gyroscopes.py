"""Gyroscopes that count backwards in moves by hand: E of each sensor is near -1 where gravity says +1.

Where no face ties the accelerometers' frame it is mirrored if one of them counts backwards, and rates in such a
frame have the signs of the two other axes changed: so two gyroscopes backwards may be one accelerometer. One or
three are gyroscopes for sure: no mirror gives them.
"""

from procedures.arrays import FloatArray
from procedures.bench.sign_errors import backwards
from procedures.frames import AXES


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
