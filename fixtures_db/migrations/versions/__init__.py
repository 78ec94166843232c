"""One file per schema version; never edited once released. `fixtures_db.schema.NAMING` names the constraints."""
