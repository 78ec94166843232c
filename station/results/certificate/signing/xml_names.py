"""Names of the XML that a signature is made of: XMLDSig 1.1, XAdES 1.3.2 (ETSI EN 319 132-1), DCC."""

DCC = "https://ptb.de/dcc"
DS = "http://www.w3.org/2000/09/xmldsig#"
XADES = "http://uri.etsi.org/01903/v1.3.2#"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
SCHEMA_LOCATION = f"{{{XSI}}}schemaLocation"
DS_SCHEMA = "http://www.w3.org/TR/2002/REC-xmldsig-core-20020212/xmldsig-core-schema.xsd"
SIGNED_PROPERTIES = "http://uri.etsi.org/01903#SignedProperties"
ENVELOPED = "http://www.w3.org/2000/09/xmldsig#enveloped-signature"
EXCLUSIVE = "http://www.w3.org/2001/10/xml-exc-c14n#"
CANONICAL = frozenset(  # none that keeps comments: they are not what is signed
    {EXCLUSIVE, "http://www.w3.org/TR/2001/REC-xml-c14n-20010315", "http://www.w3.org/2006/12/xml-c14n11"}
)
ID_NAMES = frozenset({"id", "Id", "ID"})
NAMESPACES = {"dcc": DCC, "si": "https://ptb.de/si", "ds": DS, "xades": XADES}


def ds(name: str) -> str:
    """Return a name of XMLDSig as lxml has it."""
    return f"{{{DS}}}{name}"


def dcc(name: str) -> str:
    """Return a name of the certificate's schema as lxml has it."""
    return f"{{{DCC}}}{name}"


def xades(name: str) -> str:
    """Return a name of XAdES as lxml has it."""
    return f"{{{XADES}}}{name}"
