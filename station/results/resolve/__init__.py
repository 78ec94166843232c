"""A fleet's recordings through today's code, and what that changes. Nothing that is stored is touched."""
