"""The device's sample rate against this machine's clock, where no GNSS time says better.

A machine's clock is right to about 1e-4, so that it can tell 0.1 %. What is more than 5 % off is taken to be a
simulated or replayed device at another pace than time's and is left alone.
"""

from station.stream.events import EventLog
from station.stream.gnss.sample_rate import by_this_machine
from station.stream.live.live_feed import LiveFeed
from station.stream.live.trouble_lines import words_of


class HostClock:
    """What a campaign without a receiver does each round."""

    def __init__(self, feed: LiveFeed, story: EventLog) -> None:
        self._rate = by_this_machine(feed)
        self._story, self._said = story, ""

    def round(self) -> None:
        """Look; raise `DataRefused` if the device's rate is surely more than 1 % off."""
        self._rate.look()
        if words_of(now := self._rate.warning) != self._said:
            self._said = words_of(now)
            self._story.say("rejected" if now else "", now or "the sample rate is right again")
