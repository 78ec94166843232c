"""What a worker tells of a test that passes: that it did, and that the next may come, not each of its steps.

Six messages a test cost a tenth of the processor time of short tests. The beginning, the end, and a set-up and a
teardown that passed are shown nowhere; `--durations` is asked without workers (`make slowest`).
"""

from typing import Any

import pytest

UNSEEN = ("logstart", "logfinish")


def is_seen(name: str, told: dict[str, Any]) -> bool:
    """Whether a message of a worker changes what is shown or counted."""
    if name == "testreport":
        return (told["data"]["when"], told["data"]["outcome"]) not in (("setup", "passed"), ("teardown", "passed"))
    return name not in UNSEEN


def send_what_is_seen(config: pytest.Config) -> None:
    """Let a worker of pytest-xdist send no other messages; whoever is none stays as it is."""
    for plugin in config.pluginmanager.get_plugins():
        if type(plugin).__name__ == "WorkerInteractor":  # a class of a module that is no file here
            _send_what_is_seen(plugin)


def _send_what_is_seen(worker: Any) -> None:
    send = worker.sendevent

    def sendevent(name: str, **told: Any) -> None:
        if is_seen(name, told):
            send(name, **told)

    worker.sendevent = sendevent
