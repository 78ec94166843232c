"""A widget that draws one value, and draws it again only when it is another."""

from typing import Generic, TypeVar

from textual.content import Content
from textual.widget import Widget

T = TypeVar("T")


class ValueWidget(Widget, Generic[T]):
    """Holds ``value``; a subclass says in `_drawn` how it looks. What is too long is cut unless it wraps."""

    DEFAULT_CSS = "ValueWidget { text-wrap: nowrap; text-overflow: ellipsis; }"

    def __init__(self, value: T | None = None, *, id: str | None = None) -> None:
        super().__init__(id=id)
        self.value = value

    def show(self, value: T | None) -> None:
        """Draw another value."""
        if value != self.value:
            self.value = value
            self.refresh(layout=self.styles.auto_dimensions)

    def render(self) -> Content:
        """Draw the value, nothing while there is none."""
        return Content("") if self.value is None else self._drawn(self.value)

    def _drawn(self, value: T) -> Content:
        """Return how a value looks."""
        raise NotImplementedError
