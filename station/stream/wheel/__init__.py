"""A vehicle's wheel beside the IMU: what it is, and what it tells over CAN."""
