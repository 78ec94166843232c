"""Put hostile values in the place of every value of every file handed in; list what is answered badly.

    python -m tests.benchmarks.hostile_values [KIND ...] [--share 0.1] [--seed 1]

Bad: exit 70, a warning, a control character or more than one line said, more than 30 s, a traceback.
"""

import argparse
import contextlib
import io
import random
import signal
import sys
import tempfile
import tomllib
import unicodedata
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

from station import cli
from station.exit_codes import BUG
from tests.benchmarks.hostile_values.files import Kind, kinds
from tests.benchmarks.hostile_values.toml_of import toml_of
from tests.benchmarks.hostile_values.values import mutants

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
    said = out.getvalue() + err.getvalue()
    if code == BUG:
        return code, err.getvalue()[-300:]
    if warned:
        return code, f"warning {warned[0].message}"[:200]
    if bad := sorted(
        {f"U+{ord(c):04X}" for c in said if c != "\n" and unicodedata.category(c) in ("Cc", "Cf", "Cs")}
    ):
        return code, f"control characters {bad}"
    if code and err.getvalue().count("\n") != 1:
        return code, f"{err.getvalue().count(chr(10))} lines on stderr: {err.getvalue()[:200]}"
    if code and max(map(len, err.getvalue().split("\n"))) > 2010:
        return code, f"a line of {len(err.getvalue())} characters"
    return code, ""


def _campaign(folder: Path, source: Path) -> dict[str, Any]:
    for each in source.glob("*.csv"):
        lines = each.read_text().splitlines(keepends=True)
        (folder / each.name).write_text("".join(lines if each.name.startswith("turn") else lines[:400]))
    return tomllib.loads((source / "campaign.toml").read_text())


def _fixtures(folder: Path) -> dict[str, Any]:
    db = ["--db", str(folder / "example.db")]
    with contextlib.redirect_stdout(io.StringIO()):
        cli.run(["fixtures", "list", "--db", str(folder / "empty.db")])
        cli.run(["fixtures", "example", "7", *db])
        code = cli.run(["fixtures", "export", str(folder / "fx.toml"), *db])
    if code:
        raise SystemExit(f"fixtures export: exit {code}")
    return tomllib.loads((folder / "fx.toml").read_text())


def main(arguments: list[str]) -> int:
    """Try them; return 1 if any is answered badly."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.hostile_values")
    parser.add_argument("kinds", nargs="*")
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--campaign", type=Path, help="a folder whose campaign.toml is altered")
    told = parser.parse_args(arguments)
    signal.signal(signal.SIGALRM, _too_long)
    rng, bad = random.Random(told.seed), 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        campaign = _campaign(folder, told.campaign) if told.campaign else {}
        for label, kind in kinds(folder, campaign, _fixtures(folder)).items():
            if (told.kinds and label not in told.kinds) or not kind.tables:
                continue
            bad += _try(label, kind, folder, rng, told.share)
    return 1 if bad else 0


def _try(label: str, kind: Kind, folder: Path, rng: random.Random, share: float) -> int:
    codes, bad = Counter[int](), 0
    path = folder / kind.name
    path.write_text(toml_of(kind.tables))
    if (right := judged(kind, path))[0]:
        raise SystemExit(f"{label}: the file as it should be is answered {right}")
    for done, tables in mutants(dict(kind.tables)):
        if rng.random() > share:
            continue
        path.write_bytes(toml_of(tables).encode("utf-8", "surrogatepass"))
        code, wrong = judged(kind, path)
        codes[code] += 1
        if wrong:
            bad += 1
            print(f"{label}: {done!s}: exit {code}: {wrong!a}", flush=True)
    print(
        f"{label}: {codes.total()} files, exit codes {dict(sorted(codes.items()))}, answered badly {bad}",
        flush=True,
    )
    return bad


def _too_long(*_: object) -> None:
    raise TooLong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
