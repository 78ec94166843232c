"""GNSS over MAVLink: bytes of any port to `procedures.gnss` records, and what must be said to be sent them."""
