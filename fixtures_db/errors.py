"""What the database can refuse.

DatabaseError
├── NotInDatabase      no row of that name
├── AlreadyThere       a row of that name exists
├── InForceAlready     the same error term is in force there
├── NotInForce         no error term of that name is in force there
├── DiffersFromStored  a row to be imported is there with another value
├── CampaignInUse      a campaign cannot be removed: a calibration was stored from it
├── AlreadyStored      the same calibration of the same campaign is stored
├── LimitsChanged      a verdict is against limits that are no longer those of the model
├── NewerDatabase      the schema was made by a newer station
├── SchemaAltered      its schema version is gone, foreign, or not that of its tables
├── NotADatabase       the file or URL cannot be opened as a database
├── NotWritten         the disk is full or refuses
└── DatabaseBusy       another process held the write lock for too long
"""

from collections.abc import Sequence

from procedures.errors import ErrorCode


class DatabaseError(Exception):
    """The base of all that ``fixtures_db`` raises on purpose; nothing was written."""

    code = ErrorCode.DATABASE


class NotInDatabase(DatabaseError, LookupError):
    """No row of that name; ``known`` are some that are there.

    Example: a campaign names ``CUBE-8`` where the database has ``CUBE-7`` alone.
    """

    def __init__(self, kind: str, name: str, known: Sequence[str] = ()) -> None:
        there = f"it has {', '.join(known)}" if known else "it has none"
        super().__init__(f"no {kind} {name!r} in the database ({there}); add it first or check the name")


class AlreadyThere(DatabaseError, ValueError):
    """A row of that name exists already.

    Example: `station fixtures add cube CUBE-7` a second time.
    """

    def __init__(self, kind: str, name: str) -> None:
        super().__init__(f"{kind} {name!r} is in the database already; choose another name")


class InForceAlready(DatabaseError, ValueError):
    """The same bytes are in force as an error term of ``owner``, in words.

    Example: the same file is added to the same model twice.
    """

    def __init__(self, owner: str, name: str) -> None:
        super().__init__(f"effect {name!r} of {owner} is in force already with these bytes; nothing to do")


class NotInForce(DatabaseError, LookupError):
    """No error term of that name is in force for ``owner``, in words; ``known`` are.

    Example: one unit's term is withdrawn by the name of its model.
    """

    def __init__(self, owner: str, name: str, known: Sequence[str]) -> None:
        there = ", ".join(known) or "none"
        super().__init__(
            f"effect {name!r} of {owner} is not in force, expected one that is ({there}); check the name, or "
            f"whether it is of the model or of one unit: `station effects list`"
        )


class DiffersFromStored(DatabaseError, ValueError):
    """A row to be imported is there already, with another value of ``column``; nothing was changed.

    Example: an exported folder whose ``side_mm`` of a cube was edited.
    """

    def __init__(self, kind: str, name: str, column: str, found: object, stored: object) -> None:
        super().__init__(
            f"{kind} {name!r}: found {column} {found}, expected {stored} as in the database; "
            f"correct the file or give it another name"
        )


class CampaignInUse(DatabaseError, ValueError):
    """A campaign cannot be removed: a calibration was stored from it, and those stay.

    Example: a finished campaign is cancelled.
    """

    def __init__(self, folder: str) -> None:
        super().__init__(f"campaign {folder!r}: a calibration was stored from it, expected none; it stays")


class AlreadyStored(DatabaseError, ValueError):
    """A campaign's calibration with the same numbers is stored; ``sha256`` is that one's.

    Example: an operator accepts the same result twice.
    """

    def __init__(self, folder: str, sha256: str) -> None:
        self.sha256 = sha256
        super().__init__(
            f"campaign {folder!r}: the same calibration is stored as {sha256[:12]}..., expected a new one; "
            f"`station history` lists it"
        )


class LimitsChanged(DatabaseError, ValueError):
    """A verdict was found against limits that are no longer those of the model; nothing was stored.

    Example: limits were imported between solving and accepting.
    """

    def __init__(self, model: str) -> None:
        super().__init__(
            f"limits of {model}: found others than the verdict was made by, expected the same; solve the campaign "
            f"again (`station resume`), then store it"
        )


class NewerDatabase(DatabaseError):
    """The schema was made by a newer station than this one.

    Example: two stations share a database and only one was updated.
    """

    def __init__(self, url: str, found: str, expected: str) -> None:
        super().__init__(f"{url}: schema {found}, this station knows up to {expected}; update the station")


class SchemaAltered(DatabaseError):
    """The schema version is gone, doubled, foreign, or not that of the tables.

    Example: ``--db`` names the database of another program.
    """

    def __init__(self, url: str, found: str, expected: str) -> None:
        super().__init__(
            f"{url}: found {found}, expected {expected}; name the station's own database by --db; if this is it, "
            f"it was changed past the station: restore it from a copy"
        )


class NotADatabase(DatabaseError, OSError):
    """The file or URL cannot be opened as a database.

    Example: ``--db`` names a text file, or the PostgreSQL server is off.
    """

    def __init__(self, url: str, reason: str) -> None:
        more = ", and whether you may write there and there is room" if "unable to open" in reason else ""
        super().__init__(f"{url}: cannot be opened as a database ({reason}); check --db or STATION_DB{more}")


class NotWritten(DatabaseError, OSError):
    """The database could not be written; it is as it was before.

    Example: the disk is full.
    """

    def __init__(self, url: str, reason: str) -> None:
        if "full" in reason or "No space" in reason:  # as SQLite and PostgreSQL say it
            text = "disk full, expected room for a few MB; make room there"
        elif "disk I/O error" in reason:  # so says SQLite of a quota, too, and of a full disk while it opens
            text = (
                f"the disk is full, over a quota or fails ({reason}), expected it to keep what is written; make "
            )
            text += "room there, or copy it to another disk and name that by --db"
        else:
            text = f"cannot be written ({reason}); give write access to it, or name another by --db"
        super().__init__(f"{url}: {text}")


class DatabaseBusy(DatabaseError, TimeoutError):
    """Another process held the write lock for too long; nothing was written.

    Example: a program of the user's own holds a transaction open.
    """

    def __init__(self, url: str, waited_s: float) -> None:
        super().__init__(
            f"{url}: still locked after {waited_s:g} s; end the program that writes to it, then try again"
        )
