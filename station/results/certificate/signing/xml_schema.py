"""Names and XSD of a DCC and its signature: XMLDSig 1.1, XAdES 1.3.2 (ETSI EN 319 132-1).

The schemas are the station's own files; nothing is fetched.
"""

from copy import deepcopy
from functools import cache
from importlib.resources import files
from io import BytesIO
from typing import Any

from lxml import etree

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
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
NAMESPACES = {"dcc": DCC, "si": SI, "ds": DS, "xades": XADES}


def ds(name: str) -> str:
    """Return a name of XMLDSig as lxml has it."""
    return f"{{{DS}}}{name}"


def dcc(name: str) -> str:
    """Return a name of the certificate's schema as lxml has it."""
    return f"{{{DCC}}}{name}"


def xades(name: str) -> str:
    """Return a name of XAdES as lxml has it."""
    return f"{{{XADES}}}{name}"


VERSION = "3.1.2"
_ADDRESSES = {  # by which the schemas name each other
    DCC: ("station.results.certificate", "dcc/schema/dcc.xsd"),
    f"{SI}/v2.1.0/SI_Format.xsd": ("station.results.certificate", "dcc/schema/SI_Format.xsd"),
    DS: ("signxml", "schemas/xmldsig-core-schema.xsd"),
}
_BOTH = f"""<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema">
<xs:import namespace="{DCC}" schemaLocation="{DCC}"/><xs:import namespace="{DS}" schemaLocation="{DS}"/>
</xs:schema>"""


class _OwnFiles(etree.Resolver):  # type: ignore[misc]
    """Gives the station's own file for each address, and nothing for any other."""

    def resolve(self, system_url: str, public_id: str, context: Any) -> Any:
        """Return the file of an address."""
        if system_url in _ADDRESSES:
            package, name = _ADDRESSES[system_url]
            return self.resolve_string(files(package).joinpath(name).read_bytes(), context)
        return self.resolve_string(b"<nothing/>", context)


def read_schema(text: bytes) -> etree.XMLSchema:
    """Return a schema, which may import those of the station."""
    parser = etree.XMLParser(no_network=True, resolve_entities=False)
    parser.resolvers.add(_OwnFiles())
    return etree.XMLSchema(etree.parse(BytesIO(text), parser))


@cache
def _schema() -> etree.XMLSchema:
    return read_schema(_BOTH.encode())


def schema_fault(root: Any) -> str:
    """Return what is first wrong with a document by its schema, in words; empty if it is valid."""
    checked = deepcopy(root)
    for element in checked.iter(etree.Element):  # a document's own word for where schemas are is not followed
        for name in ("schemaLocation", "noNamespaceSchemaLocation"):
            element.attrib.pop(f"{{{XSI}}}{name}", None)
    schema = _schema()
    if schema.validate(checked):
        return ""
    first = schema.error_log[0]
    return f"line {first.line}: {first.message}"
