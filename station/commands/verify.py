"""``station verify``: what was recorded and stored against what is there."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._options import argument, option, signing_libraries
from station.commands._tamper_evidence import (
    anchor_faults,
    check_time_service,
    existing,
    keep,
    read_kept,
    refuse_missing,
    verify_signed,
    witness_text,
)
from station.text import plural

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from fixtures_db.database import Database as OpenDatabase
    from fixtures_db.hash_chain import ChainFault
    from station.results.certificate.signing.key_certificate import Trust


def verify(
    what: Annotated[
        Path | None,
        argument("[WHAT]", "A campaign's folder, calibration.json, certificate or export; else the database."),
    ] = None,
    trust: Annotated[
        list[Path] | None, option("ROOT.pem", "Of a signed file or a stamp: a root that is trusted; repeatable.")
    ] = None,
    crl: Annotated[
        list[Path] | None, option("FILE", "A list of what a root or those below it revoked; repeatable.")
    ] = None,
    laboratory: Annotated[
        Path | None, option("LAB.toml", "Trust also the roots of its [signature], and read its lists.")
    ] = None,
    anchor: Annotated[
        list[Path] | None,
        option("FILE", "Compare with an anchor file, or a stamped certificate's XML or PDF; repeatable."),
    ] = None,
    head: Annotated[
        str | None, option("SHA256", "Expect a row with this hash (6 digits or more) or journal code, as printed.")
    ] = None,
    to: Annotated[
        Path | None, option("FILE", "Write the chain heads to an anchor file.", names="--write-anchor")
    ] = None,
    stamp: Annotated[
        str | None, option("URL", "With --write-anchor: a service of RFC 3161 that stamps the file.")
    ] = None,
    db: Database = None,
) -> None:
    """Detect anything that was changed after it was accepted.

    With a folder: hash every recorded file again and compare with SHA256SUMS, written at acceptance, and with the
    database's rows, if it knows the campaign; error terms in force at its start are included. With an export of
    `station fixtures`: compare with the hash in it; with a calibration.json or the HTML of a certificate: find it
    in the database. Without: check the database's journal against each row of each table, its chains of
    calibrations, certificates, levels, error terms and accepted steps, its triggers and its file; compute the
    verdict of each calibration again from the limits of its day.

    With the XML or PDF of a certificate: check its signature, the key's certificate, time stamp, schema, chain and
    raw data. The network is not used: roots and revocation lists are files.

    A database restored to an older state is consistent in itself: only an anchor, a hash or a code kept elsewhere
    reveals it. A stamped anchor (`--stamp`) has the stamp next to it, FILE.tsr, which is checked with it. A
    certificate whose own time stamp covers the journal's code can be used too: `--anchor CERT.xml --trust
    ROOT.pem`.

    Exit code 1 names the first difference or missing item; 3 if there are no hashes to compare with.

    Example: station verify campaigns/2026-05-11
    """
    refuse_missing(db)
    check_time_service(stamp, "--stamp")
    if stamp is not None and to is None:
        raise typer.BadParameter("--stamp stamps an anchor; expected --write-anchor FILE")
    if stamp is not None:
        signing_libraries()
    if what is None and laboratory is None:
        typer.echo(_database(db, anchor or [], _trust(trust or [], crl or []), head, to, stamp))
    elif anchor or head or to or what is None:
        raise typer.BadParameter("--anchor, --head and --write-anchor are of the database; expected no folder")
    elif what.suffix.lower() in {".xml", ".pdf"}:
        verify_signed(what, trust or [], crl or [], laboratory, db)
    elif trust or crl or laboratory:
        raise typer.BadParameter(
            "--trust, --crl and --laboratory are of a certificate's .xml or .pdf; expected one"
        )
    elif what.is_file():
        typer.echo(_file(what, db))
    else:
        _folder(what, db)


def _file(file: Path, db: str | None) -> str:
    from station.files.database_files import seal_of

    if file.suffix not in {".json", ".html"}:
        return f"{file}: as written, sha256 {seal_of(file)[1]}"
    from fixtures_db.database import default_path, open_db
    from fixtures_db.errors import NotInDatabase
    from station.errors import Altered
    from station.files.sha256sums import sha256_of

    refuse_missing(str(default_path()) if db is None else db)  # a check makes no database
    found, kind = sha256_of(file), "calibration" if file.suffix == ".json" else "certificate"
    with open_db(db) as database, database.read() as session:
        try:
            text = _stored(session, kind, found)
        except NotInDatabase as error:
            raise Altered(file, f"sha256 {found}", f"that of a {kind} in {database.url}") from error
        return f"{file}: as stored in {database.url}, {text}"


def _stored(session: "Session", kind: str, sha256: str) -> str:
    from fixtures_db.issued_certificates import issued_as, issued_of, verify_issued
    from fixtures_db.stored_calibrations import calibration, verify_chain

    if kind == "calibration":
        number = calibration(session, sha256).id
        _refuse([one for one in verify_chain(session) if one.row == f"calibration {number}"])
        return f"calibration {number}"
    row = issued_as(session, sha256)
    _refuse([one for one in verify_issued(session) if one.row == f"issued certificate {row.id}"])
    certified = calibration(session, row.calibration_sha256).id
    _refuse([one for one in verify_chain(session) if one.row == f"calibration {certified}"])
    newest = issued_of(session, row.calibration_sha256)[-1]
    is_replaced = "" if newest.id == row.id else f"; replaced since by No. {newest.number}"
    return f"certificate No. {row.number} of {row.issued_utc:%Y-%m-%d}{is_replaced}"


def _folder(folder: Path, db: str | None) -> None:
    from fixtures_db.database import open_db
    from station.files.database_files import verify_csv

    names = verify_csv(folder)
    typer.echo(f"{folder}: {plural(len(names), 'file')} as recorded")
    if (where := existing(db)) is not None:
        with open_db(where) as database:
            typer.echo(_rows(database, folder))


def _database(
    db: str | None,
    anchors: list[Path],
    trust: "Trust | None",
    head: str | None,
    to: Path | None,
    stamp: str | None,
) -> str:
    from fixtures_db.database import open_db
    from fixtures_db.hash_chain import GENESIS
    from fixtures_db.journal import read_code
    from fixtures_db.journal_verification import missing_entry
    from fixtures_db.verification import missing_head, take_anchor

    # a new anchor is never put over one that shows a loss
    kept = read_kept([*anchors, *([to] if to is not None and to.exists() else [])], trust)
    head = head.strip().lower() if head is not None else None
    with open_db(db) as database, database.read() as session:
        _refuse(anchor_faults(session, kept))
        if head is not None and (code := read_code(head)) is not None:
            _refuse(missing_entry(session.connection(), code))
        elif head is not None:
            _refuse(missing_head(session, _whole(session, head)))
        now = take_anchor(session)
        text = [
            f"{database.url}: as stored{' and as in ' if anchors else ''}{', '.join(map(str, anchors))}; "
            f"newest calibration {'none' if now.calibration == GENESIS else now.calibration}",
            _journal_text(session, now.code),
            *([f"{head}: is there"] if head is not None else []),
            witness_text(kept, now.entries),
        ]
    if to is not None:
        keep(to, now, stamp)
        text.append(
            f"{to}: written{'' if stamp is None else ' and stamped'}; keep it in another place than this database"
        )
    return "\n".join(text)


def _journal_text(session: "Session", code: str) -> str:
    from fixtures_db.journal_verification import speaks_since

    begun, carried = speaks_since(session)
    before = f", with {plural(carried, 'row')} that stood then" if carried else ""
    return f"journal {code}: every change since {begun:%Y-%m-%d %H:%M} UTC{before}"


def _trust(roots: list[Path], lists: list[Path]) -> "Trust | None":
    if not roots:
        return None
    signing_libraries()
    from station.results.certificate.signing.key_certificate import read_trust

    return read_trust(roots, lists)


def _whole(session: "Session", head: str) -> str:
    """Return the one stored hash that begins so; ``head`` itself if none does."""
    from fixtures_db.verification import stored_hashes

    if not 6 <= len(head) <= 64 or not set(head) <= set("0123456789abcdef"):
        expected = "6 to 64 digits of a SHA-256 or the journal's code, as in 412-3a7d905cb1e6f204"
        raise typer.BadParameter(f"--head {head!r}: expected {expected}, as printed")
    found = {head} if len(head) == 64 else stored_hashes(session, head)
    if len(found) > 1:
        raise typer.BadParameter(f"--head {head}: {len(found)} rows begin so, expected one; give more digits")
    return found.pop() if found else head


def _rows(database: "OpenDatabase", folder: Path) -> str:
    """Compare the hashes of a folder, whose files agree with them, with the rows of its accepted steps."""
    import json

    from fixtures_db.campaigns import known_campaign, verify_steps
    from fixtures_db.stored_calibrations import newest_calibration
    from station.errors import Altered
    from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML
    from station.files.sha256sums import read_hashes, sha256_of

    key, hashes = str(folder.resolve()), read_hashes(folder)
    with database.read() as session:
        if (row := known_campaign(session, key)) is None:
            return f"{database.url} does not know this campaign: compared with SHA256SUMS alone"
        for step in row.steps:
            found = hashes.get(step.file, ("none", 0))[0]
            if found != step.sha256:
                raise Altered(folder / step.file, f"sha256 {found}", f"{step.sha256} in the database")
        _refuse(verify_steps(session, key))
        if row.effects_sha256 is not None:
            _compare_effects(folder, hashes, row.effects_sha256.split())
        newest = newest_calibration(session, key)
        inputs = {} if newest is None else json.loads(newest.document)["inputs"]
        if (kept := inputs.get(CAMPAIGN_TOML)) is not None and (now := sha256_of(folder / CAMPAIGN_TOML)) != kept:
            raise Altered(folder / CAMPAIGN_TOML, f"sha256 {now}", f"{kept} in the calibration")
        return f"{database.url}: {plural(len(row.steps), 'accepted step')} as stored"


def _compare_effects(folder: Path, hashes: Mapping[str, tuple[str, int]], begun_with: list[str]) -> None:
    """Compare the effects that a folder lists, whose files agree with their hashes, with those it began with."""
    from station.errors import Altered
    from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml

    listed = read_campaign_toml(folder)[0].effects
    found = [] if listed is None else [hashes[name][0] for name in listed.files]
    if found != begun_with:
        now, then = (" ".join(each) or "no effects" for each in (found, begun_with))
        raise Altered(folder / CAMPAIGN_TOML, now, then, "restore the folder from a copy")


def _refuse(faults: Sequence["ChainFault"]) -> None:
    from station.errors import DatabaseAltered

    if faults:
        first = faults[0]
        raise DatabaseAltered(first.row, first.found, first.expected)
