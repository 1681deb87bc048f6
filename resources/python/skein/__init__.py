"""Skein from Python.

    import skein
    run = skein.run("platoon.toml", set={"controller.gains.k_xx": 0.003})
    run.summary["collisions"], run.data, run.plot()

`skein.run` and `skein.sweep` start the program `skein` and read what it leaves: there is one engine. Nothing but Python's own
library is needed to start runs; numpy, pandas and matplotlib are loaded when a record is looked at. docs/tools.md says more.
"""

from .runs import Error, Run, Sweep, program, read, run, sweep

__all__ = ["Error", "Run", "Sweep", "program", "read", "run", "sweep"]
