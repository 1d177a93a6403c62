"""Units of measure: exponents, factors, conversions, messages."""

import pytest
from cosimo.components.core.errors import BadInput, decimal_point
from cosimo.components.core.measure import BASES, conversion, parse


@pytest.mark.parametrize(
    ("text", "factor", "powers"),
    [
        ("N.s/m", 1.0, {"kg": 1, "s": -1}),
        ("kg.m2", 1.0, {"kg": 1, "m": 2}),
        ("1/s", 1.0, {"s": -1}),
        ("m/s2", 1.0, {"m": 1, "s": -2}),
        ("kN/m", 1e3, {"kg": 1, "s": -2}),
        ("km/h", 1e3 / 3600.0, {"m": 1, "s": -1}),
        ("W/m2/K", 1.0, {"kg": 1, "s": -3, "K": -1}),
        ("m-1", 1.0, {"m": -1}),
        ("1", 1.0, {}),
    ],
)
def test_parse(text, factor, powers):
    unit = parse(text)
    assert unit.factor == pytest.approx(factor, rel=1e-15)
    assert dict(zip(BASES, unit.exponents, strict=True)) == {b: powers.get(b, 0) for b in BASES}


@pytest.mark.parametrize(
    ("source", "target", "value", "result"),
    [
        ("km/h", "m/s", 36.0, 10.0),
        ("mm", "m", 5.0, 5e-3),
        ("degC", "K", 20.0, 293.15),
        ("K", "degC", 293.15, 20.0),
        ("rpm", "rad/s", 30.0, 3.141592653589793),
    ],
)
def test_conversion(source, target, value, result):
    factor, offset = conversion(source, target)
    assert factor * value + offset == pytest.approx(result, rel=1e-14)


@pytest.mark.parametrize(("source", "target"), [("N", "m"), ("N.m", "N/m"), ("rad/s", "1/s")])
def test_different_quantities_are_refused(source, target):
    with pytest.raises(BadInput, match="same quantity"):
        conversion(source, target)


@pytest.mark.parametrize(
    "text", ["", "newton", "N m", "/s", "N//m", "N.", "N^2", "1000.rpm", "10.kN", "N/10", "10", "1/100", "103.N"]
)
def test_bad_units_are_refused(text):
    with pytest.raises(BadInput):
        parse(text)


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("48,5", "Write 48.5, with a decimal point."),
        ("-0,250 m", "Write -0.250, with a decimal point."),
        ("1,000 m", "Write 1.000, with a decimal point, or 1000, without a sign for thousands."),
        ("1,000.5", ""),
    ],
)
def test_a_comma_that_may_be_of_thousands_is_told_as_both(text, remedy):
    assert decimal_point(text) == remedy
