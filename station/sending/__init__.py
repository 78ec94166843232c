"""Calibrated samples handed on live: to a screen elsewhere, a program, a flight stack."""
