"""What lies over a screen until it is answered, or no longer fits what goes on."""

from collections.abc import Collection
from typing import Generic, TypeVar

from textual.await_complete import AwaitComplete
from textual.screen import ModalScreen

from station.guide.view import CalibrationView

T = TypeVar("T")
MIN_COLUMNS = 80  # of a terminal; narrower, as a telephone, parts stand below each other


class Modal(ModalScreen[T], Generic[T]):
    """A modal that makes sense in ``stages``; the application closes it in any other."""

    DEFAULT_CSS = """
    Modal { align: center middle; }
    Modal > .box {
        width: auto; max-width: 74; height: auto; max-height: 90%;
        padding: 1 2; background: $surface; border: round $primary;
    }
    Modal > .box VerticalScroll { height: auto; max-height: 16; }
    Modal > .box Label { width: auto; max-width: 66; height: auto; margin-bottom: 1; }
    Modal.-phone > .box Label { max-width: 36; }
    """
    HORIZONTAL_BREAKPOINTS = [(0, "-phone"), (MIN_COLUMNS, "-narrow")]

    def __init__(self, stages: Collection[str] = ()) -> None:
        super().__init__()
        self._stages = stages

    def fits(self, view: CalibrationView) -> bool:
        """Return whether the modal still makes sense."""
        return view.stage in self._stages

    def dismiss(self, result: T | None = None) -> AwaitComplete:
        """Close, once: the next key may wait already, and Textual would close what lies below."""
        return super().dismiss(result) if self.is_active else AwaitComplete()
