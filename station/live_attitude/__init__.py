"""Roll and pitch of a live unit, tick by tick, by one law or by several; what the monitor and the guide run."""
