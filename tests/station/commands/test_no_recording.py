"""A replay of a file that is no recording is refused as such; it is not called cancelled."""

from pathlib import Path

import pytest

from station import cli

NOT_ONE = "t_s,roll_rad,pitch_rad\n" + "0.01,0.1,0.2\n" * 100


@pytest.mark.parametrize("options", ["", "?format=counts"])
@pytest.mark.parametrize("content", ["", NOT_ONE])
@pytest.mark.parametrize("fusion", [False, True])
def test_record_refuses_it_and_leaves_nothing(
    options: str, content: str, fusion: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "s.csv").write_text(content)
    also = ["--fusion", str(tmp_path / "f")] if fusion else []
    assert cli.run(["record", f"replay:{tmp_path / 's.csv'}{options}", "--out", str(tmp_path / "r"), *also]) == 3
    out, error = capsys.readouterr()
    assert (out, error.count("\n")) == ("", 1)
    assert f"s.csv: found {len(content)} bytes" in error
    assert [path.name for path in tmp_path.iterdir() if path.name != "configuration"] == ["s.csv"]
