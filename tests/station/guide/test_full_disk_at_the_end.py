"""A disk that is full when a campaign stops refuses the end of the receiver's file too: said once, in words."""

import errno
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from fixtures_db.database import Database
from station.errors import DiskFull
from station.files.mcap_files.fix_writer import FixWriter
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions


def test_what_cannot_be_closed_either_is_said_once(
    db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    writer = FixWriter(tmp_path / "gnss_1.mcap")
    engine = CalibrationEngine(db, CalibrationOptions(tmp_path), lambda view: None)
    room = SimpleNamespace(needed=5_000_000, free=0)
    engine._campaign = SimpleNamespace(disk=room, close=writer.close)  # type: ignore[assignment]  # noqa: SLF001
    monkeypatch.setattr(os, "fsync", refuse)
    engine._fail(DiskFull(tmp_path))  # noqa: SLF001
    assert engine.view.stage == "failed"
    assert "5 MB needed" in engine.view.error
