"""What is altered, dropped or reordered, `station verify` finds.

A campaign is recorded, solved and stored, fixtures are certified. Then one thing at a time is changed: a byte, a
line or two lines of the calibration's file, of a certificate, of an export or of the recording's files; a file.
Harmless is what reads as it did before: two lines of SHA256SUMS in another order.
"""

import random
import tempfile
from collections import Counter
from pathlib import Path

from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import dump
from fixtures_db.stored_calibrations import accept_calibration
from station.files.database_files import to_toml, write_csv
from station.files.sha256sums import read_hashes
from station.results.campaign_results import make_results, store
from station.results.certificate.issuing import issue
from tests.fixtures_db.factory import facts, fill_fixtures, solution
from tests.proof.evidence import Figure, zero
from tests.station.commands.program import quietly
from tests.station.guide.stored import recorded
from tests.station.results.certificate.factory import accepted, laboratory


class Station:
    """A station's database and files, whole; each mutation is taken back."""

    def __init__(self, home: Path, chance: random.Random) -> None:
        self.home, self.chance = home, chance
        self.folder = home / "campaign"
        with open_db(home / "station.db") as database:
            recorded(self.folder, database)
            store(make_results(self.folder, database), database)
            with database.write() as session:
                fill_fixtures(session)
                for i in range(4):
                    accept_calibration(session, solution(i * 1e-3), facts(f"S{i % 2}"))
                for _ in range(2):
                    accepted(session)
            self.certificate = home / "certificate.html"
            for why in ("", "the customer's address was wrong"):
                self.certificate.write_text(issue(database, "S0101", laboratory(), why).html)
            with database.read() as session:
                rows = dump(session)
            (home / "export.toml").write_text(to_toml(rows))
            write_csv(home / "export", rows)

    def in_file(self) -> str:
        """Change a file and take it back."""
        toml, export, document = self.home / "export.toml", self.home / "export", self.folder / "calibration.json"
        recording = [self.folder / name for name in ("campaign.toml", "SHA256SUMS", *read_hashes(self.folder))]
        exported, issued = (export, list(export.iterdir())), (self.certificate, [self.certificate])
        what, files = self.chance.choice(
            ((toml, [toml]), exported, (self.folder, recording), (document, [document]), issued)
        )
        file = self.chance.choice(sorted(files))
        content = file.read_bytes()
        how = self.chance.choice((self._byte, self._cut, self._dropped_line, self._swapped_lines, None))
        if how is None:
            file.unlink()
        else:
            file.write_bytes(how(content))
        is_same = how is not None and file.read_bytes() == content
        is_reordered = file.name == "SHA256SUMS" and how == self._swapped_lines
        found = quietly("verify", what, "--db", self.home / "station.db")[0] != 0
        file.write_bytes(content)
        missed = f"MISSED in {file.name}, {how.__name__ if how else 'dropped'}"
        return "found" if found else "harmless" if is_same or is_reordered else missed

    def _byte(self, content: bytes) -> bytes:
        at = self.chance.randrange(len(content))
        return content[:at] + bytes([content[at] ^ (1 << self.chance.randrange(8))]) + content[at + 1 :]

    def _cut(self, content: bytes) -> bytes:
        return content[: self.chance.randrange(len(content))]

    def _dropped_line(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True)
        del lines[self.chance.randrange(len(lines))]
        return b"".join(lines)

    def _swapped_lines(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True)
        i, j = self.chance.randrange(len(lines)), self.chance.randrange(len(lines))
        lines[i], lines[j] = lines[j], lines[i]
        return b"".join(lines)


def mutate(home: Path, times: int, seed: int = 1) -> Counter[str]:
    """Return how many mutations were found, harmless or missed."""
    station = Station(home, random.Random(seed))
    return Counter(station.in_file() for _ in range(times))


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Change ``size`` things, one at a time."""
    with tempfile.TemporaryDirectory() as home:
        outcome = mutate(Path(home), size, seed)
    found, harmless = outcome["found"], outcome["harmless"]
    return {
        "found": Figure(found), "without effect": Figure(harmless), "missed": zero(size - found - harmless),
    }  # fmt: skip
