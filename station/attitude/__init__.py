"""Roll and pitch from logs: reading `attitude-log/1`, writing `attitude/1`."""
