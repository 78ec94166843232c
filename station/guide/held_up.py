"""Says that the engine is held up, by a slow disk as a rule, while it is: it cannot say so itself."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from station.guide.view import ENDED_STAGES, VERDICT_STAGES, CalibrationView

HELD_UP_S = 3.0  # a round of the engine takes 0.1 s, accepting a step 0.3 s
LOOK_S = 0.5
SAYS_ITSELF = frozenset({"start", "connecting", "solving"}) | ENDED_STAGES | VERDICT_STAGES
HINT = "writing to the disk for {seconds:.0f} s, which is slow: do nothing; all accepted steps are safe"


class HeldUpWatch:
    """Publishes ``shown``'s view with a hint while a round lasts; use it in a ``with``."""

    def __init__(
        self, shown: Callable[[], CalibrationView | None], publish: Callable[[CalibrationView], None]
    ) -> None:
        self._shown, self._publish = shown, publish
        self._since: float | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="held up", daemon=True)

    def __enter__(self) -> "HeldUpWatch":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    @contextmanager
    def round(self) -> Iterator[None]:
        """Watch over one round."""
        self._since = time.monotonic()
        try:
            yield
        finally:
            self._since = None

    def _run(self) -> None:
        while not self._stop.wait(LOOK_S):
            since, view = self._since, self._shown()
            if since is None or view is None or view.stage in SAYS_ITSELF:
                continue
            if (seconds := time.monotonic() - since) >= HELD_UP_S:
                self._publish(view.model_copy(update={"hint": HINT.format(seconds=seconds)}))
