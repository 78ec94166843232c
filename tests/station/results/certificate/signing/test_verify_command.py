"""`station verify FILE` of signed certificates: a line for each thing looked at, exit code 1 where one fails."""

from pathlib import Path

import pytest

from station import cli
from tests.station.results.certificate.signing.authorities import laboratory, revocations, root
from tests.station.results.certificate.signing.small_dcc import small_dcc

Bilingual = tuple[int, str, str]


@pytest.fixture
def folder(tmp_path: Path, files: tuple[bytes, bytes], monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    for name, content in zip(("signed.xml", "signed.pdf"), files, strict=True):
        (tmp_path / name).write_bytes(content)
    root().pem(tmp_path, "root")
    return tmp_path


def verify(capsys: pytest.CaptureFixture[str], *arguments: str) -> Bilingual:
    code = cli.run(["verify", *arguments])
    captured = capsys.readouterr()
    assert captured.err.count("\n") <= 1
    return code, captured.out, captured.err


@pytest.mark.parametrize("name", ["signed.xml", "signed.pdf"])
def test_what_holds_is_reported_in_a_line_each(
    folder: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = verify(capsys, name, "--trust", "root.pem")
    assert code == 0
    assert "signature  " in out
    assert "holds: the " in out
    assert "CN=Laboratory of tests, valid " in out
    assert "by CN=Time of tests: trusted by CN=Root of tests" in out
    assert "valid by DCC 3.1.2 and D-SI" in out
    assert not list((folder / "data").rglob("*.db"))  # a check makes no database


def test_a_key_that_nobody_trusts_is_code_1(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, error = verify(capsys, "signed.xml")
    assert code == 1
    assert "no trusted root is given" in out
    assert error.startswith("signed.xml: found key CN=Laboratory of tests") or "found key" in error


def test_a_file_that_is_no_pdf_is_code_3(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "cut.pdf").write_bytes((folder / "signed.pdf").read_bytes()[:500])
    code, _, error = verify(capsys, "cut.pdf")
    assert code == 3
    assert "cut.pdf: found no whole PDF" in error
    (folder / "text.pdf").write_bytes(b"a text\n")
    code, _, error = verify(capsys, "text.pdf")
    assert code == 3
    assert "text.pdf: found no PDF, expected a certificate's PDF" in error


def test_a_changed_document_is_reported_in_words(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = (folder / "signed.xml").read_bytes()
    (folder / "signed.xml").write_bytes(content.replace(b"<si:value>1.2<", b"<si:value>1.3<"))
    assert "it does not hold: what is signed was changed" in verify(capsys, "signed.xml")[2]
    both = content.replace(b"</ds:Signature>", b"</ds:Signature><ds:Signature/>")
    (folder / "signed.xml").write_bytes(both)
    assert verify(capsys, "signed.xml")[2].count("found") == 1


def test_a_revoked_key_is_reported(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "list.crl").write_bytes(revocations(root(), laboratory()))
    code, _, error = verify(capsys, "signed.xml", "--trust", "root.pem", "--crl", "list.crl")
    assert code == 1
    assert "revoked on " in error


def test_what_was_never_signed_is_reported_to_prove_nothing(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "plain.xml").write_bytes(small_dcc())
    code, _, error = verify(capsys, "plain.xml")
    assert code == 1
    assert "author and integrity cannot be proved" in error


@pytest.mark.parametrize(
    ("content", "reported"),
    [
        (b"<!DOCTYPE a [<!ENTITY x SYSTEM 'file:///etc/passwd'>]><a>&x;</a>", "a DTD or entities"),
        (b"<a/>", "element a"),
    ],
)
def test_what_is_no_certificate_is_refused(
    folder: Path, content: bytes, reported: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "bad.xml").write_bytes(content)
    code, _, error = verify(capsys, "bad.xml")
    assert code == 3
    assert reported in error


def test_large_files_are_refused_unread(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("large.xml", "large.pdf"):
        with (folder / name).open("wb") as stream:
            stream.truncate(100_000_000)
        code, _, error = verify(capsys, name)
        assert code == 3
        assert "found 100 MB, expected 32 MB at most" in error


def test_the_laboratory_file_names_roots_and_lists(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = folder / "lab" / "lab.toml"
    file.parent.mkdir()
    root().pem(file.parent, "root")
    (file.parent / "root.crl").write_bytes(revocations(root()))
    file.write_text(
        'format = "laboratory/1"\n[signature]\nroots = ["root.pem"]\nrevocation_lists = ["root.crl"]\n'
    )
    code, out, _ = verify(capsys, "signed.xml", "--laboratory", str(file))
    assert code == 0
    assert "key         CN=Laboratory of tests" in out
    assert "no revocation list checked" not in out
    (file.parent / "root.crl").write_bytes(revocations(root(), laboratory()))
    assert verify(capsys, "signed.xml", "--laboratory", str(file))[0] == 1
