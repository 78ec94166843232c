"""Libraries of extras: asked for when needed, named when not there."""


def signing_libraries(token: bool = False) -> None:
    """Raise `ExtraMissing` where what signs and checks certificates is not installed."""
    from importlib.util import find_spec

    from procedures.optional_libraries import ExtraMissing

    for name in ("lxml", "defusedxml", "signxml", "pyhanko", "rfc3161_client"):
        if find_spec(name) is None:
            raise ExtraMissing(name, "sign")
    if token and find_spec("pkcs11") is None:
        raise ExtraMissing("pkcs11", "token")
