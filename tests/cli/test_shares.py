"""Shares on the command line: 1% or 0.01, and nothing that could be read as either."""

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli.options import share
from cosimo.tests.commands import exit_code


@pytest.mark.parametrize(
    ("text", "value"),
    [("1%", 0.01), ("0.01", 0.01), (" 2.5 % ", 0.025), ("100%", 1.0), ("0.5%", 0.005), ("1e-3", 1e-3), ("0.999", 0.999)],
)
def test_both_spellings_give_a_share(text, value):
    assert share("--accuracy", text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "spellings"), [("1", "1% or 0.01"), ("1.0", "1% or 0.01"), ("2.5", "2.5% or 0.025"), ("100", "100% or 1")]
)
def test_a_bare_number_of_one_or_more_is_refused_with_both_spellings(text, spellings):
    with pytest.raises(BadInput, match=spellings):
        share("--tolerance", text)


@pytest.mark.parametrize("text", ["0", "0%", "-1%", "101%", "1e3", "nan", "inf", "inf%", "nan%", "1 kg", "1%%", "%", ""])
def test_what_is_no_share_is_refused(text):
    with pytest.raises(BadInput, match="above 0 % and at most 100 %"):
        share("--accuracy", text)


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "mass-on-spring", "--in-process", "--accuracy", "1"],
        ["run", "mass-on-spring", "--in-process", "--effects", "auto", "--tolerance", "1"],
        ["effects", "mass-on-spring", "--tolerance", "1"],
    ],
)
def test_every_option_that_takes_a_share_reads_it_the_same_way(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert exit_code(*arguments) == 2
    assert "1% or 0.01" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
