"""Where the caches are, and whose files are taken from them.

Its text is also the start of every generated slave script, so it imports the standard library only."""

import os
import sys


def cache_root():
    """The user's cache directory of cosimo; the environment variable COSIMO_CACHE moves it."""
    home = os.path.expanduser("~")
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or os.path.join(home, "AppData", "Local")
    elif sys.platform == "darwin":
        base = os.path.join(home, "Library", "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or os.path.join(home, ".cache")
    return os.path.abspath(os.environ.get("COSIMO_CACHE") or os.path.join(base, "cosimo"))


def trusted(status):
    """Whether a file or folder is this user's or the administrator's, and nobody else may write there; `status` of os.stat."""
    return not hasattr(os, "getuid") or (status.st_uid in (0, os.getuid()) and not status.st_mode & 0o022)
