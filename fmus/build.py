"""Components of the catalogue to FMU files; the same source gives the same file, byte for byte."""

from __future__ import annotations

import re
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from .. import components
from ..components.catalogue import CATALOGUE, component_class, component_name
from ..components.core import folders, store
from ..components.core.closure import closure
from ..components.core.closure import sources as source_index
from ..components.core.component import TABLES
from ..components.core.errors import BadInput
from . import loader
from .description import documentation, model_description, shared_files
from .evidence import Evidence
from .interface import interface
from .own import own_sources
from .versions import distribution

COMPONENTS = Path(components.__file__).parent
HERE = Path(__file__).parent
# what is installed: a running FMU of another maker may have put a copy of its own, without binaries, in front of it
PYTHONFMU = Path(str(distribution("pythonfmu").locate_file("pythonfmu")))
PYTHONFMU_LICENSE = distribution("pythonfmu").read_text("licenses/LICENSE") or "MIT License"
BINARIES = {"linux64": "libpythonfmu-export.so", "win64": "pythonfmu-export.dll"}

SCRIPT = """

if "{name}" in globals():
    {name} = globals()["{name}"]  # pythonfmu executes the script again at every instantiation
else:
    _bundle = load_package(os.path.join(os.path.dirname(os.path.abspath(__file__)), "{bundle}"))
    _slave = import_part(_bundle + ".slave", "{name}")
    _module = import_part(_bundle + ".components.{module}", "{name}")

    class {name}(_slave.ComponentSlave):
        component_class = _module.{name}

        def __init__(self, **kwargs):
            super().__init__(**kwargs)
            end_in_order(self.resources)

leave_path("{script}.py")
keep(globals())
"""


def build(name: str | type, directory: Path, *, derivatives: bool = False, evidence: Evidence | None = None) -> Path:
    """Write the FMU of a component to directory/<class>.fmu and return its path.

    name: of the catalogue, "module:Class", or the class.  derivatives: list "der(v)" and "der(v,2)" of each input, for masters
    that extrapolate.  evidence: of the component without effects, to be packed with it. Raises `BadInput` for a component that does
    not exist or cannot be packed.
    """
    name = name if isinstance(name, str) else component_name(name)
    members = _members(name, derivatives)[1]
    if evidence is not None:
        members |= evidence.members(False)
        members["modelDescription.xml"] = evidence.described(members["modelDescription.xml"])
        page = documentation(file_stem(name), component_class(name, "build"), section=evidence.section())
        members["documentation/index.html"] = page
    return write(members, Path(directory) / f"{file_stem(name)}.fmu")


def built(name: str) -> Path:
    """The FMU of a component of the catalogue, or of "module:Class", kept in the user's cache by digest and built if missing.

    Raises `BadInput` as `build`.
    """
    digest, members = _members(name)
    return store.kept("fmus", digest, f"{file_stem(name)}.fmu", lambda path: write(members, path))


def file_stem(name: str) -> str:
    """What the FMU of a component is called: by its class, of a table by its file."""
    if name.startswith(TABLES):
        stem = re.sub(r"\W", "_", Path(component_class(name).file).stem, flags=re.ASCII)  # type: ignore[attr-defined]
        return stem if stem[:1].isalpha() else f"table_{stem}"
    return name.rpartition(":")[2]


def sources(module: str) -> dict[str, bytes]:
    """The files a component's module needs, its import closure within `components`: relative path -> content."""
    file = COMPONENTS.joinpath(*module.split(".")).with_suffix(".py")
    paths = closure(file).keys()
    packages = {p / "__init__.py" for path in paths for p in path.parents if p.is_relative_to(COMPONENTS)}
    files = {path.relative_to(COMPONENTS).as_posix(): path.read_bytes() for path in sorted(packages | paths)}
    for where, content in files.items():
        for level, name, _ in source_index().imports(content):
            if level == 0 and name.split(".")[0] in ("components", "cosimo"):
                raise BadInput(
                    f"components/{where}",
                    f"an absolute import of {name!r}",
                    "a relative import",
                    "A bundle is imported under another name.",
                )
    return files


