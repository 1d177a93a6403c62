"""Equations written as text become formulas, and words stay words."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "site"))
equations = pytest.importorskip("equations")


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("m1 z1'' = k1 (z2 - z1)", r"m_{1} \ddot{z}_{1} = k_{1} \left(z_{2} - z_{1}\right)"),
        ("w = d + F_ref / k(x)", r"w = d + \frac{F_{\mathrm{ref}}}{k\left(x\right)}"),
        ("rho/2 pi R³", r"\frac{\rho}{2} \pi R^{3}"),  # without spaces the slash binds closer
        ("2 pi n x / L", r"\frac{2 \pi n x}{L}"),  # with spaces the product before it is divided
        ("G = sum over balls 1 / (1/Gi + 1/Go)", r"G = \sum_{\text{balls}} \frac{1}{\frac{1}{G_{i}} + \frac{1}{G_{o}}}"),
        ("Q = K delta_j^1.5", r"Q = K \delta_{j}^{1.5}"),
        ("(R^T v_c)'", r"\frac{d}{dt} \left(R^{T} v_{c}\right)"),
        ("load of wheel k = R Q_k . t_k", r"\text{load of wheel} \; k = R Q_{k} \cdot t_{k}"),
        ("D = [[a, -b], [c, d]]", r"D = \left[\begin{matrix}a & - b \\ c & d\end{matrix}\right]"),
        ("q |q|", r"q \left\vert q\right\vert "),
    ],
)
def test_an_equation(text, formula):
    assert equations.latex(text) == formula


@pytest.mark.parametrize("text", ["a = (b", "/ b", "a = §", "^2"])
def test_what_is_none_is_refused(text):
    with pytest.raises(equations.NotAnEquation):
        equations.latex(text)


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("the current is (V - k N w) / R.", r"the current is $\frac{V - k N w}{R}$."),
        ("w is the rate, N a ratio", "$w$ is the rate, N a ratio"),
        ("a motor of 12 V and 300 N/m", "a motor of 12 V and 300 N/m"),
        ("damping (s/m) as a number", "damping (s/m) as a number"),
        ("`k_s = 2` stays code", "`k_s = 2` stays code"),
        ("20 Hz-filtered - and so on", "20 Hz-filtered - and so on"),
    ],
)
def test_a_sentence(text, written):
    assert equations.sentences(text, {"w", "V", "a"}) == written


def test_every_equation_of_a_component_is_read():
    from cosimo.orchestrator.harness.component_page import component_pages

    blocks = [(page.name, p.text) for page in component_pages(count_states=False) for p in page.text if p.kind == "equations"]
    assert len(blocks) > 30
    for name, text in blocks:
        assert equations.block(text).startswith("$$"), name
