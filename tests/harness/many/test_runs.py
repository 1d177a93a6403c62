"""Runs of a plan: the same for any number of workers, resumed, extended, and nothing lost however a process ends."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cosimo
import numpy as np
import pytest
import tomli_w
from cosimo.components.core.errors import BadInput
from cosimo.fmus.build import built
from cosimo.orchestrator.harness.many import cluster, execute
from cosimo.orchestrator.harness.many.cluster import KILLED
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.harness.many.measures import Task
from cosimo.orchestrator.harness.many.plan import plan_of, plan_settings
from cosimo.orchestrator.harness.many.store import StoredPlan
from cosimo.orchestrator.run import dependence
from cosimo.orchestrator.settings.plan import KeepSettings
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.systems.many import sweep
from cosimo.tests.harness.many.points import scene
from cosimo.tests.harness.test_sweep import MASS
from pyarrow import feather

SAMPLES = {
    "method": "sobol",
    "points": 16,
    "seed": 3,
    "keep": {"signals": ["m.x_out"], "interval": 0.25},
    "vary": {
        "m.k": {"distribution": "uniform", "low": 100.0, "high": 900.0},
        "m.m": {"distribution": "triangular", "low": 1.0, "mode": 2.0, "high": 4.0},
    },
}
VALUES = {"vary": {"d.value": list(map(float, range(12)))}}
LINE = {
    "vary": {"d.value": {"low": 0.0, "high": 10.0, "start": 1.0}},
    "starts": 3,
    "targets": [{"quantity": "d.twice, end", "value": 6.0, "deviation": 0.1}],
}
HERE = "cosimo.tests.harness.many.points"


def contents(directory):
    """Bytes of all that a sweep writes in the plan's order."""
    return {
        str(p.relative_to(directory)): p.read_bytes() for p in directory.rglob("*") if p.is_file() and "points" not in p.parts
    }


def test_results_do_not_depend_on_the_number_of_workers(tmp_path):
    one, two = (sweep(read_scene(MASS), SAMPLES, tmp_path / str(jobs), jobs=jobs) for jobs in (1, 2))
    assert set(one.outcomes) == {"done"}
    assert one.measures["m.x_out, maximum"].tobytes() == two.measures["m.x_out, maximum"].tobytes()
    assert contents(tmp_path / "1") == contents(tmp_path / "2")
    assert {"sweep.csv", "sweep.parquet", "sweep.json"} < contents(tmp_path / "1").keys()
    # x = v0 / omega sin(omega t); the samples, 1 ms apart, miss the top by (omega h)^2 / 8 < 2e-4 at most
    omega = np.sqrt(one.varied["m.k"] / one.varied["m.m"])
    np.testing.assert_allclose(one.measures["m.x_out, maximum"], 2.0 / omega, rtol=2e-4)


