"""Certificates of cubes and slabs that come as digital calibration certificates, taken into the database."""
