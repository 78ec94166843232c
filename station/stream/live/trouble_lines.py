"""Says what is wrong with a stream in a line as it appears, and in another when it is over."""

import re
from collections.abc import Callable
from datetime import datetime

NUMBER = re.compile(r"\d[\d.]*")


class TroubleLog:
    """One stream's troubles, each said once: other counts in the same words are no other trouble."""

    def __init__(self, name: str, say: Callable[[str], None]) -> None:
        self._name, self._say = name, say
        self._words = ""

    def look(self, trouble: str) -> None:
        """Take what is wrong now, empty where nothing is."""
        if (words := without_numbers(trouble)) != self._words:
            self._words = words
            said = trouble if self._name in trouble else f"{self._name}: {trouble or 'well again'}"
            self._say(f"{datetime.now():%H:%M:%S}  {said}")


def without_numbers(text: str) -> str:
    """Return a text without its numbers."""
    return NUMBER.sub("", text)
