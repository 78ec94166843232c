"""Campaign folders (`campaign/1`): what a station records and what anyone may bring from elsewhere."""
