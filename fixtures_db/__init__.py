"""What was measured about cubes, slabs and sites, and every calibration ever accepted.

`database` opens it (`schema`, `migrations`) and each write is kept in the `journal`; `fixtures` and
`fixture_measurements`, `campaigns`, `stored_calibrations` and `issued_certificates` add rows, chained where they
are append-only (`hash_chain`, `append_only_rows`, `append_only_triggers`); `verification` reports whether any was
altered::

    with open_db(path) as db, db.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))

The database itself refuses UPDATE and DELETE of calibrations and certificates. Units stand in the column names;
times are UTC.
"""
