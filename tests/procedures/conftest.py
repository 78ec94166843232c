"""What many tests ask of the same channels' counts is estimated once a process."""

from tests.estimated_once import counts_are_estimated_once

__all__ = ["counts_are_estimated_once"]
