"""A widget that draws one value, and draws it again only when it is another."""

from typing import Generic, TypeVar

from textual.widget import Widget

T = TypeVar("T")


class ValueWidget(Widget, Generic[T]):
    """Holds ``value``; a subclass says in `render` how it looks. What is too long is cut unless it wraps."""

    DEFAULT_CSS = """
    ValueWidget { text-wrap: nowrap; text-overflow: ellipsis; }
    """

    def __init__(self, value: T, *, id: str | None = None) -> None:
        super().__init__(id=id)
        self.value = value

    def show(self, value: T) -> None:
        """Draw another value."""
        if value != self.value:
            self.value = value
            self.refresh(layout=self.styles.auto_dimensions)
