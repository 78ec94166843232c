"""Reads a digital certificate with dccQuantities: a program of its own, since that library can take one down.

``python foreign_reader.py CACHE FILE.xml`` writes JSON: of every quantity label, values, 1 sigma, unit. The
library asks a server for schemas when it is imported; they are put where it keeps them, from those of the package.
"""

import json
import os
import shutil
import sys
import warnings
from pathlib import Path

SCHEMAS = Path(__file__).parents[4] / "station/results/certificate/dcc/schema"
VERSIONS = ("3.1.2", "3.4.0-rc.2")  # the file's, and the one that the library begins with


def keep_schemas(cache: Path) -> None:
    """Put the schemas where dcc_json_toolkit keeps those that it has fetched."""
    for version in VERSIONS:
        folder = cache / "DccJsonToolkit" / version
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(SCHEMAS / "SI_Format.xsd", folder)
        text = (SCHEMAS / "dcc.xsd").read_text()
        local = f"file:///{folder / 'SI_Format.xsd'}"
        (folder / "dcc.xsd").write_text(text.replace("https://ptb.de/si/v2.1.0/SI_Format.xsd", local))


def main(cache: Path, file: Path) -> None:
    """Write what the library reads."""
    os.environ["XDG_CACHE_HOME"] = str(cache)
    keep_schemas(cache)
    warnings.simplefilter("ignore")
    from dcc_json_toolkit import DccSchema
    from dcc_quantities import DccQuantityType
    from dcc_quantities.dcc_no_quantity import DccNoQuantity

    document = DccSchema(VERSIONS[0]).to_dict(str(file))
    found = []
    for one in DccQuantityType.extract_all_quantities(document):
        if isinstance(one.data, DccNoQuantity):
            continue
        found.append(
            {
                "ref_type": one.ref_type,
                "label": one.data.label,
                "values": [float(value) for value in one.data.values.flat],
                "std": [float(value) for value in one.data.uncertainties.flat],
                "unit": str(one.data.unit),
                "is_unit": bool(one.data.unit.valid),
            }
        )
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
    sys.stdout.flush()
    os._exit(0)  # what the library begins, mono, takes seconds to end
