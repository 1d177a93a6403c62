"""The hunt itself: what it calls right, said and missed, on a scene with a closed form."""

from __future__ import annotations

import json

import pytest
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.harness.stability_hunt import Found, hunt, main, table


def test_a_mass_on_a_spring_is_right_or_said_at_every_step_and_stiffness():
    """Its coupling is stable up to 0.121 s, 24 times its step; a stiffness 100 times larger has that limit at its own step."""
    runs = {run.change: run for run in hunt(load_scene("mass-on-spring"))}
    assert {change: run.verdict for change, run in runs.items()} == {
        "step x 1": "right", "step x 2": "right", "step x 5": "right", "step x 10": "right", "step x 20": "said",
        "step x 50": "said", "spring.stiffness x 10": "right", "spring.stiffness x 100": "said"}
    assert runs["step x 50"].outcome == "unstable"
    errors = [runs[f"step x {k}"].error for k in (1, 2, 5, 10, 20)]
    assert errors == sorted(errors)
    assert errors[-2] < 0.1 < errors[-1]


def test_the_table_counts_and_names_what_was_missed(tmp_path, capsys, monkeypatch):
    runs = [Found("a", "step x 1", "done", "", 0.01, "q", "right", 0.1),
            Found("a", "step x 2", "done", "!", 0.05, "q", "said", 0.1),
            Found("b", "step x 1", "done", "", 0.5, "q", "missed", 0.1)]
    (tmp_path / "hunt.jsonl").write_text("\n".join(json.dumps(vars(run)) for run in runs))
    monkeypatch.setattr("sys.argv", ["hunt", "-o", str(tmp_path / "hunt.jsonl"), "--table"])
    main()
    assert capsys.readouterr().out.rstrip() == table(runs)
    assert "| all | 3 | 1 | 1 | 1 | 1 | 0 | 0 | 0 |" in table(runs)
    assert "| b | step x 1 | 50 % | q |" in table(runs)


@pytest.mark.full
@pytest.mark.parametrize("scene", ["pipe-robots-in-tow", "en50318-2002"])
def test_no_scene_warns_at_its_own_settings(scene):
    own = next(iter(hunt(load_scene(scene))))
    assert (own.change, own.verdict) == ("step x 1", "right")
