"""A process of `warm.py`, which has collected tests of a tree and runs any of them on demand."""

import json
import select
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from os import killpg
from pathlib import Path
from typing import IO, Any

from tests.mutation import warm
from tests.mutation.warm import COLLECT_S, TIMEOUT, WAITS


class Collected:
    """Tests collected in a process of its own.

    ``failed`` is the first file that could not be imported, ``as_imported`` the functions that imports call.
    """

    def __init__(self, tree: Path, tests: Sequence[str], environment: Mapping[str, str]) -> None:
        self.first = tests[0]
        self.process = subprocess.Popen(
            [sys.executable, "-P", warm.__file__, str(tree), *tests],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tree, env=environment,
            start_new_session=True,
        )  # fmt: skip
        answer = self._answer(WAITS * COLLECT_S)
        self.failed, self.as_imported = str(answer["failed"]), set[str](answer.get("as_imported", ()))

    def run(self, tests: Sequence[str], limit_s: float, **how: Any) -> dict[str, Any]:
        """Run tests until one fails, for some seconds of processor time; return its name as ``failed``, or ""."""
        to = self._pipe(self.process.stdin)
        print(json.dumps({"tests": tests, "limit_s": limit_s, "left_out": [], **how}), file=to, flush=True)
        return self._answer(WAITS * limit_s + 60.0)

    def end(self) -> None:
        """End the process and all that it has started."""
        killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self._pipe(self.process.stdin).close()
        self._pipe(self.process.stdout).close()

    def _answer(self, limit_s: float) -> dict[str, Any]:
        answers = self._pipe(self.process.stdout)
        if not select.select([answers], [], [], limit_s)[0]:
            return {"failed": TIMEOUT}
        answer: dict[str, Any] = json.loads(answers.readline() or json.dumps({"failed": self.first}))
        return answer

    @staticmethod
    def _pipe(pipe: IO[str] | None) -> IO[str]:
        assert pipe is not None
        return pipe
