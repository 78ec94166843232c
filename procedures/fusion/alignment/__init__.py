"""How an IMU starts: which way it stands, at rest, in motion, or with a camera."""
