"""What was measured about cubes, slabs and sites, and every calibration ever accepted.

Open it with `fixtures_db.database.open_db`; read and write through small functions that take a session::

    with open_db(path) as db, db.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))

Calibrations and certificates are append-only: the database itself refuses UPDATE and DELETE, and each
calibration carries the hash of the one before it. Units stand in the column names; times are UTC.
"""
