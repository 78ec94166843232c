"""Recordings without declared positions: rests found, moves between them, calibration from both."""
