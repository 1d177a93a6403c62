"""What holds for all tests."""

LONG = ("test_plain_python.py", "test_readme.py")  # a worker has each as a whole: begun last, they would be waited for


def pytest_collection_modifyitems(items):
    """Long files first; where xdist keeps this order, as `--no-loadscope-reorder` in pyproject.toml tells it to."""
    items.sort(key=lambda item: item.path.name not in LONG)
