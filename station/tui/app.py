"""The application: draws the session's view and sends what the operator asks. It knows nothing by itself."""

from station.guide.view import CalibrationSession, CalibrationView, OperatorCommand
from station.tui.common_app import CommonApp
from station.tui.screens import screen_for
from station.tui.screens.modals import ANSWER_LATER, Modal, QuestionScreen
from station.tui.screens.stage import StageScreen


class StationApp(CommonApp):
    """The screens of one session, from which views come and to which commands go."""

    def __init__(self, session: CalibrationSession, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__(refresh_hz=refresh_hz, is_quiet=is_quiet)
        self._session = session
        self._view: CalibrationView | None = None
        self._base: StageScreen | None = None
        self._postponed: object = None  # the question that was put off

    def pull(self) -> None:
        """Show the session's view if it is another."""
        view = self._session.view
        if view is not self._view:
            self.ring(view.events, is_first=self._view is None)
            self._view = view
        self._close_outdated_modals(view)
        self._show(view)
        self._ask(view)

    def _close_outdated_modals(self, view: CalibrationView) -> None:
        is_other = not isinstance(self._base, screen_for(view.stage))
        while len(self.screen_stack) > 2:
            top = self.screen
            if top.fits(view) if isinstance(top, Modal) else not is_other:
                return
            self.pop_screen()

    def _show(self, view: CalibrationView) -> None:
        """Show the view on its screen; a modal that fits keeps the screen under it until it is answered."""
        wanted = screen_for(view.stage)
        if self._base is None or self._base not in self.screen_stack:
            self._base = wanted(self._session.send)
            self.push_screen(self._base)
        elif not isinstance(self._base, wanted) and self.screen is self._base:
            self._base = wanted(self._session.send)
            self.switch_screen(self._base)
        if self._base.view is not view:
            self._base.show(view)

    def _ask(self, view: CalibrationView) -> None:
        question = view.question
        if question is None:
            self._postponed = None
        elif question != self._postponed and self.screen is self._base:
            self._postponed = question
            self.push_screen(QuestionScreen(question), self._answer)

    def action_ask(self) -> None:
        """Ask the question that was put off."""
        self._postponed = None

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer to answer while there is a question."""
        return self._session.view.question is not None if action == "ask" else True

    def _answer(self, key: str | None) -> None:
        if key not in (None, ANSWER_LATER):
            self._session.send(OperatorCommand(verb="answer", key=key))
