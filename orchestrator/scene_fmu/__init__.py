"""A scene as one FMU without Python, see `build`."""

from .build import build_scene_fmu, laid_out, refuse_what_needs_python, scene_block, scene_library

__all__ = ["build_scene_fmu", "laid_out", "refuse_what_needs_python", "scene_block", "scene_library"]
