"""An FMU as another tool sees it: FMPy, which the project did not make."""

import pytest


class Unit:
    """An FMU in FMPy, with what it logs."""

    def __init__(self, path, kind="CS", **how):
        fmi3 = pytest.importorskip("fmpy.fmi3")
        import fmpy

        self.description = fmpy.read_model_description(path)
        self.reference = {one.name: one.valueReference for one in self.description.modelVariables}
        self.folder = fmpy.extract(path)
        self.said: list[str] = []
        self.fmu = getattr(fmi3, {"CS": "FMU3Slave", "ME": "FMU3Model"}[kind])(
            guid=self.description.guid, unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="a",
        )  # fmt: skip
        self.fmu.instantiate(logMessage=lambda place, status, category, text: self.said.append(text.decode()), **how)

    def set(self, **values):
        self.fmu.setFloat64([self.reference[name] for name in values], list(values.values()))

    def get(self, *names):
        return self.fmu.getFloat64([self.reference[name] for name in names])

    def begin(self, **how):
        self.fmu.enterInitializationMode(**how)
        self.fmu.exitInitializationMode()
