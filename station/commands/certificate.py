"""``station certificate``: a stored calibration as a certificate, or the list of what it still lacks."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._options import argument, day_option, flag, option
from station.commands._tamper_evidence import (
    Copy,
    check_copy,
    check_out,
    check_time_service,
    refuse_signed,
    signer,
    signing_key,
    write_copies,
)

if TYPE_CHECKING:
    from fixtures_db.database import Database as OpenDatabase
    from fixtures_db.schema import IssuedCertificateRow
    from station.results.certificate.laboratory import Laboratory


def certificate(
    calibration: Annotated[
        str | None,
        argument("[CALIBRATION]", "A calibration.json, a serial number, or the first digits of a hash."),
    ] = None,
    laboratory: Annotated[Path | None, option("LAB.toml", "The laboratory's file.")] = None,
    out: Annotated[Path | None, option("FILE.html", "Where to write; else NUMBER.html here.")] = None,
    pdf: Annotated[bool, flag("--pdf", "Also write a PDF; needs the extra `pdf`.")] = False,
    dcc: Annotated[bool, flag("--dcc", "Also the XML of a Digital Calibration Certificate.")] = False,
    customer: Annotated[str | None, option("NAME", "")] = None,
    customer_address: Annotated[str | None, option("TEXT", "")] = None,
    customer_email: Annotated[str | None, option("TEXT", "")] = None,
    received: Annotated[datetime | None, day_option("")] = None,
    condition: Annotated[str | None, option("TEXT", "Condition of the unit on receipt.")] = None,
    amend: Annotated[str, option("REASON", "Replace the earlier certificate; state the reason.")] = "",
    copy: Annotated[bool, flag("--copy", "Write the issued certificate again.")] = False,
    sign: Annotated[Path | None, option("KEY.p12", "Sign XML and PDF; needs the extra `sign`.")] = None,
    token: Annotated[str | None, option("URI", "Sign with a key on a token: pkcs11:...")] = None,
    timestamp: Annotated[str | None, option("URL", "A service of RFC 3161 that stamps it.")] = None,
    password_fd: Annotated[int | None, option("N", "Read the password or PIN there.")] = None,
    password_env: Annotated[str | None, option("NAME", "Or from this variable.")] = None,
    example: Annotated[bool, flag("--example", "Print a sample LAB.toml to edit.")] = False,
    db: Database = None,
) -> None:
    """Issue the certificate of a stored calibration: HTML for numbered A4 pages, and PDF on request.

    It states all that ISO/IEC 17025:2017, 7.8, requires: results with expanded uncertainty U, coverage factor k
    and degrees of freedom (count/(g s), ug, count/deg, deg/h, arcsec), conditions, references with due dates, as
    found and as left, conformity with decision rule and risk. If a reference has expired it is a measurement
    report. --dcc writes the same as XML, a Digital Calibration Certificate (PTB, 3.1.2; quantities in D-SI), with
    the covariance matrix and the budget; it is then attached to the PDF (PDF/A-3). The issued document is stored
    completely: `station verify FILE.html` finds it, --copy writes it again. --sign signs the XML (XAdES) and the
    PDF (PAdES) with the laboratory's key and asks for its password.

    Exit code 3 if anything is missing: everything missing is listed, with the option or file for it; 2 if PDF
    cannot be made, or options contradict each other.

    Example: station certificate --example > lab.toml

    Example: station certificate SIM-7 --laboratory lab.toml --received 2026-03-02 --condition "no damage seen"
    """
    from fixtures_db.database import open_db
    from station.errors import NoXml
    from station.results.certificate.issuing import copy_of

    if example:
        typer.echo(_example(), nl=False)
        return
    if calibration is None:
        raise typer.BadParameter(
            "found none, expected a calibration.json, a serial number or the first digits of a hash",
            param_hint="CALIBRATION",
        )
    if laboratory is None and not copy:
        raise typer.BadParameter(
            "found no --laboratory LAB.toml with the laboratory's data; print a sample to edit with "
            "`station certificate --example > lab.toml`"
        )
    if copy:
        names = ("--customer", "--customer-address", "--customer-email", "--received", "--condition", "--amend")
        values = (customer, customer_address, customer_email, received, condition, amend or None)
        check_copy(dict(zip(names, values, strict=True)))
    _check_files(out, timestamp, pdf, dcc, is_signed=sign is not None or token is not None)
    key = signing_key(sign, token, password_fd, password_env)  # before a number is given
    with open_db(db) as database:
        if copy or laboratory is None:
            row = copy_of(database, calibration)
        else:
            of_customer = {"name": customer, "address": customer_address, "email": customer_email}
            lab = _laboratory(laboratory, of_customer, received, condition)
            row = _issue(database, calibration, lab, amend, out, dcc)
    html = Path(f"{row.number}.html") if out is None else out
    if key is None:
        refuse_signed(_copy_paths(html, pdf, dcc))
    try:
        if dcc and row.dcc is None:
            raise NoXml(row.number)
        _write_html(row, html, copy)
        write_copies(_copies(row, html, pdf, dcc), None if key is None else signer(db, row.number, key, timestamp))
    finally:
        if key is not None:
            key.close()


def _check_files(out: Path | None, timestamp: str | None, pdf: bool, dcc: bool, *, is_signed: bool) -> None:
    """Raise `typer.BadParameter` or `CannotWrite` if the files asked for cannot be signed or written so."""
    check_out(out)
    check_time_service(timestamp)
    if timestamp is not None and not is_signed:
        raise typer.BadParameter("--timestamp stamps a signature; expected --sign KEY.p12 or --token URI")
    if is_signed and not (dcc or pdf):
        raise typer.BadParameter("--sign and --token sign the XML and the PDF; add --dcc, --pdf or both")
    if out is not None and not is_signed:
        refuse_signed(_copy_paths(out, pdf, dcc))


def _example() -> str:
    from importlib.resources import files

    return (files("station.results.certificate") / "laboratory_example.toml").read_text(encoding="utf-8")


def _copy_paths(html: Path, pdf: bool, dcc: bool) -> list[Path]:
    return [html.with_suffix(kind) for kind, asked in ((".xml", dcc), (".pdf", pdf)) if asked]


def _laboratory(
    file: Path, customer: dict[str, str | None], received: datetime | None, condition: str | None
) -> "Laboratory":
    from station.results.certificate.laboratory import read_laboratory

    lab = read_laboratory(file).given("customer", customer)
    return lab.given("item", {"received": received and received.date(), "condition": condition})


def _issue(
    database: "OpenDatabase", calibration: str, lab: "Laboratory", amend: str, out: Path | None, dcc: bool
) -> "IssuedCertificateRow":
    from station.errors import CannotWrite, Incomplete
    from station.results.certificate.issuing import issue

    if out is not None and not out.absolute().parent.is_dir():  # before a number is given
        raise CannotWrite(out, "no such folder")
    try:
        return issue(database, calibration, lab, amend, digital=dcc)
    except Incomplete as error:
        for field, where in error.missing:
            typer.echo(f"missing  {field:<34}{where}")
        raise


def _write_html(row: "IssuedCertificateRow", html: Path, copy: bool) -> None:
    from station.files.atomic_file import replace_file

    replaces = f", replaces No. {row.replaces}" if row.replaces else ""
    what = "copy of certificate" if copy else "certificate"
    typer.echo(f"{what} No. {row.number}{replaces}: sha256 {row.html_sha256}")
    replace_file(html, row.html.encode())
    typer.echo(f"{html}: written")


def _copies(row: "IssuedCertificateRow", html: Path, pdf: bool, dcc: bool) -> Iterator[Copy]:
    if dcc and row.dcc is not None:
        from station.results.certificate.dcc.digital_certificate import held_against

        xml = row.dcc.encode()
        yield html.with_suffix(".xml"), lambda _: xml, f", sha256 {row.dcc_sha256}; {held_against()}"
    if pdf:
        from station.results.certificate.rendering import pdf_of

        yield html.with_suffix(".pdf"), lambda is_signed: pdf_of(row, html, is_signed), ""
