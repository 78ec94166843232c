"""The engine as a process: ``python -m station.guide SOCKET``, options as JSON on stdin, until stdin is closed."""

import sys
from pathlib import Path


def main() -> None:
    """Serve one engine."""
    from station.guide.options import EngineOptions
    from station.guide.server import serve

    serve(Path(sys.argv[1]), EngineOptions.model_validate_json(sys.stdin.readline()))


if __name__ == "__main__":
    main()
