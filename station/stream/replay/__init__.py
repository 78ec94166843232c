"""Recordings as live devices: their bytes come again as they came then."""
