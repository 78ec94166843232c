"""Alembic's entry: it migrates the connection that `upgrade` hands it."""

from alembic import context

from fixtures_db.schema import Base

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Base.metadata,
    transactional_ddl=True,  # SQLite's DDL is, though alembic does not assume it
)
with context.begin_transaction():
    context.run_migrations()
