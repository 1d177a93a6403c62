"""Checkpoints: the rest of a run, from a file, is the same to the last bit; what does not fit is refused with one message."""

import os
import signal

import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.components.core.variables import output
from cosimo.orchestrator.engine.algorithms.master import Master
from cosimo.orchestrator.run.checkpoint import check_wish
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.run.run_record import CheckpointsRecord
from cosimo.orchestrator.units import Interface
from cosimo.orchestrator.verified_file import verified_bytes, verified_content
from cosimo.tests.engine.algorithms.bonded import bonded
from cosimo.tests.engine.stepping.test_event_location import relay
from cosimo.tests.scene_runs import finished
from cosimo.tests.short_run import full_but
from cosimo.tests.support import Linear, OfTime, two_masses


def oscillator(algorithm: str = "jacobi", degree: int = 1, *, every: int = 1, record: dict | None = None, faults=(), **master):
    scene = two_masses(algorithm, 5e-3, degree)
    scene["master"] |= master
    scene["units"]["b"] |= {"every": every} if every > 1 else {}
    return read_scene({**scene, "record": record or {}, "faults": list(faults)})


class Waves(OfTime):
    """Many outputs."""

    wave = output("m", "waves", size=30)

    def _outputs(self, t):
        self.y[:] = np.sin((1.0 + np.arange(30)) * t)


def wide():
    """Many inputs; whole arrays are recorded."""
    return read_scene(
        {
            "stop_time": 1.0,
            "connections": ["a.wave* -> b.wave*"],
            "master": {"step": 0.01, "extrapolation": 2},
            "units": {
                "a": {"component": f"{__name__}:Waves"},
                "b": {"component": "cosimo.tests.engine.algorithms.test_rows:Sink"},
            },
            "record": {"signals": ["b.area[1]"], "interval": 0.03, "snapshots": ["b.area"], "snapshot_interval": 0.07},
        }
    )


def contact():
    """Components of the catalogue, which run as FMUs."""
    return read_scene(
        {
            "stop_time": 0.4,
            "connections": ["pantograph.contact_force -> wire.force", "wire.x_out -> pantograph.wire_height"],
            "units": {
                "pantograph": {"component": "Pantograph"},
                "wire": {"component": "cosimo.tests.support:Mass", "parameters": {"m": 40.0, "k": 4000.0, "c": 150.0, "v0": 0.2}},
            },
            "master": {"step": 2e-3},
        }
    )


SCENES = {
    "jacobi": lambda: oscillator(degree=2),
    "gauss-seidel": lambda: oscillator("gauss-seidel"),
    "iterative": lambda: oscillator("iterative"),
    "a rate of its own": lambda: oscillator(every=4),
    "intervals": lambda: oscillator(record={"interval": 0.0125}),
    "milne": lambda: oscillator(control={"method": "milne", "absolute": 0.01}),
    "doubling and events": lambda: oscillator(control={"method": "doubling"}, events=["a.v_out"]),
    "energy, corrected": lambda: read_scene(
        bonded("Link", "jacobi", 0.05, 0, energy_correction=True, control={"method": "milne", "relative": 0.05})
    ),
    "events": lambda: read_scene(relay(0.07, 1, ["mass.x_out"], slope=0.3)),
    "faults": lambda: oscillator(
        faults=[
            {"signal": "a.v_out", "kind": "freeze", "begin": 0.21, "end": 0.83},
            {"signal": "b.force", "kind": "offset", "value": 3.0, "begin": 0.5},
            {"unit": "b", "kind": "lost", "begin": 0.9},
        ]
    ),
    "wide": wide,
}


def same(one, other):
    """Times, columns and snapshots to the last bit, and the counters of the master."""
    assert one.outcome == other.outcome == "done"
    assert one.time.tobytes() == other.time.tobytes()
    assert list(one.columns) == list(other.columns)
    for name in one.columns:
        assert one[name].tobytes() == other[name].tobytes(), name
    for name, snapshot in one.snapshots.items():
        assert snapshot.time.tobytes() == other.snapshots[name].time.tobytes()
        assert snapshot.values.tobytes() == other.snapshots[name].values.tobytes()
    assert one.info.energy == other.info.energy
    assert one.info.counters.stepping == other.info.counters.stepping
    assert one.info.counters.master["steps"] == other.info.counters.master["steps"]


