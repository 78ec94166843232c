"""What a worker tells of a test that passes: that it did, and that the next may come, not each of its steps.

Six messages a test cost three tenths of the processor time of short tests. Its beginning, its end, and a set-up
and a teardown that passed and say nothing are seen in times alone: `make slowest` has no workers.
"""

from typing import Any

import pytest

UNSEEN = ("logstart", "logfinish")


def is_seen(name: str, told: dict[str, Any]) -> bool:
    """Whether a message of a worker changes what is shown or counted."""
    return not _is_silent(told["data"]) if name == "testreport" else name not in UNSEEN


def _is_silent(report: dict[str, Any]) -> bool:
    """Whether a step passed beside its test's call, and nothing was printed, set or counted of it."""
    if report["when"] == "call" or report["outcome"] != "passed":
        return False
    # what the step of a test that failed printed is shown
    printed = any(report["when"] in title for title, _ in report["sections"])
    return not (printed or report["user_properties"] or any(key.startswith("_hypothesis") for key in report))


def send_what_is_seen(config: pytest.Config) -> bool:
    """Let a worker of pytest-xdist send no other messages; say whether this process is one."""
    # a class of a module that is no file here
    workers = [each for each in config.pluginmanager.get_plugins() if type(each).__name__ == "WorkerInteractor"]
    for each in workers:
        _send_what_is_seen(each)
    return bool(workers)


def _send_what_is_seen(worker: Any) -> None:
    send = worker.sendevent

    def sendevent(name: str, **told: Any) -> None:
        if is_seen(name, told):
            send(name, **told)

    worker.sendevent = sendevent
