"""Put hostile numbers, words and shapes in the place of values of every file that a user hands in.

Bad: exit 70, a warning, a control character or more than one line said, more than 30 s, a traceback.
"""

import contextlib
import io
import random
import signal
import sys
import tempfile
import tomllib
import unicodedata
import warnings
from pathlib import Path
from typing import Any

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from station import cli
from station.errors import BUG
from tests.benchmarks.hostile_values.files import Kind, kinds
from tests.benchmarks.hostile_values.values import mutants, toml_of
from tests.proof.evidence import Figure, zero
from tests.station.campaign_writing import write_campaign

LONGEST_S = 30


class TooLong(BaseException):
    """It takes longer than a person waits for a refusal."""


def judged(kind: Kind, path: Path) -> tuple[int, str]:
    """Return the exit code of taking a file in, and what is wrong with the answer, or nothing."""
    out, err = io.StringIO(), io.StringIO()
    with (
        warnings.catch_warnings(record=True) as warned,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        warnings.simplefilter("always")
        signal.alarm(LONGEST_S)
        try:
            code = kind.take(path)
        except TooLong:
            return -1, f"longer than {LONGEST_S} s"
        except Exception as error:
            return BUG, f"{type(error).__name__}: {error}"[:200]
        finally:
            signal.alarm(0)
    output = out.getvalue() + err.getvalue()
    if code == BUG:
        return code, err.getvalue()[-300:]
    if warned:
        return code, f"warning {warned[0].message}"[:200]
    if bad := sorted(
        {f"U+{ord(c):04X}" for c in output if c != "\n" and unicodedata.category(c) in ("Cc", "Cf", "Cs")}
    ):
        return code, f"control characters {bad}"
    if code and err.getvalue().count("\n") != 1:
        return code, f"{err.getvalue().count(chr(10))} lines on stderr: {err.getvalue()[:200]}"
    if code and max(map(len, err.getvalue().split("\n"))) > 2010:
        return code, f"a line of {len(err.getvalue())} characters"
    return code, ""


def _campaign(folder: Path) -> dict[str, Any]:
    """Write a small simulated campaign into a folder, and return its campaign.toml."""
    truth = Truth.example(1)
    write_campaign(folder, simulate_campaign(truth, 1, dwell_s=10.0), truth.sample_period_s)
    return tomllib.loads((folder / "campaign.toml").read_text())


def _fixtures(folder: Path) -> dict[str, Any]:
    db = ["--db", str(folder / "example.db")]
    with contextlib.redirect_stdout(io.StringIO()):
        cli.run(["fixtures", "list", "--db", str(folder / "empty.db")])
        cli.run(["fixtures", "example", "7", *db])
        code = cli.run(["fixtures", "export", str(folder / "fx.toml"), *db])
    if code:
        raise SystemExit(f"fixtures export: exit {code}")
    return tomllib.loads((folder / "fx.toml").read_text())


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Try ``size`` values of each kind of file, at keys drawn."""
    signal.signal(signal.SIGALRM, _too_long)
    result, tried = {}, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for label, kind in kinds(folder, _campaign(folder), _fixtures(folder)).items():
            files, bad = answered(kind, folder, random.Random(seed), size)
            tried += files
            result[f"{label}: answered badly, of {files}"] = zero(len(bad))
            sys.stderr.writelines(f"{label}: {each}\n" for each in bad)
    return {"files": Figure(tried), **result}


def answered(kind: Kind, folder: Path, rng: random.Random, size: int) -> tuple[int, list[str]]:
    """Return how many altered files of a kind were tried, and what was answered badly."""
    path, bad = folder / kind.name, list[str]()
    path.write_text(toml_of(kind.tables))
    if (right := judged(kind, path))[0]:
        raise SystemExit(f"{kind.name}: the file as it should be is answered {right}")
    every = list(mutants(dict(kind.tables)))
    for done, tables in rng.sample(every, min(size, len(every))):
        path.write_bytes(toml_of(tables).encode("utf-8", "surrogatepass"))
        code, wrong = judged(kind, path)
        if wrong:
            bad.append(f"{done!s}: exit {code}: {wrong!a}")
    return min(size, len(every)), bad


def _too_long(*_: object) -> None:
    raise TooLong
