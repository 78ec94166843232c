"""A stored calibration and what it makes of counts: specific forces and angular rates."""
