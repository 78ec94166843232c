"""The XSD of a DCC and of the signature in it, read from the station's own files: nothing is fetched."""

from copy import deepcopy
from functools import cache
from importlib.resources import files
from io import BytesIO
from typing import Any

from lxml import etree

from station.results.certificate.signing.xml_names import DCC, DS, XSI

VERSION = "3.1.2"
_ADDRESSES = {  # by which the schemas name each other
    "https://ptb.de/dcc": ("station.results.certificate", "dcc/schema/dcc.xsd"),
    "https://ptb.de/si/v2.1.0/SI_Format.xsd": ("station.results.certificate", "dcc/schema/SI_Format.xsd"),
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


@cache
def _schema() -> etree.XMLSchema:
    parser = etree.XMLParser(no_network=True, resolve_entities=False)
    parser.resolvers.add(_OwnFiles())
    return etree.XMLSchema(etree.parse(BytesIO(_BOTH.encode()), parser))


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
