"""What says where the Earth turns to, as options that commands on attitude share."""

from typing import Annotated

import typer

Latitude = Annotated[
    float | None,
    typer.Option("--latitude", metavar="DEG", min=-90, max=90, help="Takes the Earth's rate off."),
]
Heading = Annotated[
    float | None,
    typer.Option("--heading", metavar="DEG", min=-360, max=360, help="True heading of forward, at the start."),
]
