"""A stored calibration and what it makes of counts: specific forces and angular rates.

`calibration_choice` (which one), `correction_inputs`, `applied_effects` and `settling_kernels` (its laws, solved),
`applied_calibration` (a block), `calibrated_stream` (block by block), `rates_and_forces` (in body axes),
`output_frame`; `physics_check`, `remaining_uncertainty` and `filter_settings` say how good the result is.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class InUse:
    """The calibration in use, in words; ``note`` is what to know about it, such as error terms not corrected."""

    text: str = "not known before the unit is identified"
    note: str = ""
