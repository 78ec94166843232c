"""The modules of which calls are stored."""

from pathlib import Path

LEFT_OUT = (
    "station/results/cluster/code_hash.py",  # what it gives goes with every change of the code
    "drivers/simulated/can_lines.py",  # descriptors by their numbers: what is closed again may be another's
    "drivers/simulated/serial_and_tcp_lines.py",
    "station/results/certificate/signing/token_key.py",  # a token's library is loaded once a process
    "fixtures_db/migrations/",  # alembic's `op` tells whether this process has opened a database before
)
HERE = Path(__file__).parent


def stored_modules() -> list[str]:
    """Return `procedures/counts/x.py` and so on."""
    packages = (HERE / name for name in ("procedures", "drivers", "fixtures_db", "station"))
    files = (each for package in packages for each in package.rglob("*.json"))
    return sorted(str(each.relative_to(HERE).with_suffix(".py")) for each in files)
