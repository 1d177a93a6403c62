"""A scene whose units are started: for one run, for many, or to be asked something."""
