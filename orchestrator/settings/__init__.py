"""What a scene may say, as frozen, typed models: each fault of a single setting is found here. One file a table."""

from .analysis import AnalysisKeys
from .explore import ExploreSettings
from .master import ControlSettings, IterationSettings, MasterSettings
from .model import Model, Number
from .scene import ConnectionSettings, ContactSettings, FaultSettings, InterfaceSettings, RecordSettings, SceneSettings
from .study import MonolithSettings, StudySettings
from .units import SubsystemSettings, UnitSettings

__all__ = [
    "AnalysisKeys",
    "ConnectionSettings",
    "ContactSettings",
    "ControlSettings",
    "ExploreSettings",
    "FaultSettings",
    "InterfaceSettings",
    "IterationSettings",
    "MasterSettings",
    "Model",
    "MonolithSettings",
    "Number",
    "RecordSettings",
    "SceneSettings",
    "StudySettings",
    "SubsystemSettings",
    "UnitSettings",
]
