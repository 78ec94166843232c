"""A GNSS receiver beside the IMU: its reader process, its fixes, the site and the time they give."""