TABLE = """from pathlib import Path

import numpy as np

from .signals import signals_class

{stem} = signals_class({names!r}, {units!r}, np.load(Path(__file__).with_suffix(".npy")), {file!r}, hosted=True)
"""


def _table_sources(name: str) -> tuple[str, dict[str, bytes]]:
    """Module of a table and the files that it needs, with its rows beside it."""
    cls: Any = component_class(name)
    stem, rows = file_stem(name), BytesIO()
    np.save(rows, cls.table)
    columns = cls.columns()
    module = TABLE.format(stem=stem, names=list(columns), units=list(columns.values()), file=cls.file)
    return f"core.table_{stem}", {
        **sources("core.signals"),
        f"core/table_{stem}.py": module.encode(),
        f"core/table_{stem}.npy": rows.getvalue(),
    }


def slave_script() -> str:
    """What every slave script starts with: where the caches are, and how an FMU finds its code."""
    place, loading = (Path(str(m.__file__)).read_text(encoding="utf-8") for m in (folders, loader))
    return place + loading.replace("from ..components.core.folders import cache_root, trusted\n", "")


def _members(name: str, derivatives: bool = True) -> tuple[str, dict[str, bytes]]:
    """(digest, path in the FMU -> content) of a component of the catalogue, or of "module:Class"."""
    component = component_class(name, "build")
    if name.startswith(TABLES):
        where = _table_sources(name)
    else:
        where = own_sources(name, COMPONENTS) if ":" in name else (CATALOGUE[name], sources(CATALOGUE[name]))
    return fmu_members(file_stem(name), component, *where, derivatives)


def fmu_members(
    name: str, component: Any, module: str, files: dict[str, bytes], derivatives: bool = True
) -> tuple[str, dict[str, bytes]]:
    """(digest, path in the FMU -> content) of a component class that lives in `module` of the source `files`."""
    bundle = {f"components/{path}": content for path, content in files.items()}
    bundle |= {file: (HERE / file).read_bytes() for file in ("slave.py", "interface.py")}
    bundle["__init__.py"] = b""
    head = slave_script()
    short = _digest({**bundle, "name": name.encode(), "script": (head + SCRIPT).encode()})[:16]
    script = f"{name}_{short}"
    tail = SCRIPT.format(name=name, bundle=f"bundle_{short}", module=module, script=script)
    members = {f"resources/bundle_{short}/{path}": content for path, content in bundle.items()}
    members |= {f"resources/pythonfmu/{file.name}": file.read_bytes() for file in PYTHONFMU.glob("*.py")}
    members |= {f"resources/{script}.py": (head + tail).encode(), "resources/slavemodule.txt": script.encode()}
    for platform, library in BINARIES.items():
        content = (PYTHONFMU / "resources" / "binaries" / platform / library).read_bytes()
        members[f"binaries/{platform}/{name}{Path(library).suffix}"] = content
    members["documentation/index.html"] = documentation(name, component)
    members |= shared_files(name, component, (s for s in interface(component) if derivatives or not s.order))
    members["documentation/licenses/license.txt"] += b"\n\nPythonFMU\n\n" + PYTHONFMU_LICENSE.encode()
    members["modelDescription.xml"] = model_description(name, component, "", derivatives)
    digest = _digest(members)
    guid = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    members["modelDescription.xml"] = model_description(name, component, guid, derivatives)
    return digest, members


def _digest(members: dict[str, bytes]) -> str:
    return store.digest_of(*(part for path in sorted(members) for part in (path, members[path])))


def write(members: dict[str, bytes], path: Path) -> Path:
    """A zip file with sorted members and fixed dates; in place only when it is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with store.replaced(path, "wb") as whole, zipfile.ZipFile(whole, "w") as file:
        for member in sorted(members):
            info = zipfile.ZipInfo(member, (1980, 1, 1, 0, 0, 0))
            info.compress_type, info.create_system, info.external_attr = zipfile.ZIP_DEFLATED, 3, 0o644 << 16
            file.writestr(info, members[member])
    return path
