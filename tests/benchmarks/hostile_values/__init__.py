"""Hostile numbers, words and shapes for every key of every file that a user hands in."""