@pytest.mark.parametrize("name", full_but(SCENES.keys() - {"milne"}, SCENES))
def test_a_resumed_run_gives_the_same_bits(name, tmp_path):
    scene, file = SCENES[name](), tmp_path / "run.checkpoint"
    whole = run(scene)
    same(whole, run(scene, checkpoint_every=0.34 * scene.stop_time, checkpoint_to=file))
    resumed = run(scene, resume=file)
    same(whole, resumed)
    assert 0.6 * scene.stop_time < resumed.info.resumed.at < 0.8 * scene.stop_time


@pytest.mark.parametrize("in_process", [False, True])
def test_fmus_and_components_go_on_from_their_own_states(in_process, tmp_path):
    scene, file = contact(), tmp_path / "run.checkpoint"
    whole = run(scene, in_process=in_process, checkpoint_every=0.15, checkpoint_to=file)
    same(whole, run(scene, in_process=in_process, resume=file))
    with pytest.raises(BadInput, match=r"a checkpoint of a run with pantograph as .* expected the same kind"):
        run(scene, in_process=not in_process, resume=file)


def test_a_resumed_run_writes_checkpoints_at_the_same_times(tmp_path):
    scene, file, other = oscillator(), tmp_path / "a", tmp_path / "b"
    whole = run(scene, checkpoint_every=0.25, checkpoint_to=file)
    assert whole.info.checkpoints == CheckpointsRecord(every=0.25, to="a", written=3, last=0.75)
    resumed = run(scene, resume=file, checkpoint_every=0.2, checkpoint_to=other)
    assert resumed.info.checkpoints.last == 0.8
    same(whole, run(scene, resume=other))
    assert run(scene).info.to_json().keys().isdisjoint({"checkpoints", "resumed"})


def test_the_first_interrupt_leaves_a_checkpoint(tmp_path, monkeypatch):
    scene, file = oscillator(), tmp_path / "run.checkpoint"
    signals = []

    def step(unit, t, h, _step=Linear._step):
        if t > 0.3675 and not signals:  # in the step that ends at 0.375
            signals.append(signal.raise_signal(signal.SIGINT))
        return _step(unit, t, h)

    with monkeypatch.context() as patch:
        patch.setattr(Linear, "_step", step)
        broken = run(scene, checkpoint_every=0.9, checkpoint_to=file)
    assert broken.outcome == "stopped"
    assert broken.message.startswith("stopped by SIGINT at t = 0.375 s")
    same(run(scene), run(scene, resume=file))


def test_a_file_holds_no_address_of_the_process(tmp_path):
    """Two runs, whose masters and units lie elsewhere in memory, write the same file."""
    for name in "ab":
        run(
            load_scene("mass-on-spring").with_changes({"stop_time": 0.1}),
            in_process=True,
            checkpoint_every=0.05,
            checkpoint_to=tmp_path / name,
        )
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_file_holds_numbers_and_texts_only(tmp_path):
    file = tmp_path / "run.checkpoint"
    run(oscillator(), checkpoint_every=0.5, checkpoint_to=file)
    assert os.listdir(tmp_path) == ["run.checkpoint"]
    kinds = set()

    def look(value):
        kinds.add(type(value))
        for one in [*value, *value.values()] if isinstance(value, dict) else value if isinstance(value, list | tuple) else ():
            look(one)

    look(verified_content(file.read_bytes()))
    assert kinds <= {type(None), bool, int, float, str, bytes, list, tuple, dict, np.ndarray}
    assert {bytes, np.ndarray, float} <= kinds


@pytest.mark.parametrize("change", [{"master.step": 4e-3}, {"a.k": 11.0}, {"stop_time": 2.0}, {"record.interval": 0.1}])
def test_a_checkpoint_of_another_scene_is_refused(change, tmp_path):
    file = tmp_path / "run.checkpoint"
    run(oscillator(), checkpoint_every=0.5, checkpoint_to=file)
    with pytest.raises(BadInput, match=r"of another scene or other settings \(scene\), expected a checkpoint of scene"):
        run(oscillator().with_changes(change), resume=file)
    run(oscillator().with_changes({"title": "Another name for the same"}), resume=file)


def test_files_that_are_no_checkpoints_are_refused(tmp_path):
    file = tmp_path / "run.checkpoint"
    with pytest.raises(BadInput, match=r"resume: got .*, expected a checkpoint that can be read\. No such file"):
        run(oscillator(), resume=file)
    run(oscillator(), checkpoint_every=0.5, checkpoint_to=file)
    whole = file.read_bytes()
    for content in (b"", b"no checkpoint", whole[:5], verified_bytes([1.0])):
        file.write_bytes(content)
        with pytest.raises(BadInput, match="expected a checkpoint that cosimo has written"):
            run(oscillator(), resume=file)
    file.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInput, match="expected a checkpoint that is not damaged"):
        run(oscillator(), resume=file)


