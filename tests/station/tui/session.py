"""A session in memory: holds a view, keeps what was sent."""

from station.guide.command import Command
from station.guide.view import View


class MemorySession:
    """A `station.guide.session.Session` without an engine."""

    def __init__(self, view: View) -> None:
        self.view = view
        self.sent: list[Command] = []

    def send(self, command: Command) -> None:
        self.sent.append(command)
