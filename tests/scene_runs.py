"""Runs of scenes as tests want them: to the end, and the same as FMUs as in process."""

import numpy as np
from cosimo.orchestrator.run.results import Result
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import Scene


def finished(scene: Scene, *, in_process: bool = True, **options) -> Result:
    """The result of a run that came to its end; options: of `run`."""
    result = run(scene, in_process=in_process, **options)
    assert result.outcome == "done", result.message
    return result


def assert_fmus_give_the_same_bits(scene: Scene) -> None:
    """Every column of a run as FMUs is that of the run in process, bit by bit."""
    ours, theirs = finished(scene), run(scene)
    assert theirs.outcome == "done", theirs.message
    assert ours.columns.keys() == theirs.columns.keys()
    for column, values in ours.columns.items():
        np.testing.assert_array_equal(values, theirs.columns[column], err_msg=column)
