"""A look at the GNSS receiver of a set-up: where it stands, with sigma, or why it does not say."""

from drivers.errors import DriverError
from station.guide.setup_view import PortCheck

LISTEN_S = 8.0  # a heartbeat, an answer and the fixes at the usual rate; a slow receiver takes all of it
RECEIVER_FIXES = 10


def check_receiver(url: str, seconds: float = LISTEN_S) -> PortCheck:
    """Listen to a receiver; what is wrong stands in ``text``, with what to do. Never raises."""
    from station.devices.gnss_probe import listen
    from station.stream.gnss.receiver_summary import site_in_words

    try:
        feed = listen(url, seconds, RECEIVER_FIXES).feed
    except (DriverError, OSError) as error:
        return PortCheck(url=url, is_good=False, text=str(error))
    if (site := feed.site()) is not None:
        return PortCheck(url=url, is_good=True, text=site_in_words(site))
    nothing = f"{feed.address.name}: no position within {seconds:g} s, expected one; wait for a fix"
    return PortCheck(url=url, is_good=False, text=feed.trouble or nothing)
