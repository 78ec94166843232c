"""Hostile values at keys of files handed in: a result or one line, never a bug; all of them: the benchmark."""

import contextlib
import io
import random
import signal
from pathlib import Path

import pytest

from station import cli
from tests.benchmarks.hostile_values.__main__ import judged
from tests.benchmarks.hostile_values.files import kinds
from tests.benchmarks.hostile_values.toml_of import toml_of
from tests.benchmarks.hostile_values.values import mutants

TRIED = 12  # of a kind: those of seed 5; all of them are a proof
QUICK = ("plan", "limits", "effect", "laboratory", "faults", "scenario", "calibration_scenario")


@pytest.mark.parametrize("label", QUICK)
def test_no_value_is_answered_by_a_bug(label: str, tmp_path: Path) -> None:
    db = ["--db", str(tmp_path / "empty.db")]
    with contextlib.redirect_stdout(io.StringIO()):
        assert cli.run(["fixtures", "list", *db]) == 0
    kind = kinds(tmp_path, {}, {})[label]
    path, rng = tmp_path / kind.name, random.Random(5)
    path.write_text(toml_of(kind.tables))
    assert judged(kind, path) == (0, "")
    all_of_them = list(mutants(dict(kind.tables)))
    for done, tables in rng.sample(all_of_them, TRIED):
        path.write_bytes(toml_of(tables).encode("utf-8", "surrogatepass"))
        assert judged(kind, path)[1] == "", f"{done}: STATION_TRACEBACK=1 shows where"
    assert signal.alarm(0) == 0
