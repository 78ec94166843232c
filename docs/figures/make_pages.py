"""Draw pages of the demo's unit: `make demo`, then `python docs/figures/make_pages.py demo`; needs chromium."""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parents[1]
WIDTH, A4 = 898, 2**0.5  # px, and the height of a page to its width


def draw(page: Path, to: Path, height: int) -> None:
    """Draw the first ``height`` px of an HTML file."""
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder, "page.png")
        size = f"--window-size={WIDTH},{height}"
        options = ["--headless", "--no-sandbox", "--hide-scrollbars", size, f"--screenshot={whole}"]
        subprocess.run(["chromium", *options, page.resolve().as_uri()], check=True, capture_output=True)
        Image.open(whole).convert("P", palette=Image.Palette.ADAPTIVE, colors=64).save(to, optimize=True)


def main() -> None:
    """Draw the certificate's first page and the report's from a demo's folder."""
    for name in ("certificate", "report"):
        draw(Path(sys.argv[1], f"{name}.html"), DOCS / f"{name}.png", round(WIDTH * A4))


if __name__ == "__main__":
    main()
