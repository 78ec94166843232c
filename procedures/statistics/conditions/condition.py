"""A condition of a recording: its name, a sentence about it, and the noise terms that it leaves undetermined."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from procedures.statistics.noise_terms import TERMS

ALL = TERMS
MAX_LOG_P = -14.0  # ln of the chance of a condition in noise: once in a million recordings
Values = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Condition:
    """Something that was found in the samples of a recording.

    ``name`` is stable, ``text`` a sentence, ``values`` the numbers in it. ``undetermined`` are the noise terms
    (`procedures.statistics.noise_terms.TERMS`) that such a recording does not determine. ``is_of_recording``:
    it is one of the rows, and holds for every channel of the recording, also where noise hides it.
    """

    name: str
    text: str
    undetermined: tuple[str, ...] = ()
    values: Values = field(default_factory=dict)
    is_of_recording: bool = False
