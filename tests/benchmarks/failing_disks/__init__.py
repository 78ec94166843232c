"""Disks that are full, read-only, broken or slow, at every single call that a program makes to them."""
