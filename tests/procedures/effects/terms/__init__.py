"""Effects written as a term."""
