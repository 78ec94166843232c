"""The only package that knows operators, files, time and the terminal.

`cli` runs a command of `commands.command_table`. `files` reads and writes files, `stream` live devices; `results`
says what came out, `guide` leads an operator through a campaign, `monitor` and `locate` follow a moving unit,
`tui` shows all of it. `applying`, `sending` and `exports` use a stored calibration (`calibrated`), `calibration`
does so in a program of your own. `port_detection` finds the ports and what sends there, `device_probe` listens to
one address. `errors` has every refusal with its exit code.
"""

import os

# Before numpy is loaded: on matrices of some hundred rows the threads of OpenBLAS only wait for each other, on a
# busy machine many times longer than the arithmetic takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
