"""Benches that answer a plan's steps with live data: whoever moves the cube, the counts decide when it rests."""

from station.benches.hands import ConsoleHands, DeviceHands, Hands
from station.benches.headless import HeadlessBench
from station.benches.live_feed import LiveFeed, open_feed
from station.benches.progress import Progress

__all__ = ["ConsoleHands", "DeviceHands", "Hands", "HeadlessBench", "LiveFeed", "Progress", "open_feed"]
