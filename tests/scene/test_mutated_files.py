"""The campaign of mutated files, in small: `python -m cosimo.tests.campaigns.mutated_files` is the large one."""

import random
from pathlib import Path

import pytest
from cosimo.tests.campaigns import mutated_files

KINDS = [kind for kind in mutated_files.KINDS if kind != "faults"]


def test_the_campaign_sees_what_counts_as_a_finding():
    outcome = mutated_files.campaign("faults", 4, 1)
    (Path(mutated_files.__file__).parent / "written-by-the-campaign").unlink()
    assert outcome["findings"] == 4
    texts = " ".join(outcome["texts"])
    for word in ("RecursionError: too deep", "several lines", "written outside: open", "the process ended with 11"):
        assert word in texts
    assert [*outcome["texts"].values()] == [0, 1, 2, 3]


def test_mutations_follow_from_the_seed():
    original = b'stop_time = 1.0\nunits.p.component = "Probe"\n'
    several = [mutated_files.mutated(original, random.Random(f"scenes 1 {k}")) for k in range(50)]
    assert several == [mutated_files.mutated(original, random.Random(f"scenes 1 {k}")) for k in range(50)]
    assert len(set(several)) > 40


@pytest.mark.parametrize(
    ("kind", "count"),
    [*((kind, 12) for kind in ("scenes", "checkpoints")), *(pytest.param(kind, 60, marks=pytest.mark.full) for kind in KINDS)],
)
def test_mutated_files_are_used_or_refused_with_one_message(kind, count):
    outcome = mutated_files.campaign(kind, count, 7)
    assert outcome["texts"] == {}
    assert outcome["used"] + outcome["refused"] == count
    assert outcome["megabytes"] < mutated_files.MEGABYTES
