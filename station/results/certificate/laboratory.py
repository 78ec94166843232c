"""``laboratory.toml``: what a certificate says that no instrument knows; docs/how-to/certificate.md shows one."""

from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from station.errors import DataRefused
from station.files.toml_file import LONGEST_TEXT, Text, TomlTable, matching, read_tables, read_text_file

Prefix = Annotated[str, matching(r"[\w.-]{0,20}", "at most 20 letters, digits, ., _ and -")]
Country = Annotated[str, matching("[A-Z]{2}", "two capital letters, as ISO 3166-1 has them")]
Temperature = Annotated[float, Field(ge=-20, le=60)]  # of a room, degC
Humidity = Annotated[float, Field(ge=0, le=100)]  # relative, percent
Ends = Field(min_length=2, max_length=2)
OPTIONS = {  # of `station certificate`, for what changes with each order
    ("customer", "name"): "--customer",
    ("customer", "address"): "--customer-address",
    ("customer", "email"): "--customer-email",
    ("item", "received"): "--received",
    ("item", "condition"): "--condition",
}


def _checked_email(text: str) -> str:
    name, at, host = text.partition("@")
    if not (name and at and host) or "@" in host or " " in text:
        raise ValueError("an address with one @ and no space, as name@laboratory.example")
    return text


Email = Annotated[Text, AfterValidator(_checked_email)]


class LaboratoryTable(TomlTable):
    """``[laboratory]``; ``location`` is where it was measured, if that is elsewhere.

    ``country`` (ISO 3166-1, two letters) and ``email`` are what the form of a digital certificate asks for.
    """

    name: Text | None = None
    address: Text | None = None
    location: Text | None = None
    accreditation: Text | None = None
    country: Country | None = None
    email: Email | None = None
    number_prefix: Prefix = "CAL-"


class AuthorisedTable(TomlTable):
    """``[authorised]``: who answers for the certificate."""

    name: Text | None = None
    function: Text | None = None


class CustomerTable(TomlTable):
    """``[customer]``; ``email`` is asked for by the form of a digital certificate."""

    name: Text | None = None
    address: Text | None = None
    email: Email | None = None


class ItemTable(TomlTable):
    """``[item]``: the unit as it came."""

    received: date | None = None
    condition: Text | None = None
    manufacturer: Text | None = None


class TraceabilityTable(TomlTable):
    """``[traceability]``: what second the counts refer to; whose gravity, if the database does not say."""

    time_base: Text | None = None
    gravity_source: Text | None = None


class EnvironmentTable(TomlTable):
    """``[environment]`` of the slab: least and greatest."""

    temperature_c: Annotated[list[Temperature], Ends] | None = None
    humidity_percent: Annotated[list[Humidity], Ends] | None = None

    @model_validator(mode="after")
    def _has_its_ends_in_order(self) -> Self:
        for name in ("temperature_c", "humidity_percent"):
            if (span := getattr(self, name)) is not None and span[0] > span[1]:
                raise ValueError(f"{name} with the least before the greatest")
        return self


class DecisionTable(TomlTable):
    """``[decision]``: what was agreed with the customer, put before the rule itself."""

    agreed: Text | None = None


class SignatureTable(TomlTable):
    """``[signature]``: whom the laboratory trusts, files next to this one; ``station verify --laboratory``."""

    roots: list[Text] = []
    revocation_lists: list[Text] = []


class Laboratory(TomlTable):
    """The whole of a ``laboratory.toml``; what is left out may be given on the command line, or is missing."""

    format: Literal["laboratory/1"]
    laboratory: LaboratoryTable = LaboratoryTable()
    authorised: AuthorisedTable = AuthorisedTable()
    customer: CustomerTable = CustomerTable()
    item: ItemTable = ItemTable()
    traceability: TraceabilityTable = TraceabilityTable()
    environment: EnvironmentTable = EnvironmentTable()
    decision: DecisionTable = DecisionTable()
    signature: SignatureTable = SignatureTable()

    def given(self, table: str, values: Mapping[str, object]) -> "Laboratory":
        """Return it with what is given of a table in the place of what the file says.

        Raise `DataRefused` naming the option whose value is empty, too long, not printable, or no such value.
        """
        known = {name: value for name, value in values.items() if value is not None}
        try:
            changed = type(getattr(self, table)).model_validate(getattr(self, table).model_dump() | known)
        except ValidationError as error:
            fault = error.errors(include_url=False)[0]
            own = fault["type"] == "value_error"
            expected = str(fault["ctx"]["error"]) if own else f"text of 1 to {LONGEST_TEXT} characters in UTF-8"
            option = OPTIONS[table, str(fault["loc"][0])]
            raise DataRefused(option, None, ascii(fault["input"]), expected, "correct the option") from None
        return self.model_copy(update={table: changed})


def read_laboratory(path: Path) -> Laboratory:
    """Return a file's tables; raise `DataRefused` with file and line at a key that is unknown or no such value."""
    return read_tables(read_text_file(path), path, Laboratory)[0]
