"""FMUs by variable names, with statuses instead of exceptions; and scripts in processes of their own."""

import os
import subprocess
import sys
from pathlib import Path

from fmpy import calloc, extract, free, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

OK, DISCARD = 0, 2
HERE = Path(__file__).parent


class Driven:
    """One instance of an FMU; `log` collects its messages as (status, text)."""

    def __init__(self, path, folder=None, name="unit"):
        self.description = read_model_description(str(path), validate=False)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.log = []
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            unzipDirectory=str(folder or extract(str(path))),
            instanceName=name,
        )
        self.callbacks = fmi2CallbackFunctions(
            fmi2CallbackLoggerTYPE(lambda env, name, status, category, message: self.log.append((status, message.decode()))),
            fmi2CallbackAllocateMemoryTYPE(calloc),
            fmi2CallbackFreeMemoryTYPE(free),
        )
        self.fmu.instantiate(callbacks=self.callbacks, loggingOn=True)

    def start(self, values=(), at=0.0):
        self.fmu.setupExperiment(startTime=at)
        self.set(dict(values))
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, values):
        for name, value in values.items():
            variable = self.variables[name]
            getattr(self.fmu, "set" + variable.type)([variable.valueReference], [value])

    def __getitem__(self, name):
        variable = self.variables[name]
        return getattr(self.fmu, "get" + variable.type)([variable.valueReference])[0]

    def reals(self, names):
        return self.fmu.getReal([self.variables[n].valueReference for n in names])

    def step(self, t, h):
        try:
            self.fmu.doStep(t, h)
            return OK
        except FMICallException as error:
            return error.status

    def free(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


def run_script(text, *arguments, **environment):
    """The lines a Python script prints, run in a process of its own; a crash or a failed assertion fails the test."""
    command = [sys.executable, "-c", text, *map(str, arguments)]
    done = subprocess.run(command, env=os.environ | environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout.splitlines()
