"""What holds for all tests, and the fixtures that several folders share."""

from cosimo.tests.systems.railway.made_up import run  # noqa: F401
from cosimo.tests.units.foreign_fmu import foreign  # noqa: F401

LONG = ("test_plain_python.py", "test_readme.py")  # a worker has each as a whole: begun last, they would be waited for


def pytest_collection_modifyitems(items):
    """Long files first; where xdist keeps this order, as `--no-loadscope-reorder` in pyproject.toml tells it to."""
    items.sort(key=lambda item: item.path.name not in LONG)
