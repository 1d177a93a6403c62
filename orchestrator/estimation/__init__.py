"""State and parameters of a scene from what sensors have measured."""
