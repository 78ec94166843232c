"""Libraries of extras: asked for when needed, named when not there."""


def signing_libraries() -> None:
    """Raise `ExtraMissing` where what signs and checks certificates is not installed."""
    from importlib.util import find_spec

    from procedures.fusion.optional_libraries import ExtraMissing

    for name in ("lxml", "defusedxml", "signxml", "pyhanko", "rfc3161_client"):
        if find_spec(name) is None:
            raise ExtraMissing(name, "sign")
