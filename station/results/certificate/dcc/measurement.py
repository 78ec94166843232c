"""The measurement of a digital certificate: methods, equipment, conditions, results and remarks."""

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.administrative import software
from station.results.certificate.dcc.budget import budget_result
from station.results.certificate.dcc.conditions import influence_conditions
from station.results.certificate.dcc.covariance import covariance_results
from station.results.certificate.dcc.effects_and_global_test import effects_and_global_test
from station.results.certificate.dcc.elements import Element, Said, dcc, joined, worded
from station.results.certificate.dcc.equipment import measuring_equipments
from station.results.certificate.dcc.methods import used_methods
from station.results.certificate.dcc.names import as_written
from station.results.certificate.dcc.records import records_results
from station.results.certificate.dcc.results import parameter_results
from station.results.certificate.model_statement import TAKEN_AS_ZERO

NAME = Said("Calibration of an inertial measurement unit", "Kalibrierung einer Inertialmesseinheit")


def measurement_result(content: CertificateContent) -> Element:
    """Return the one measurement with all its results."""
    return dcc(
        "measurementResult",
        worded("name", NAME),
        used_methods(content),
        dcc("usedSoftware", software(str(content.document["software"]))),
        measuring_equipments(content),
        influence_conditions(content),
        dcc(
            "results",
            *parameter_results(content),
            *covariance_results(content),
            budget_result(content),
            *effects_and_global_test(content),
            *records_results(content),
        ),
        dcc("measurementMetaData", *_remarks(content)),
    )


def _remarks(content: CertificateContent) -> list[Element]:
    none = Said("none", "keine")
    several = (
        ("fog_deviations", Said("Deviations from the procedure", "Abweichungen vom Verfahren"),
         content.deviations),
        ("fog_takenAsZero", Said(TAKEN_AS_ZERO, "In diesen Schritten nicht bestimmt und null gesetzt oder gleich "
         "denen des mittleren Würfels"), content.taken_as_zero),
        ("fog_stated", Said("Stated, not measured here", "Angegeben, hier nicht gemessen"),
         [f"{label}: {text}" for label, text in content.stated]),
    )  # fmt: skip
    diagnosis = joined(map(as_written, content.diagnosis), " ")  # whole sentences, the first of which is its title
    remarks = [
        (ref_type, title + Said(": ", ": ") + (joined(map(as_written, said), "; ") if said else none))
        for ref_type, title, said in several
    ]
    return [
        dcc("metaData", worded("declaration", said), refType=ref_type)
        for ref_type, said in (*remarks[:1], ("fog_diagnosis", diagnosis), *remarks[1:])
    ]
