"""What `station simulate` refuses: the right exit code, the right file, the right noun."""

from pathlib import Path

import pytest

from station import cli
from tests.station.effect_examples import DEAD_ZONE


@pytest.mark.parametrize(
    "wrong",
    [
        ["--tcp", "99999"],
        ["--tcp", "-1"],
        ["--control", "99999"],
        ["--gnss", "udp:99999"],
        ["--gnss", "tcp:65536"],
        ["--gnss", "udpto"],
        ["--gnss", "udpto:127.0.0.1:0"],
        ["--gnss", "udpto:300.1.1.1:9999"],
        ["--transport", "slcan", "--format", "stim300"],
        ["--transport", "udp_multicast", "--format", "counts"],
        ["--dbc", "frames.dbc"],
    ],
)
def test_wrong_usage_is_2_and_one_line(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["simulate", *wrong]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def refused(tmp_path: Path, option: str, content: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return what is said of a file that is refused, without its path."""
    path = tmp_path / "file"
    path.write_text(content)
    assert cli.run(["simulate", option, str(path)]) == 3
    said = capsys.readouterr().err
    assert said.count(str(path)) == said.count("expected ") == said.count("found ") == 1
    return said.removeprefix(f"{path}: ")


def test_a_wrong_file_is_named_with_what_was_found_and_expected_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert refused(tmp_path, "--truth", "x = 1", capsys).startswith("found key 'x', expected serial, ")
    effect = '[effects."no.such"]\nx = 1\n'
    assert refused(tmp_path, "--truth", effect, capsys).startswith("found effect 'no.such', expected one of ")
    assert "expected t_s,e_m,n_m,u_m" in refused(tmp_path, "--track", "t\n1\n", capsys)
    for content in ("", "t_s,e_m,n_m,u_m\n", "t_s,e_m,n_m,u_m\n# none\n\n"):
        assert refused(tmp_path, "--track", content, capsys).startswith(
            "found no rows, expected two rows or more "
        )
    assert "is not finite" in refused(tmp_path, "--track", "t,e,n,u\n0,0,0,0\n1,nan,0,0\n", capsys)


def test_a_wrong_faults_file_is_named_with_the_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def told(content: str) -> str:
        said = refused(tmp_path, "--faults", good + content, capsys)
        return said.removeprefix(f"{tmp_path / 'file'}:")

    good = '[[fault]]\nkind = "lost"\nat_s = 1\n\n'  # the next stands in line 5
    fault = '[[fault]]\nkind = "x"\nat_s = 1\n'
    assert told(fault).startswith("5: found fault kind 'x', expected bad_crc, ")
    on_can = fault.replace('"x"', '"babble"')
    assert told(on_can).startswith("5: found fault kind 'babble' of a device not on CAN, expected bad_crc, ")
    assert told(f"[[gnss_fault]]\n{good}").startswith("5: found gnss_fault kind None, expected no_fix, ")
    assert told("[gnss_fault]\n").startswith("5: found gnss_fault = as it stands, expected a valid list")
    assert told("[[fault]\n").startswith("5: found no TOML (")


def test_a_track_that_is_not_there_is_a_csv_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["simulate", "--track", str(tmp_path / "nothere")]) == 3
    assert "expected a CSV file in UTF-8" in capsys.readouterr().err


def test_a_file_in_the_links_place_is_named_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "imu").write_text("mine")
    assert cli.run(["simulate", "--pty", str(tmp_path / "imu")]) == 4
    said = capsys.readouterr().err
    assert said.count(str(tmp_path / "imu")) == said.count("choose another") == 1


def test_an_effect_that_is_none_or_cannot_be_planted_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "column 1 of 'rain'" in refused(
        tmp_path, "--effect", DEAD_ZONE.replace("-u * exp(-(u / w)**4)", "rain"), capsys
    )
    file, truth = tmp_path / "effect.toml", tmp_path / "truth.toml"
    for blamed, term, sizes, expected in (
        (file, "-u * exp(-(u / w)**4) * north", "x = 1", "one moment: u, out, f, omega, B"),
        (truth, "-u * exp(-(u / w)**4)", "q = 1", "one of x, y, z, w"),
        (file, "u * exp(-(u / w)**4) / 0", "x = 1", "a term of finite numbers"),
        (truth, "u * exp(-(u / w)**4) * log((T - 26 [K]) / 1 [K])", "x = 1", "not finite at 0"),  # as it is served
    ):
        file.write_text(DEAD_ZONE.replace("-u * exp(-(u / w)**4)", term))
        truth.write_text(f'[effects."gyroscope.dead_zone"]\n{sizes}\n')
        assert cli.run(["simulate", "--truth", str(truth), "--effect", str(file)]) == 3
        *served, said = capsys.readouterr().err.strip().splitlines()
        assert said.startswith(f"{blamed}: ")
        assert expected in said
        assert all(line.startswith("serving ") for line in served)


def test_an_effect_that_is_none_for_a_moment_is_named_with_what_there_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, truth = tmp_path / "effect.toml", tmp_path / "truth.toml"
    file.write_text(DEAD_ZONE.replace("-u * exp(-(u / w)**4)", "-u * exp(-(u / w)**4) * north"))
    truth.write_text('[effects."gyroscope.dead_zone"]\nx = 1\n')
    assert cli.run(["simulate", "--truth", str(truth), "--effect", str(file)]) == 3
    said = capsys.readouterr().err
    assert said.startswith(f"{file}: found north in a term")
    assert "T, T_rate, t, t_step, pi, a parameter, lag(T, tau)" in said


def test_an_effect_whose_sizes_the_truth_does_not_have_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, truth = tmp_path / "effect.toml", tmp_path / "truth.toml"
    file.write_text(DEAD_ZONE)
    truth.write_text("")
    for of in (["--truth", str(truth)], ["--example", "7"]):
        assert cli.run(["simulate", *of, "--effect", str(file)]) == 3
        said = capsys.readouterr().err
        assert (
            'found no sizes of gyroscope.dead_zone, expected [effects."gyroscope.dead_zone"] with x, y, z, w'
            in said
        )
