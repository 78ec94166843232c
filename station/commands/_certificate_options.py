"""Options of ``station certificate`` that contradict each other: refused before a number is given."""

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import urlsplit

import typer

BESIDE = (".xml", ".pdf")  # what is written beside the HTML, under its name


def check_copy(order: Mapping[str, object]) -> None:
    """Raise if anything of an order, by option, stands beside --copy: a copy says what was issued."""
    if given := [option for option, value in order.items() if value is not None]:
        said = ", ".join(given)
        raise typer.BadParameter(f"--copy writes the issued certificate unchanged: found {said}; omit one")


def check_out(out: Path | None) -> None:
    """Raise if the HTML would be written where the XML or the PDF belongs."""
    if out is not None and out.suffix.lower() in BESIDE:
        expected = out.with_suffix(".html").name
        raise typer.BadParameter(f"--out names the HTML: found {out.name!a}, expected such as {expected!a}")


def check_time_service(url: str | None, option: str = "--timestamp") -> None:
    """Raise if it is no address of a service: http or https, with a host."""
    try:
        parts = None if url is None else urlsplit(url)
        if parts is None or (parts.scheme in ("http", "https") and parts.hostname):
            return
    except ValueError:  # half an IPv6 address
        pass
    raise typer.BadParameter(f"{option}: found {url!a}, expected a URL such as https://time.example/tsr")
