"""Fixtures as files: ``fixtures/1``, one TOML file or a folder of CSV files, made from and for `fixtures_db`.

A table of the file is a table of the database, a key one of its columns:
`fixtures_db.fixture_transfer.CARRIED_TABLES`.
"""