def test_the_data_set_has_names_units_signals_and_where_it_comes_from(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    result = sweep(read_scene(MASS), SAMPLES, tmp_path)
    data = xarray.open_zarr(tmp_path / "sweep.zarr", consolidated=False)
    assert data["m.k"].attrs["units"] == "N/m"
    assert data["m.x_out, maximum"].attrs["units"] == "m"
    assert data["m.x_out, maximum"].values.tobytes() == result.measures["m.x_out, maximum"].tobytes()
    omega, t = np.sqrt(data["m.k"] / data["m.m"]).values[:, None], data["time"].values
    assert t.tolist() == [0.25 * k for k in range(9)]
    np.testing.assert_allclose(data["m.x_out"].values, 2.0 / omega * np.sin(omega * t), atol=1e-9)
    about = json.loads(data.attrs["provenance"])
    assert about["plan"]["seed"] == 3
    assert about["versions"]["cosimo"]
    assert about["scene"]["master"]["step"] == 1e-3


def test_whole_signals_end_where_their_runs_end(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    plan = {"vary": {"stop_time": [1.0, 3.0]}, "keep": {"signals": ["d.twice"]}}
    sweep(read_scene(scene(value=4.0)), plan, tmp_path)
    data = xarray.open_zarr(tmp_path / "sweep.zarr", consolidated=False)
    np.testing.assert_array_equal(data["time"].values, [[0.0, 1.0, np.nan, np.nan], [0.0, 1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(data["d.twice"].values, [[8.0, 8.0, np.nan, np.nan], [8.0] * 4])


def test_a_second_call_computes_what_is_missing(tmp_path):
    plan = {"method": "random", "points": 4, "vary": {"d.value": {"distribution": "uniform", "low": 0.0, "high": 1.0}}}
    first = sweep(read_scene(scene()), plan, tmp_path)
    again = sweep(read_scene(scene()), plan, tmp_path)
    more = sweep(read_scene(scene()), plan, tmp_path, add=3)
    assert (first.computed, again.computed, more.computed) == (4, 0, 3)
    assert more.measures["d.twice, mean"].tolist() == (2.0 * more.varied["d.value"]).tolist()
    assert more.varied["d.value"][:4].tolist() == first.varied["d.value"].tolist()
    other = sweep(read_scene(scene() | {"stop_time": 2.0}), plan, tmp_path)
    assert other.computed == 4  # of another scene
    with pytest.raises(BadInput, match="Latin hypercube cannot"):
        sweep(read_scene(scene()), plan | {"method": "latin-hypercube"}, tmp_path, add=1)


OWN_UNIT = """from cosimo.tests.harness.many.points import Formula
from slope import parameter


class Own(Formula):
    needed = parameter
"""
SLOPE = """from cosimo.components.core.variables import parameter as declared

parameter = declared(1.0, "m", "of a file beside the component")
"""


def test_choices_of_files_count_by_what_is_in_them(tmp_path, monkeypatch):
    """Tables over time, FMUs, code of one's own with what it imports, as a setting, as a whole unit, and with values without which
    the scene is refused. A point of a file that has not changed is not run again."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "mine.py").write_text(OWN_UNIT)
    (tmp_path / "slope.py").write_text(SLOPE)
    tables = [tmp_path / "one.csv", tmp_path / "two.csv"]
    for table in tables:
        table.write_text("time [s],value [m]\n0,1\n2,3\n")
    shutil.copy(built("PlanarLink"), tmp_path / "link.fmu")
    with_table = read_scene({**MASS, "units": {**MASS["units"], "road": {"signals": str(tables[0])}}})
    formula = read_scene({"stop_time": 1.0, "units": {"f": {"component": f"{HERE}:Formula"}}, "master": {"step": 1.0}})
    unit = {"component": "mine:Own", "parameters": {"needed": 2.0}}

    def digests(of, method="grid", **vary):
        dependence._code.cache_clear()  # as in another process
        plan = plan_of(of, plan_settings({"method": method, "vary": {n.replace("__", "."): v for n, v in vary.items()}}))
        return StoredPlan(Task.of(of, KeepSettings(), None), plan, None).digests

    def all_digests():
        return {
            "table": digests(with_table, units__road__signals=[*map(str, tables)], m__k=[1.0, 2.0]),
            "whole unit": digests(with_table, units__road=[{"signals": str(t)} for t in tables]),
            "code": digests(formula, units__f__component=[f"{HERE}:Formula", "mine:Own"]),
            "code with values": digests(formula, "list", units__f=[unit], f__needed=[3.0]),
            "needed values": digests(
                formula, "list", units__f__component=[f"{HERE}:Formula", "mine:Own"], units__f__parameters=[{}, {"needed": 1.0}]
            ),
            "FMU": digests(with_table, units__road=[{"fmu": str(tmp_path / "link.fmu")}, {"signals": str(tables[0])}]),
            "numbers": digests(with_table, m__k=[1.0, 2.0]),
        }

    before = all_digests()
    assert {name: len({*one}) for name, one in before.items()} == {name: one.size for name, one in before.items()}
    tables[1].write_text("time [s],value [m]\n0,1\n2,5\n")
    (tmp_path / "slope.py").write_text(SLOPE.replace("1.0", "1.5"))
    with (tmp_path / "link.fmu").open("ab") as file:
        file.write(b" ")
    after = all_digests()
    same = {name: (one == after[name]).tolist() for name, one in before.items()}
    assert same == {
        "table": [True, True, False, False],
        "whole unit": [True, False],
        "code": [True, False],
        "code with values": [False],
        "needed values": [True, False],
        "FMU": [False, True],
        "numbers": [True, True],
    }


def test_a_sweep_over_tables_runs_those_again_that_have_changed(tmp_path):
    table = tmp_path / "one.csv"
    road = {"stop_time": 2.0, "units": {"road": {"signals": str(table)}}, "master": {"step": 1.0}}
    plan = {"vary": {"units.road.signals": [str(table)]}}
    for end in (3.0, 5.0):
        table.write_text(f"time [s],value [m]\n0,1\n2,{end}\n")
        swept = sweep(read_scene(road | {"record": {"signals": ["road.value"]}}), plan, tmp_path / "out", verify=False)
        assert swept.measures["road.value, maximum"].tolist() == [end]


def test_failed_points_run_again_wherever_they_are_computed(tmp_path, monkeypatch):
    """Also by other processes, where the first seconds in this one are over."""
    plan = {"vary": {"d.value": [1.0, 2.0, 3.0]}, "keep": {"functions": [f"{HERE}:fails"]}}
    sweep(read_scene(scene()), plan, tmp_path, verify=False)
    asked = []

    class Others(cluster.Workers):
        def __init__(self, jobs, address):
            self.close = lambda: None

        def rows(self, task, points):
            asked.extend(points)
            yield from execute.one_by_one(execute.PointRuns(task), iter(asked))

    monkeypatch.setattr(execute, "ALONE", 0.0)
    monkeypatch.setattr(execute, "cores", lambda: 2)
    monkeypatch.setattr(cluster, "Workers", Others)
    again = sweep(read_scene(scene()), plan, tmp_path, verify=False, retry=True, jobs=None)
    assert [values["d.value"] for _, values in asked] == [1.0, 2.0, 3.0]
    assert again.computed == 3


def test_workers_are_asked_for_where_they_are_missing(monkeypatch):
    """One message; one job needs none of them, and the default does with this process."""
    monkeypatch.setattr(execute, "ALONE", 0.0)
    for module in (cluster, execute):
        monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"--jobs.*distributed.*pip install cosimo\[cluster\], or use one job"):
        sweep(read_scene(scene()), VALUES, jobs=2)
    with pytest.raises(BadInput, match=r"--cluster.*pip install cosimo\[cluster\]"):
        sweep(read_scene(scene()), VALUES, cluster="tcp://127.0.0.1:1")
    for jobs in (1, None):
        assert set(sweep(read_scene(scene()), VALUES, jobs=jobs, verify=False).outcomes) == {"done"}
    kernels = load_scene("mass-on-spring").with_changes({"stop_time": 0.1})
    assert set(sweep(kernels, {"vary": {"spring.stiffness": [90.0, 100.0]}}, jobs=2).outcomes) == {"done"}


def test_own_functions_and_quantities_are_columns():
    keep = {"statistics": False, "functions": [f"{HERE}:last_and_first", f"{HERE}:a_third"], "quantities": ["d.twice, end"]}
    result = sweep(read_scene(scene()), {"vary": {"d.value": [1.0, 2.0]}, "keep": keep})
    assert {n: v.tolist() for n, v in result.measures.items()} == {
        "d.twice, end": [2.0, 4.0],
        "last": [2.0, 4.0],
        "rows": [2.0, 2.0],
        "a_third": [2.0 / 3.0, 4.0 / 3.0],
    }
    failed = sweep(read_scene(scene()), {"vary": {"d.value": [1.0]}, "keep": {"functions": [f"{HERE}:fails"]}})
    assert "KeyError" in failed.outcomes[0]
    with pytest.raises(BadInput, match="can be imported"):
        sweep(read_scene(scene()), {"vary": {"d.value": [1.0]}, "keep": {"functions": [f"{HERE}:nothing"]}})


@pytest.mark.full
def test_a_point_that_kills_its_process_is_a_row_and_the_others_are_done(tmp_path, monkeypatch):
    """One always does, one where it runs the first time, as if its process had been killed from outside."""
    monkeypatch.setenv("KILLED_ONCE", str(tmp_path / "once"))
    result = sweep(read_scene(scene(fatal=7.0, fatal_once=5.0)), VALUES, tmp_path, jobs=2)
    assert (tmp_path / "once").exists()
    assert [o == "done" for o in result.outcomes] == [v != 7.0 for v in range(12)]
    assert result.outcomes[7] == KILLED
    assert result.measures["d.twice, mean"][8] == 16.0


SCRIPT = f"""
import sys
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.systems.many import sweep
from {HERE} import scene
if __name__ == "__main__":
    sweep(read_scene(scene(pause=0.3)), {{"vary": {{"d.value": list(map(float, range(40)))}}}}, sys.argv[1], jobs=2)
"""


@pytest.mark.full
def test_a_script_that_each_process_would_run_again_is_one_message(tmp_path):
    """Without `if __name__ == "__main__":` no worker comes as far as a point, and no point is to blame."""
    (tmp_path / "script.py").write_text(SCRIPT.replace('if __name__ == "__main__":', "if True:"))
    command = [sys.executable, tmp_path / "script.py", tmp_path / "out"]
    done = subprocess.run(command, env={**os.environ}, capture_output=True, text=True, timeout=300)
    assert 'keep the calls of a script behind if __name__ == "__main__"' in done.stderr
    assert not parts(tmp_path / "out")


def parts(directory):
    return list(directory.glob("points/*/*.arrow"))


@pytest.mark.full
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_sweep_keeps_what_was_computed(tmp_path, monkeypatch, number):
    """Its workers write their present points and end."""
    (tmp_path / "script.py").write_text(SCRIPT)
    out = tmp_path / "out"
    process = subprocess.Popen([sys.executable, tmp_path / "script.py", out], env={**os.environ}, start_new_session=True)
    try:
        while not parts(out):
            assert process.poll() is None
            time.sleep(0.1)
        process.send_signal(number)
        process.wait()
        for _ in range(600):  # its workers, in the session of the killed one
            if not session_of(process.pid):
                break
            time.sleep(0.1)
        assert session_of(process.pid) == []
    finally:
        for worker in session_of(process.pid):
            os.kill(worker, signal.SIGKILL)
    kept = sum(feather.read_table(p).num_rows for p in parts(out))
    assert kept > 0
    monkeypatch.setattr(time, "sleep", lambda seconds: None)  # in the runs
    rest = sweep(read_scene(scene(pause=0.3)), {"vary": {"d.value": list(map(float, range(40)))}}, out)
    assert rest.computed == 40 - kept
    assert set(rest.outcomes) == {"done"}
    assert rest.measures["d.twice, mean"].tolist() == [2.0 * k for k in range(40)]


def session_of(leader):
    """Processes of a session that are left."""
    pids = []
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat") as file:
                    fields = file.read().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[3]) == leader and fields[0] != "Z":
                pids.append(int(name))
    return pids


@pytest.mark.full
def test_a_dask_cluster_gives_the_same(tmp_path, monkeypatch):
    """A scheduler and two workers as processes; one worker is killed by a point, which alone has no numbers; where both have just
    been killed, a fit waits for those that their nannies start."""
    distributed = pytest.importorskip("distributed")
    signals = {**VALUES, "keep": {"signals": ["d.twice"], "interval": 0.5}}
    here = sweep(read_scene(scene()), signals, tmp_path / "here")
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    import dask

    dask.config.refresh()
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as workers:
        address = workers.scheduler_address
        there = sweep(read_scene(scene()), signals, tmp_path / "there", cluster=address)
        fits = [fit(read_scene(scene()), LINE, tmp_path / f"fit{len(by)}", cluster=by) for by in ("", address)]
        four = {"vary": {"d.value": [1.0, 2.0, 3.0, 4.0]}}
        deadly = sweep(read_scene(scene(fatal=3.0)), four, tmp_path / "d", cluster=address)
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(2)
            for pid in client.run(os.getpid).values():
                os.kill(pid, signal.SIGKILL)
        fits.append(fit(read_scene(scene()), LINE, tmp_path / "killed", cluster=address))
    assert there.computed == 12
    assert here.measures["d.twice, mean"].tobytes() == there.measures["d.twice, mean"].tobytes()
    assert contents(tmp_path / "here") == contents(tmp_path / "there")
    assert [o == "done" for o in deadly.outcomes] == [True, True, False, True]
    assert deadly.outcomes[2] == KILLED
    assert len({f.fit.values.tobytes() for f in fits}) == 1
    assert contents(tmp_path / "killed") == contents(tmp_path / "fit0") == contents(tmp_path / f"fit{len(address)}")
    with pytest.raises(BadInput, match="address of a running scheduler"):
        sweep(read_scene(scene()), VALUES, tmp_path / "none", cluster="tcp://127.0.0.1:1")


@pytest.mark.full
def test_the_job_script_of_the_documentation_gives_the_same(tmp_path):
    """With a stand-in for srun that starts the tasks here."""
    pytest.importorskip("distributed")
    page = (Path(cosimo.__file__).parent / "docs" / "many-runs.md").read_text()
    (script,) = re.findall(r"^```sh\n(#!/bin/bash\n.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "job.sh").write_text(script)
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, text in {
        "srun": 'shift\nfor k in $(seq $SLURM_NTASKS); do "$@" & done\nwait',
        "cosimo": f'{sys.executable} -m cosimo.orchestrator.cli "$@"',
    }.items():
        (folder / name).write_text(f"#!/bin/bash\n{text}\n")
        (folder / name).chmod(0o755)
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(scene()))
    (tmp_path / "plan.toml").write_text('[vary]\n"d.value" = [1.0, 2.0, 3.0]\n')
    path = os.pathsep.join([str(folder), str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "SLURM_NTASKS": "1", "SLURM_JOB_ID": "1", "PATH": path, "TMPDIR": str(tmp_path)}
    process = subprocess.Popen(
        ["bash", "job.sh"],
        cwd=tmp_path,
        env=environment,
        start_new_session=True,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    try:
        output, _ = process.communicate(timeout=300)
    finally:
        for left in session_of(process.pid):
            os.kill(left, signal.SIGKILL)
    assert process.returncode == 0, output
    here = sweep(read_scene(scene(), "scene"), tmp_path / "plan.toml", tmp_path / "here")
    assert here.measures["d.twice, mean"].tolist() == [2.0, 4.0, 6.0]
    assert (tmp_path / "out" / "sweep.csv").read_bytes() == (tmp_path / "here" / "sweep.csv").read_bytes()
    assert not list((tmp_path / "out").glob("*.part"))
