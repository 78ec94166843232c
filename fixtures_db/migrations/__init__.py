"""Schema versions, oldest first; `KNOWN` lets a database at `HEAD` be opened without importing alembic."""

KNOWN = ("0001", "0002", "0003", "0004", "0005", "0006", "0007", "0008", "0009", "0010", "0011")
HEAD = KNOWN[-1]