def rewritten(file, change):
    """The file with its content changed, and a digest that fits: what only someone who means it would write."""
    content = verified_content(file.read_bytes())
    change(content)
    file.write_bytes(verified_bytes(content))


@pytest.mark.parametrize(
    "key", ["version", "name", "digest", "kinds", "tick", "t", "master", "master.units", "master.cells", "stepping", "parts"]
)
@pytest.mark.parametrize("wrong", [[], ["abc"]], ids=["missing", "a text"])
def test_a_checkpoint_with_something_else_in_it_never_gives_a_traceback(key, wrong, tmp_path):
    file = tmp_path / "run.checkpoint"
    run(oscillator(), checkpoint_every=0.5, checkpoint_to=file)

    def change(content):
        *outer, last = key.split(".")
        for name in outer:
            content = content[name]
        del content[last]
        if wrong:
            content[last] = wrong[0]

    rewritten(file, change)
    if key in ("name", "t") and wrong:  # which are for messages only
        run(oscillator(), resume=file)
    else:
        with pytest.raises(BadInput, match="resume: "):
            run(oscillator(), resume=file)


@pytest.mark.parametrize("field", ["__class__", "__dict__", "step", "restore", "unknown"])
def test_only_declared_fields_are_filled(field, tmp_path):
    file = tmp_path / "run.checkpoint"
    run(oscillator(), checkpoint_every=0.5, checkpoint_to=file)
    before = vars(Master).copy()

    def change(content):
        content["master"][field] = {"__module__": "elsewhere"}

    rewritten(file, change)
    with pytest.raises(BadInput, match=r"resume: got content that does not fit the scene .*fields of master are"):
        run(oscillator(), resume=file)
    assert vars(Master) == before


def test_a_damaged_checkpoint_is_one_message_wherever_the_damage_is(tmp_path):
    """Bytes changed, dropped and doubled at 300 seeded places: refused."""
    scene, file = oscillator(record={"interval": 0.1}), tmp_path / "run.checkpoint"
    whole = run(scene, checkpoint_every=0.5, checkpoint_to=file)
    good, rng, refused = file.read_bytes(), np.random.default_rng(5), 0
    for k in range(300):
        content, at = bytearray(good), int(rng.integers(len(good)))
        if k % 3 == 0:
            content[at] ^= int(rng.integers(1, 256))
        elif k % 3 == 1:
            del content[at : at + int(rng.integers(1, 20))]
        else:
            content[at:at] = content[at : at + int(rng.integers(1, 20))]
        file.write_bytes(content)
        try:
            same(whole, run(scene, resume=file))
        except BadInput:
            refused += 1
    assert refused == 300


@pytest.mark.parametrize(
    ("every", "to", "message"),
    [
        (0.5, None, "checkpoint_every: got 0.5 alone, expected both"),
        (None, "a", "checkpoint_to: got 'a' alone, expected both"),
        (0.0, "a", "checkpoint_every: got 0 s, expected a time within the run"),
        (1.0, "a", "checkpoint_every: got 1 s, expected"),
        (float("nan"), "a", "checkpoint_every: got nan s, expected a time within"),
        (0.5, "no/such/place", "checkpoint_to: got 'no/such/place', expected a file in a directory that can be written"),
    ],
)
def test_wishes_that_cannot_be_met_are_refused(every, to, message):
    with pytest.raises(BadInput, match=message):
        run(oscillator(), checkpoint_every=every, checkpoint_to=to)


def test_units_that_cannot_pack_are_named(tmp_path):
    interfaces = {"open": Interface("", {}, {}, {}), "shut": Interface("", {}, {}, {}, packs_state=False)}
    with pytest.raises(BadInput, match=r"checkpoint_every: got 0\.5 s, expected units whose state can go to a file; shut cannot"):
        check_wish(0.5, tmp_path / "a", oscillator(), interfaces)


def test_a_run_goes_on_where_a_checkpoint_cannot_be_written(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    result = finished(oscillator(), checkpoint_every=0.2, checkpoint_to=tmp_path / "run.checkpoint")
    assert [w for w in result.info.warnings if "the checkpoint at t = 0.2 s could not be written" in w]
    assert len([w for w in result.info.warnings if "could not be written" in w]) == 1
    assert result.info.checkpoints.written == 0
    assert os.listdir(tmp_path) == []
