"""How long before the last sample of a chunk a reference pulse (PPS) came, as a device tells in its frames.

A read ends anywhere in a frame, so that the frame that tells may have begun in the chunk before.
"""

from drivers.wire import PulseForm
from procedures.counts.sample_records import SampleBlock

MAX_FRAME = 1024  # bytes: more than any format's frame


class PulseAges:
    """Chunks in order; ``form`` is None where the format tells of no pulse."""

    def __init__(self, form: PulseForm | None) -> None:
        self._form, self._before = form, b""

    def of(self, data: bytes, block: SampleBlock) -> float | None:
        """Return how old [s] the pulse is at the last sample of ``block``, which ``data`` completed, if told."""
        if self._form is None:
            return None
        together = self._before + data
        self._before = together[-MAX_FRAME:]
        return self._form.age(together, float(block.device_time[-1])) if len(block) else None
