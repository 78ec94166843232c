"""`station fixtures import FILE.xml`: a cube's and a slab's certificate enter the database, or are refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import cube
from fixtures_db.schema import CubeRow, SlabRow
from procedures.units import RAD_PER_ARCSEC
from station import cli
from station.results.certificate.signing.xml_signature import sign_xml
from tests.station.results.certificate.signing.authorities import issue, laboratory, revocations, root, rsa_key
from tests.station.results.certificate.signing.signed_files import key_of
from tests.station.results.certificate.signing.small_dcc import real, result, small_dcc

ARCSEC, SLOPE = "\\arcsecond", "\\micro\\metre\\per\\metre"
Y = result("tilt of x_up along y", real(1.2, ARCSEC, 1.0))
Z = result("measured value", real(-0.4, ARCSEC, 0.8), "fog_upTilt_x_up_z")
CORRELATION = result("correlation", real(0.25, "\\one", None), "fog_upTiltCovariance_x_up")
SIDE = result("Kantenlänge", real(400.0, "\\milli\\metre", 0.01))
EAST = result("Tilt East", real(3e-6, "\\radian", 1e-6))
NORTH = result("Neigung Nord", real(2.0, SLOPE, 1.0))
Run = Callable[..., tuple[int, str]]


@pytest.fixture
def take_in(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)
    root().pem(tmp_path, "root")

    def run(content: bytes, *more: str) -> tuple[int, str]:
        (tmp_path / "w.xml").write_bytes(content)
        code = cli.run(["fixtures", "import", "w.xml", *more, "--db", "s.db"])
        captured = capsys.readouterr()
        assert captured.err.count("\n") <= 1
        return code, captured.out + captured.err

    return run


def signed(*results: str, **said: str) -> bytes:
    return sign_xml(small_dcc(results, **said), key_of(laboratory()))


TRUSTED = ("--trust", "root.pem")


def test_a_cube_enters_with_its_covariance(take_in: Run) -> None:
    code, said = take_in(signed(Y, Z, CORRELATION, SIDE), *TRUSTED, "--due", "2027-03-04")
    assert code == 0, said
    assert "added certificate of x_up of cube CUBE-7 (Coordinate Laboratory Weber, certificate No. W-17" in said
    with open_db(Path("s.db")) as database, database.read() as session:
        face = cube(session, "CUBE-7").faces["x_up"]
        row = session.get_one(CubeRow, "CUBE-7")
        assert np.allclose(face.up_tilt, np.array([1.2, -0.4]) * RAD_PER_ARCSEC, rtol=1e-14, atol=0)
        expected = np.array([[0.25, 0.05], [0.05, 0.16]]) * RAD_PER_ARCSEC**2
        assert np.allclose(face.covariance, expected, rtol=1e-12, atol=0)
        assert row.side_mm == pytest.approx(400.0)
        assert (str(row.certificate_date), str(row.due_date)) == ("2026-03-04", "2027-03-04")
        source = row.certificates[0].source
        assert source == "Coordinate Laboratory Weber, certificate No. W-17, signed by CN=Laboratory of tests"


def test_a_covariance_may_be_given_in_the_unit_squared(take_in: Run) -> None:
    given = result("covariance of the up tilt of x_up", real(0.05, ARCSEC + "\\tothe{2}", None))
    assert take_in(signed(Y, Z, given, SIDE), *TRUSTED)[0] == 0
    with open_db(Path("s.db")) as database, database.read() as session:
        face = cube(session, "CUBE-7").faces["x_up"]
        assert face.covariance[0, 1] == pytest.approx(0.05 * RAD_PER_ARCSEC**2, rel=1e-12)


def test_a_slab_enters_as_a_level(take_in: Run) -> None:
    assert take_in(signed(EAST, NORTH, kind="Slab", item="SLAB-2"), *TRUSTED)[0] == 0
    with open_db(Path("s.db")) as database, database.read() as session:
        (level,) = session.get_one(SlabRow, "SLAB-2").levels
        assert (level.tilt_east_rad, level.tilt_north_rad) == pytest.approx((3e-6, 2e-6))
        assert (level.std_east_rad, level.std_north_rad) == pytest.approx((5e-7, 5e-7))


def test_the_due_date_in_the_document_is_taken(take_in: Run) -> None:
    statement = (
        '</dcc:customer><dcc:statements><dcc:statement refType="fog_dueDate"><dcc:date>2027-05-06</dcc:date>'
        "</dcc:statement></dcc:statements>"
    )
    document = small_dcc((Y, Z, SIDE)).replace(b"</dcc:customer>", statement.encode())
    assert take_in(sign_xml(document, key_of(laboratory())), *TRUSTED)[0] == 0
    with open_db(Path("s.db")) as database, database.read() as session:
        assert str(session.get_one(CubeRow, "CUBE-7").due_date) == "2027-05-06"


def test_one_certificate_is_taken_in_once(take_in: Run) -> None:
    assert take_in(signed(Y, Z, SIDE), *TRUSTED)[0] == 0
    code, said = take_in(signed(Y, Z, SIDE), *TRUSTED)
    assert code == 3
    assert "found No. W-17, which is in the database" in said
    assert take_in(signed(Y, Z, SIDE, number="W_17"), *TRUSTED)[0] == 0  # to a database _ is any letter


def test_a_due_date_that_was_not_said_may_be_said_later_once(take_in: Run) -> None:
    code, said = take_in(signed(Y, Z, SIDE), *TRUSTED)
    assert code == 0
    assert "without a due date" in said
    assert take_in(signed(Y, Z, SIDE), *TRUSTED, "--due", "2027-03-04")[0] == 0
    with open_db(Path("s.db")) as database, database.read() as session:
        assert str(session.get_one(CubeRow, "CUBE-7").due_date) == "2027-03-04"
    assert "nothing to do" in take_in(signed(Y, Z, SIDE), *TRUSTED, "--due", "2027-03-04")[1]
    assert "as due 2027-03-04" in take_in(signed(Y, Z, SIDE), *TRUSTED, "--due", "2028-03-04")[1]


def test_other_values_of_a_number_are_told(take_in: Run) -> None:
    assert take_in(signed(Y, Z, SIDE), *TRUSTED)[0] == 0
    other = result("tilt of x_up along y", real(1.3, ARCSEC, 1.0))
    assert "in the database with other values" in take_in(signed(other, Z, SIDE), *TRUSTED)[1]
    level = signed(EAST, NORTH, kind="Slab", item="SLAB-2", number="W-18")
    assert take_in(level, *TRUSTED)[0] == 0
    assert "nothing to do" in take_in(level, *TRUSTED)[1]


def test_unsigned_ones_are_taken_where_that_is_said_and_it_is_stored(take_in: Run) -> None:
    code, said = take_in(small_dcc((Y, Z, SIDE)))
    assert code == 3
    assert "author and integrity cannot be proved" in said
    assert take_in(small_dcc((Y, Z, SIDE)), "--unsigned")[0] == 0
    with open_db(Path("s.db")) as database, database.read() as session:
        assert session.get_one(CubeRow, "CUBE-7").certificates[0].source.endswith("imported unsigned")


def test_a_broken_signature_is_never_taken_for_none(take_in: Run) -> None:
    changed = signed(Y, Z, SIDE).replace(b"1.2</si:value>", b"1.3</si:value>")
    for more in ((), ("--unsigned",), TRUSTED):
        code, said = take_in(changed, *more)
        assert code == 3
        assert "found signature: it does not hold" in said


def test_a_key_that_is_not_trusted_or_revoked_is_refused(take_in: Run, tmp_path: Path) -> None:
    own = issue("Own", rsa_key(3))
    assert "self-signed, not trusted" in take_in(sign_xml(small_dcc((Y, Z, SIDE)), key_of(own)), *TRUSTED)[1]
    (tmp_path / "list").write_bytes(revocations(root(), laboratory()))
    assert "revoked on " in take_in(signed(Y, Z, SIDE), *TRUSTED, "--crl", "list")[1]
    assert not Path("s.db").exists()


REFUSED = {
    "unknown": ((Y, Z, result("flatness", real(1.0, ARCSEC, 1.0))), "'flatness': a quantity of no known refType"),
    "no U": ((Y, result("up tilt x_up z", real(1.0, ARCSEC, None))), "no expanded uncertainty U"),
    "unit": ((Y, result("up tilt x_up z", real(1.0, "\\metre", 1.0))), "a unit of metre, expected an angle"),
    "side": ((Y, Z, result("side", real(1.0, ARCSEC, 1.0))), "a unit of radian, expected a length"),
    "no unit": ((Y, result("up tilt x_up z", real(1.0, "\\second", 1.0))), "unit '\\second'"),
    "half": ((Y,), "found one component of the tilt of x_up, expected both"),
    "twice": ((Y, Y, Z), "the same quantity twice"),
    "both": ((Y, Z, EAST, NORTH), "found tilts of a surface plate and of a cube"),
    "correlation": ((Y, Z, result("c", real(1.5, "\\one", None), "fog_upTiltCovariance_x_up")), "correlation 1.5"),
    "nothing": ((SIDE,), "found no tilt of a cube's face or a surface plate"),
    "no side": ((Y, Z), "CUBE-7, which is not in the database, without its side"),
    "steep face": (
        (result("tilt of x_up along y", real(5.0, "\\radian", 0.1)), Z, SIDE),
        "rad, expected each under 0.1 rad",
    ),
    "steep": ((EAST, result("tilt north", real(0.5, "\\radian", 0.1))), "expected a tilt under 0.1 rad"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_known_is_refused_in_a_line(take_in: Run, name: str) -> None:
    results, words = REFUSED[name]
    code, said = take_in(signed(*results), *TRUSTED)
    assert code == 3
    assert words in said


@pytest.mark.parametrize("due", ["2026-03-03", "2020-01-01"])
def test_nothing_is_due_before_it_was_measured(take_in: Run, due: str) -> None:
    assert "expected 2026-03-04 or later" in take_in(signed(Y, Z, SIDE), *TRUSTED, "--due", due)[1]
