"""The methods of a digital certificate: procedure, uncertainty, decision rule; equations by number."""

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.names import as_written

EQUATIONS = {  # by number, LaTeX: model, application, expanded uncertainty, error as found, acceptance, risk
    "1": r"\mathbf{N} = \mathbf{K} \circ (\mathbf{E}\,\mathbf{u} + \mathbf{D})",
    "2": r"\mathbf{u} = \mathbf{E}^{-1} (\mathbf{N} / \mathbf{K} - \mathbf{D})",
    "3": r"U = k_p(\nu_\mathrm{eff})\, u",
    "4": r"e = p_\mathrm{now} - p_\mathrm{prev},\; U(e) = 2\sqrt{u_\mathrm{now}^2 + u_\mathrm{prev}^2}",
    "5": r"L + r u \le y \le H - r u",
    "6": r"p = 1 - F_\nu\!\left(\frac{H-y}{u}\right) + F_\nu\!\left(\frac{L-y}{u}\right)",
}


def used_methods(content: CertificateContent) -> Element:
    """Return the procedure, how the uncertainty was evaluated, and the rule of decision where there are limits."""
    procedure = content.document["procedure"]
    name = as_written(str(procedure["name"]))
    steps = f"{len(procedure['steps'])}: {', '.join(map(str, procedure['steps']))}"
    joint = Said(
        "Joint least-squares solution of equation (1) for both triads and the bench. N: count rate, u: specific "
        f"force or angular rate in body axes, rows of E of unit length. Steps, {steps}.",
        "Gemeinsame Ausgleichung der Gleichung (1) für beide Triaden und den Messplatz. N: Zählrate, u: "
        "spezifische "
        f"Kraft oder Drehrate in Körperachsen, Zeilen von E der Länge eins. Schritte, {steps}.",
    )
    budget = Said(
        "Uncertainty budget by sources, combined after JCGM 100:2008; degrees of freedom after Welch and "
        "Satterthwaite; equation (3).",
        "Unsicherheitsbudget nach Quellen, kombiniert nach JCGM 100:2008; Freiheitsgrade nach Welch und "
        "Satterthwaite; Gleichung (3).",
    )
    methods = [
        _method("basic_calibrationMethod", name, joint, ("1", "2", "4")),
        _method("basic_methodMeasurementUncertainty", UNCERTAINTY, budget, ("3",), "JCGM 100:2008"),
    ]
    if content.found is not None:
        methods.append(_method("basic_decisionRule", RULE, RULE_SAID, ("5", "6"), "JCGM 106:2012, 8.3"))
    return dcc("usedMethods", *methods)


UNCERTAINTY = Said("Evaluation of the measurement uncertainty", "Ermittlung der Messunsicherheit")
RULE = Said("Decision rule", "Entscheidungsregel")
RULE_SAID = Said(
    "Guarded acceptance, equation (5); the risk of a wrong decision is that of equation (6).",
    "Annahme mit Schutzabstand, Gleichung (5); das Risiko einer falschen Entscheidung ist das der Gleichung (6).",
)


def _method(ref_type: str, name: Said, text: Said, numbers: tuple[str, ...], norm: str | None = None) -> Element:
    description = worded("description", text)
    for number in numbers:
        description.append(dcc("formula", dcc("latex", text=rf"{EQUATIONS[number]} \tag{{{number}}}")))
    norms = () if norm is None else (dcc("norm", text=norm),)
    return dcc("usedMethod", worded("name", name), description, *norms, refType=ref_type)
