"""Edits of a database past the station, drawn from the schema itself, and honest changes next to them."""
