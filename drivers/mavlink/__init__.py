"""GNSS over MAVLink: bytes of any port to GNSS records, and what must be said to be sent them."""
