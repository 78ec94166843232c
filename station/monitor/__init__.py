"""Roll and pitch of a live IMU: the engine behind `station monitor`; screens and lines of text show its views."""
