"""A live stream as seconds: blocks with their noise, stillness, turns, and from accepted blocks to samples."""

from station.stream.live.live_feed import LiveFeed, open_feed

__all__ = ["LiveFeed", "open_feed"]
