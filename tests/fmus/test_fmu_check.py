"""The check of foreign and broken FMUs: always a list of findings."""

import subprocess
import sys
import zipfile

import pytest
from cosimo.fmus.check import check
from cosimo.fmus.check_worker import host_packages, other_bundle

STOCK = """
import os
from pythonfmu import Fmi2Causality, Fmi2Slave, Real

class Stock(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = 0.0
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        BODY
        self.y += step_size
        return True
"""


def stock(directory, name, body):
    """A plain pythonfmu FMU, as others build it."""
    script = directory / f"{name}.py"
    script.write_text(STOCK.replace("Stock", name).replace("BODY", body))
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", script, "-d", directory], check=True, capture_output=True)
    return {f.name: f for f in check(directory / f"{name}.fmu")}


@pytest.mark.parametrize(
    ("tool", "why"), [("cosimo 0.9 (native)", "it holds no code in Python"), ("Stockmaker", "made by another tool")]
)
def test_what_a_check_of_python_does_not_find_is_said_by_whose_fmu_it_is(tool, why, tmp_path):
    text = f"""<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g" generationTool="{tool}">
        <CoSimulation modelIdentifier="m"/><ModelVariables/><ModelStructure/></fmiModelDescription>"""
    with zipfile.ZipFile(tmp_path / "m.fmu", "w") as file:
        file.writestr("modelDescription.xml", text)
    for one in (other_bundle, host_packages):
        assert one(str(tmp_path / "m.fmu"), "") == (True, f"not offered: {why}")


def test_a_foreign_fmu_is_checked_for_what_it_offers(tmp_path):
    findings = stock(tmp_path, "Stock", "pass")

    assert findings["state"].ok
    assert findings["state"].detail == "not offered"
    assert findings["other_bundle"].detail.startswith("not offered")
    assert findings["default_experiment"].ok
    assert findings["reset"].ok
    assert findings["two_instances"].ok
    assert not findings["model_description"].ok  # pythonfmu 0.7 writes no InitialUnknowns
    assert "InitialUnknowns" in findings["model_description"].detail


def test_an_fmu_that_kills_its_process_is_a_finding(tmp_path):
    findings = stock(tmp_path, "Killer", "os.abort()")

    assert {n for n, f in findings.items() if "signal 6" in f.detail} == {"default_experiment", "reset", "two_instances"}
    assert len(findings) == 8


def test_an_fmu_with_shared_state_is_found(tmp_path):
    findings = stock(tmp_path, "Shared", "Shared.n = getattr(Shared, 'n', 0) + 1; self.y += Shared.n")

    assert not findings["reset"].ok
    assert not findings["two_instances"].ok


def test_results_that_are_no_numbers_are_found(tmp_path):
    findings = stock(tmp_path, "Silent", "self.y = float('nan')")

    assert findings["default_experiment"].detail == "not finite: y"


@pytest.mark.parametrize(("content", "detail"), [(None, "missing"), (b"text", "no zip file")])
def test_what_is_no_fmu_is_one_finding(tmp_path, content, detail):
    path = tmp_path / "any.fmu"
    if content:
        path.write_bytes(content)
    (finding,) = check(path)

    assert not finding.ok
    assert finding.detail.endswith(detail)
