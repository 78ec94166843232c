"""A digital calibration certificate of a cube or a slab, small and valid: what another laboratory might send."""

from collections.abc import Sequence

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<dcc:digitalCalibrationCertificate xmlns:dcc="https://ptb.de/dcc" xmlns:si="https://ptb.de/si"
    schemaVersion="3.1.2">
  <dcc:administrativeData>
    <dcc:dccSoftware>
      <dcc:software>
        <dcc:name><dcc:content>by hand</dcc:content></dcc:name>
        <dcc:release>1</dcc:release>
      </dcc:software>
    </dcc:dccSoftware>
    <dcc:coreData>
      <dcc:countryCodeISO3166_1>DE</dcc:countryCodeISO3166_1>
      <dcc:usedLangCodeISO639_1>en</dcc:usedLangCodeISO639_1>
      <dcc:mandatoryLangCodeISO639_1>en</dcc:mandatoryLangCodeISO639_1>
      <dcc:uniqueIdentifier>{number}</dcc:uniqueIdentifier>
      <dcc:beginPerformanceDate>2026-03-03</dcc:beginPerformanceDate>
      <dcc:endPerformanceDate>2026-03-04</dcc:endPerformanceDate>
      <dcc:performanceLocation>laboratory</dcc:performanceLocation>
    </dcc:coreData>
    <dcc:items>
      <dcc:name><dcc:content>Fixture</dcc:content></dcc:name>
      <dcc:item>
        <dcc:name><dcc:content>{kind}</dcc:content></dcc:name>
        <dcc:manufacturer><dcc:name><dcc:content>Stone AG</dcc:content></dcc:name></dcc:manufacturer>
        <dcc:identifications>
          <dcc:identification>
            <dcc:issuer>owner</dcc:issuer>
            <dcc:value>{item}</dcc:value>
            <dcc:name><dcc:content>inventory number</dcc:content></dcc:name>
          </dcc:identification>
        </dcc:identifications>
      </dcc:item>
    </dcc:items>
    <dcc:calibrationLaboratory>
      <dcc:contact>
        <dcc:name><dcc:content>Coordinate Laboratory Weber</dcc:content></dcc:name>
        <dcc:eMail>lab@example.org</dcc:eMail>
        <dcc:location><dcc:city>Town</dcc:city></dcc:location>
      </dcc:contact>
    </dcc:calibrationLaboratory>
    <dcc:respPersons>
      <dcc:respPerson>
        <dcc:person><dcc:name><dcc:content>A. Weber</dcc:content></dcc:name></dcc:person>
        <dcc:mainSigner>true</dcc:mainSigner>
      </dcc:respPerson>
    </dcc:respPersons>
    <dcc:customer>
      <dcc:name><dcc:content>Sky AG</dcc:content></dcc:name>
      <dcc:eMail>order@example.org</dcc:eMail>
      <dcc:location><dcc:city>Town</dcc:city></dcc:location>
    </dcc:customer>
  </dcc:administrativeData>
  <dcc:measurementResults>
    <dcc:measurementResult>
      <dcc:name><dcc:content>Results</dcc:content></dcc:name>
      <dcc:results>
"""
FOOT = """      </dcc:results>
    </dcc:measurementResult>
  </dcc:measurementResults>
</dcc:digitalCalibrationCertificate>
"""


def uncertainty(half_width: float, k: float) -> str:
    return (
        f"<si:expandedUnc><si:uncertainty>{half_width!r}</si:uncertainty><si:coverageFactor>{k!r}"
        "</si:coverageFactor><si:coverageProbability>0.95</si:coverageProbability></si:expandedUnc>"
    )


def real(value: float, unit: str, half_width: float | None, k: float = 2.0) -> str:
    reported = "" if half_width is None else uncertainty(half_width, k)
    return f"<si:real><si:value>{value!r}</si:value><si:unit>{unit}</si:unit>{reported}</si:real>"


def result(text: str, content: str, ref_type: str = "") -> str:
    """A result by its English name, or a refType."""
    ref = f' refType="{ref_type}"' if ref_type else ""
    return f"""        <dcc:result{ref}>
          <dcc:name><dcc:content lang="en">{text}</dcc:content></dcc:name>
          <dcc:data><dcc:quantity>{content}</dcc:quantity></dcc:data>
        </dcc:result>
"""


def small_dcc(
    results: Sequence[str] = (), *, number: str = "W-17", kind: str = "Cube", item: str = "CUBE-7"
) -> bytes:
    reported = results or [result("up tilt x_up 1", real(1.2, "\\arcsecond", 1.0))]
    return (HEAD.format(number=number, kind=kind, item=item) + "".join(reported) + FOOT).encode()
