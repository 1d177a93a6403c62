"""`cosimo new scene | vehicle | line | case | table`: files of a user's own to start from, which run as they are."""

from __future__ import annotations

import re
from itertools import combinations, product
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from ...components.core.errors import BadInput, counted, pick
from .asked import refuse_name
from .common import is_scene, print_written, warn
from .new import new
from .options import Conditions, InProcess, Limits, Over, limits_of, number_given, ranges_of, refuse, share

Title = Annotated[str, Option(help="Title of reports.")]
Object = Annotated[str, Option("--object", help="What is simulated, for reports: a line, a vehicle, a machine.")]
Author = Annotated[str, Option(help="Who answers for reports.")]
Organisation = Annotated[str, Option(help="Company, office or institute, for reports.")]
File = Annotated[Path, Argument(metavar="FILE.toml", help="File for the template.")]
PRESET, APART, SPEED = "EN 50318:2018", "200 m", "250 km/h"  # of pantographs under a line
LINE_NUMBERS = {  # option -> table and key of a section, unit, default
    "contact_tension": ("contact_wire", "tension", "N"),
    "contact_mass": ("contact_wire", "mass", "kg/m"),
    "messenger_tension": ("messenger", "tension", "N"),
    "messenger_mass": ("messenger", "mass", "kg/m"),
    "system_height": ("support", "system_height", "m"),
    "support_stiffness": ("support", "stiffness", "N/m"),
    "first_dropper": ("droppers", "first", "m"),
    "dropper_gap": ("droppers", "gap", "m"),
    "dropper_stiffness": ("droppers", "stiffness", "N/m"),
    "second_contact_tension": ("second_contact_wire", "tension", "N"),
    "auxiliary_tension": ("auxiliary", "tension", "N"),
    "auxiliary_mass": ("auxiliary", "mass", "kg/m"),
    "auxiliary_height": ("auxiliary", "height", "m"),
    "auxiliary_axial_stiffness": ("auxiliary", "axial_stiffness", "N"),
    "first_main_dropper": ("main_droppers", "first", "m"),
    "main_dropper_gap": ("main_droppers", "gap", "m"),
    "contact_axial_stiffness": ("contact_wire", "axial_stiffness", "N"),
    "messenger_axial_stiffness": ("messenger", "axial_stiffness", "N"),
    "stitch_half_length": ("stitch", "half_length", "m"),
    "stitch_tension": ("stitch", "tension", "N"),
    "stitch_mass": ("stitch", "mass", "kg/m"),
    "wear": ("span", "wear", "1"),
}
OF_AUXILIARY = {
    "auxiliary_tension": "14.7 kN",
    "auxiliary_mass": "1.375 kg/m",
    "auxiliary_height": "0.15 m",
}  # each with an example


def write_new(file: Path, text: str) -> None:
    """A new file; raises `BadInput` for one that is there already."""
    refuse_name(str(file))
    if file.exists():
        raise BadInput("file", f"{file}, which is there already", "a file that does not exist yet", "Give another name.")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


@new.command()
def line(
    file: File,
    supports: Annotated[
        Path,
        Argument(
            help="CSV with one row per support: 'position [m]', and if known 'contact height [m]', 'system height [m]', "
            "'stagger [m]', 'section' (overlapping sections give an overlap), 'held', 'contact stiffness [N/m]' and "
            "'main droppers' (their number up to the next support)."
        ),
    ],
    contact_tension: Annotated[str, Option(help="Tension of the contact wire.")] = "20 kN",
    contact_mass: Annotated[str, Option(help="Mass per length of the contact wire.")] = "1.35 kg/m",
    messenger_tension: Annotated[str, Option(help="Tension of the messenger wire.")] = "16 kN",
    messenger_mass: Annotated[str, Option(help="Mass per length of the messenger wire.")] = "1.08 kg/m",
    system_height: Annotated[str, Option(help="System height of supports without one in the table.")] = "1.2 m",
    support_stiffness: Annotated[str, Option(help="Stiffness of the messenger's supports.")] = "500 kN/m",
    first_dropper: Annotated[
        str, Option(help="Distance of the first dropper from a support, if there is no table of droppers.")
    ] = "4.5 m",
    dropper_gap: Annotated[str, Option(help="Largest distance between two droppers.")] = "6.5 m",
    dropper_stiffness: Annotated[str, Option(help="Stiffness of a dropper in tension.")] = "200 kN/m",
    second_contact_tension: Annotated[
        str, Option(help="Tension of a second contact wire beside the first, with its mass and droppers. Default: none.")
    ] = "",
    auxiliary_tension: Annotated[
        str, Option(help="Tension of the auxiliary wire of a compound line. Default: no such wire.")
    ] = "",
    auxiliary_mass: Annotated[str, Option(help="Mass per length of the auxiliary wire.")] = "",
    auxiliary_height: Annotated[str, Option(help="Height of the auxiliary wire above the contact wire's supports.")] = "",
    auxiliary_axial_stiffness: Annotated[str, Option(help="EA of an auxiliary wire without automatic tensioning.")] = "",
    first_main_dropper: Annotated[
        str, Option(help="Distance of the auxiliary wire's first dropper from a support, if the table does not count them.")
    ] = "",
    main_dropper_gap: Annotated[str, Option(help="Largest distance between two droppers of the auxiliary wire.")] = "",
    contact_axial_stiffness: Annotated[
        str, Option(help="EA of a contact wire without automatic tensioning, whose tension changes with temperature.")
    ] = "",
    messenger_axial_stiffness: Annotated[str, Option(help="EA of a messenger wire without automatic tensioning.")] = "",
    stitch_half_length: Annotated[
        str, Option(help="Distance of a stitch wire's clamps from the support. Default: no stitch.")
    ] = "",
    stitch_tension: Annotated[str, Option(help="Tension of the stitch wires.")] = "",
    stitch_mass: Annotated[str, Option(help="Mass per length of the stitch wires.")] = "",
    wear: Annotated[
        str, Option(metavar="SHARE", help="Share of the contact wire's section gone when the droppers were cut, as in 10%.")
    ] = "",
    droppers: Annotated[
        Path | None, Option(help="CSV of droppers. cosimo checks that they fit; the scene refers to the file.")
    ] = None,
) -> None:
    """Write the table of an overhead line from its supports. Example: cosimo new line my-line.toml supports.csv

    Wires and droppers as options with their units, such as --contact-tension "22 kN".
    """
    from ..systems.railway import line as lines
    from ..systems.railway.new_line import line_text, supports_of

    given = locals()
    data: dict[str, dict[str, float]] = {table: {} for table, _, _ in LINE_NUMBERS.values()}
    for option, (table, key, unit) in LINE_NUMBERS.items():
        text, name = given[option], f"--{option.replace('_', '-')}"
        if text:
            data[table][key] = share(name, text) if unit == "1" else number_given(text, unit, name, bare=False)
        if text and key == "axial_stiffness":
            data[table]["fixed"] = True
    sections = supports_of(supports)
    counted_droppers = any("main droppers" in support for own in sections.values() for support in own)
    if counted_droppers or data["auxiliary"] or data["main_droppers"]:
        data["main_droppers"]["stiffness"] = data["droppers"]["stiffness"]
        for option, example in OF_AUXILIARY.items():
            if not given[option]:
                name = f"--{option.replace('_', '-')}"
                raise BadInput(
                    name, "nothing, beside others of an auxiliary wire", "its value with its unit", f'As in {name} "{example}".'
                )
    text = line_text(file.stem, f"supports of {supports.name}; wires and droppers as given to cosimo new line", sections, data)
    write_new(file, text)
    try:
        form, _ = lines.read(file, {}, droppers)
    except BadInput:
        file.unlink()
        raise
    print_written([file])
    main = sum(lower in form.layout.auxiliary_lanes for lower in form.layout.droppers.lower)
    supports_, droppers_ = counted(form.support.size, "messenger support"), counted(form.preload.size - main, "dropper")
    droppers_ += f", {counted(main, 'main dropper')}" if main else ""
    print(f"{supports_} between the anchors, {droppers_}; next: cosimo show {file}")


@new.command()
def scene(
    file: File,
    units: Annotated[
        list[str] | None,
        Argument(metavar="[NAME=]COMPONENT...", help="Units: components, module:Class or FMUs. cosimo connects their ports."),
    ] = None,
    table: Annotated[
        Path | None,
        Option(
            "--input",
            metavar="FILE",
            help="With units: table over time. Its columns drive the unconnected inputs of the same names.",
        ),
    ] = None,
    source: Annotated[str, Option("--from", metavar="SCENE", help="Copy this shipped scene instead.")] = "",
    line: Annotated[Path | None, Option(help="Put pantographs under the line of this table instead.")] = None,
    droppers: Annotated[Path | None, Option(help="CSV of droppers of the line.")] = None,
    pantograph: Annotated[str, Option(help="Preset of Pantograph, or a file of cosimo railway fit-pantograph.")] = PRESET,
    pantographs: Annotated[int, Option(min=1, max=4, help="Number of pantographs.")] = 1,
    distance: Annotated[str, Option(help="Distance between two pantographs, in m or with a unit.")] = APART,
    speed: Annotated[str, Option(help="Speed of the train.")] = SPEED,
    static_force: Annotated[str, Option(help="Static force of a fitted pantograph, as in 70 N.")] = "",
    working_height: Annotated[
        str,
        Option(help="Height above the unloaded wire at which the lowest spring of a fitted pantograph is relaxed, as in 0 m."),
    ] = "",
    temperature: Annotated[str, Option(metavar="K", help="Temperature above that of the line's table, as in -30 or 40.")] = "",
    wear: Annotated[
        str, Option(metavar="SHARE", help="Share of the contact wire's section gone since the droppers were cut, as in 20%.")
    ] = "",
    limits: Limits = "",
    title: Title = "",
    object_: Object = "",
    author: Author = "",
    organisation: Organisation = "",
) -> None:
    """Write a scene that runs. Example: cosimo new scene my-scene.toml Pantograph Catenary

    Or of a line: cosimo new scene my-scene.toml --line my-line.toml --pantographs 2 --speed "250 km/h" --limits en50367

    Or like another: cosimo new scene my-scene.toml --from friction-drive-step
    """
    from ..systems import load_scene
    from ..systems.railway.line import read as read_form
    from ..systems.railway.new_line import scene_text

    if (line is not None) + bool(units) + bool(source) != 1:
        given = [what for what, is_given in (("units", units), ("--line", line), ("--from", source)) if is_given]
        raise BadInput("new scene", " and ".join(given) or "nothing to make it of", "units, or --line, or --from")
    if table is not None and not units:
        raise BadInput("new scene", "--input without units", "units whose inputs the table drives")
    if line is None:
        texts = {"--static-force": static_force, "--working-height": working_height, "--temperature": temperature, "--wear": wear}
        others = {"--pantograph": pantograph != PRESET, "--pantographs": pantographs > 1, "--distance": distance != APART}
        refuse({"--droppers": droppers, **texts, **others, "--speed": speed != SPEED}, "no effect without --line")
    tables: dict[Path, bytes] = {}
    if source:
        text, tables = _copied_scene(file, source)
        text = f'limits = "{limits}"\n{text}' if limits else text
    elif line is not None:
        number_given(speed, "m/s", "--speed", bare=False)
        apart = number_given(distance, "m", "--distance")
        own = {
            key: number_given(value, unit, f"--{key.replace('_', '-')}", bare=False)
            for key, value, unit in (("static_force", static_force, "N"), ("working_height", working_height, "m"))
            if value
        }
        later = {"temperature.change": number_given(temperature, "K", "--temperature")} if temperature else {}
        later |= {"wear.share": 0.0 if wear in ("0", "0%") else share("--wear", wear)} if wear else {}
        read_form(line, {}, droppers)  # refuses forces of droppers that cannot be, here and not in the first run
        text, taken = scene_text(
            file.stem, file.parent, line, droppers, pantograph, pantographs, apart, speed, limits, own=own, later=later
        )
        warn(taken)
    else:
        text = _joined_scene(file, units or [], limits, table)
    write_new(file, with_document(text, title, object_, author, organisation))
    for table, content in tables.items():
        table.write_bytes(content)
    try:
        load_scene(file)
    except BadInput:
        for path in (file, *tables):
            path.unlink()
        raise
    print_written([file, *tables])
    print(f"next: cosimo run {file} -o out, or first cosimo run {file} --dry-run")


def with_document(text: str, title: str, object_: str, author: str, organisation: str) -> str:
    """The text of a scene or a case with what the first page of its reports says, if anything; raises `BadInput` for one that has
    such a table."""
    from tomli_w import dumps

    given = {"title": title, "object": object_, "author": author, "organisation": organisation}
    document = {key: value for key, value in given.items() if value}
    if not document:
        return text
    if re.search(r"^\[document\]", text, re.MULTILINE):
        raise BadInput(
            "new scene", f"--{', --'.join(document)}", "", "The scene has a [document] already: change it in the new file."
        )
    return f"{text.rstrip()}\n\n{dumps({'document': document})}"


@new.command()
def vehicle(
    file: File,
    data: Annotated[
        Path,
        Argument(
            metavar="VEHICLE.toml",
            help="Mass, inertia, thrusters, and if known added_mass, linear_damping, quadratic_damping: six numbers, 6 x 6, or for "
            "added_mass a WAMIT file.",
        ),
    ],
    sensors: Annotated[
        bool, Option("--sensors", help="Put sensors with noise, bias and lost samples before the controller.")
    ] = False,
) -> None:
    """Write a scene of an underwater vehicle. Example: cosimo new vehicle my-scene.toml my-vehicle.toml"""
    from ..scene.scene import scene_text
    from ..systems import load_scene
    from ..systems.rov.own_vehicle import vehicle_scene

    remark = f"vehicle of {data.name}; current, lag of the thrusters and gains are choices, scaled by its mass"
    write_new(file, scene_text(vehicle_scene(data, sensors), (remark,)))
    try:
        load_scene(file)
    except BadInput:
        file.unlink()
        raise
    print_written([file])
    print(f"next: cosimo run {file} --in-process -o out")


def _copied_scene(file: Path, source: str) -> tuple[str, dict[Path, bytes]]:
    """The text of a scene for a file of another folder, and the tables that it names, to stand beside that file."""
    from ..scene.files import read_text, scene_path

    origin = scene_path(source, "--from")
    if origin.suffix != ".toml":
        raise BadInput("--from", repr(source), "a scene in TOML")
    text = re.sub(r"^#:schema .*\n", "", read_text(origin))
    tables = {}
    for name in set(re.findall(r'"([^"\n]+\.[a-z]+)"', text)):
        table, beside = origin.parent / name, file.parent / Path(name).name
        if not table.is_file():
            continue
        if beside.exists() or beside == file:
            raise BadInput(
                "file", f"{beside}, which is there already", "a folder without it", f"{source} brings a table of that name."
            )
        tables[beside] = table.read_bytes()
        text = text.replace(f'"{name}"', f'"{beside.name}"')
    return text, tables


def _joined_scene(file: Path, units: list[str], limits: str, table: Path | None) -> str:
    """A scene of units with their ports joined: each pair of ports that fit each other and nothing else of the pair of units."""
    from ...components.catalogue import component_class
    from ..scene.build import scene_data, snake_case
    from ..scene.build import unit as unit_of
    from ..scene.inputs import with_columns
    from ..scene.scene import scene_text
    from ..systems import load_scene, read_scene
    from ..units.signal_files import read_signals

    named: dict[str, Any] = {}
    starts, stops, steps = [], [], []
    for text in units:
        name, _, what = text.rpartition("=")
        name = name or snake_case(what.rpartition(":")[2].rpartition("/")[2].removesuffix(".fmu"))
        if name in named:
            raise BadInput(
                "new scene", f"two units {name!r}", "names that are unique", "As in first=Pantograph second=Pantograph."
            )
        if not what.endswith(".fmu"):
            component_class(what, "new scene")  # a near name where there is none
        alone = load_scene(what)
        starts.append(alone.start_time)
        stops.append(alone.stop_time)
        steps.append(alone.master.step)
        named[name] = unit_of(_beside(Path(what), file) if what.endswith(".fmu") else what)
    data = scene_data(named, (), max(stops), min(steps), {}, {"title": file.stem})
    data |= {"start_time": min(starts)} if any(starts) else {}
    coupling = read_scene(data, file.stem, file.parent).coupling
    joined = [f"{a} <-> {b}" for one, other in combinations(named, 2) for a, b in _fitting(one, other, coupling)]
    data["connections"] = joined
    if table is not None:
        rows = read_signals(table, "--input").table
        begin = {"start_time": float(rows[0, 0])} if rows[0, 0] else {}
        data |= {"stop_time": float(rows[-1, 0]), **begin}
        data, remark = with_columns(read_scene(data, file.stem, file.parent), table, _beside(table, file))
        data["units"] |= named
        warn([remark] if remark else [])
    return scene_text({**data, **({"limits": limits} if limits else {})})


def _beside(path: Path, file: Path, elsewhere: str = "") -> str:
    """A path as a file names it: from its folder on where the path lies there, else in full, or `elsewhere`."""
    whole, folder = path.resolve(), file.parent.resolve()
    return whole.relative_to(folder).as_posix() if whole.is_relative_to(folder) else elsewhere or str(whole)


def _fitting(one: str, other: str, coupling: Any) -> list[tuple[str, str]]:
    """Pairs of ports of two units that join at least two members, or all of one of them; each port once, the largest first."""
    from ..engine.coupling.ports import port_names, port_pairs

    interfaces, counts = coupling.interfaces, []
    for a, b in product(port_names(interfaces[one]), port_names(interfaces[other])):
        try:
            counts.append((len(port_pairs(((one, a), (other, b)), "", interfaces)), f"{one}.{a}", f"{other}.{b}"))
        except BadInput:
            continue
    chosen: list[tuple[str, str]] = []
    for count, a, b in sorted(counts, reverse=True):
        if count > 1 and not any(a in pair or b in pair for pair in chosen):
            chosen.append((a, b))
    return chosen


@new.command()
def case(
    file: File,
    scene: Annotated[str, Argument(help="Shipped scene or scene file.")],
    speeds: Annotated[
        str, Option(metavar="SPEED,...", help='As in "200 km/h, 250 km/h": a run for each, over the same way.')
    ] = "",
    limits: Limits = "",
    conditions: Conditions = None,
    over: Over = None,
    title: Title = "",
    object_: Object = "",
    author: Author = "",
    organisation: Organisation = "",
) -> None:
    """Write a validation case of a scene of yours. Example: cosimo new case my-case.toml my-scene.toml --limits en50367

    With --speeds "200 km/h, 250 km/h" it has a run for each speed, with --over catenary.temperature.change=-30,40 for each of these
    values, with several options for each combination.

    Ranges and measured curves of your own are added to the file.
    """
    from ..harness.validation.own import read_case
    from ..systems import load_scene, summary

    if not limits:
        raise BadInput("new case", "no --limits", "a table to judge by, such as en50367; rows of your own are added to the file")
    if not is_scene(scene):
        raise BadInput("new case", repr(scene), "Shipped scene or scene file.")
    loaded = load_scene(scene)
    moving = [n for n, u in loaded.units.items() if "speed" in u.parameters]
    name = _beside(Path(scene), file, scene) if Path(scene).suffix else scene
    place = (limits_of(limits, conditions) or {})["table"]
    parts = [f'title = "{loaded.title or loaded.name}"', f'scene = "{name}"']
    parts += [
        f'limits = {{ table = "{place}", conditions = {conditions!r} }}'.replace("'", '"')
        if conditions
        else f'limits = "{place}"',
        "",
    ]
    ways: list[tuple[str, list[str]]] = []  # a condition, and its changes as TOML
    for text in filter(None, (part.strip() for part in speeds.split(","))):
        if not moving:
            raise BadInput("--speeds", repr(text), "a scene whose units have a parameter speed")
        v = number_given(text, "m/s", "--speeds", bare=False)
        if loaded.start_time:
            raise BadInput("--speeds", f"{scene}, which starts at {loaded.start_time:g} s", "a scene that starts at 0")
        stop = loaded.stop_time * float(loaded.units[moving[0]].parameters["speed"]) / v
        step = loaded.master.step
        ways.append((text, [*(f'"{unit}.speed" = "{text}"' for unit in moving), f"stop_time = {round(stop / step) * step:.9g}"]))
    axes = [ways] if ways else []
    for place, values in ranges_of(over).items():
        if isinstance(values, dict):
            low, high, points = values["from"], values["to"], values["points"]
            values = [low + (high - low) * k / max(points - 1, 1) for k in range(points)]
        loaded.with_changes({place: values[0]})  # the scene refuses what it has not
        shown = [(f"{v:g}", f"{v:.9g}") if isinstance(v, float) else (v, f'"{v}"') for v in values]
        axes.append([(f"{place.partition('.')[2]} = {words}", [f'"{place}" = {toml}']) for words, toml in shown])
    for chosen in product(*axes) if axes else ():
        changes = [change for _, own in chosen for change in own]
        parts += [
            "[[runs]]",
            f'condition = "{", ".join(words for words, _ in chosen)}"',
            f"changes = {{ {', '.join(changes)} }}",
            "",
        ]
    write_new(file, with_document("\n".join(parts), title, object_, author, organisation))
    try:
        read_case(file, load_scene, summary)
    except BadInput:
        file.unlink()
        raise
    print_written([file])
    print(f"next: cosimo validate {file} -o out --pdf")


@new.command()
def table(
    file: File,
    scene: Annotated[str, Argument(help="Shipped scene or scene file. cosimo runs it once.")],
    standard: Annotated[
        str, Option(help="Only the figures that a standard is about, with their places in it: iec63453, en50318 or tsi-ene.")
    ] = "",
    in_process: InProcess = True,
) -> None:
    """Write a table of limits with a row for each figure of a scene. Example: cosimo new table my-limits.toml my-scene.toml

    Or with the rows of a standard: cosimo new table mine.toml en50318-2018-ac-simple --standard iec63453

    Every row is missing its range, and nothing passes by it; the number of one run stands beside it. Fill in low, high, standing and
    source. Then: cosimo run my-scene.toml --limits my-limits.toml
    """
    from ..harness.validation.reference import MISSING, STANDINGS
    from ..systems import run
    from ..systems.railway.standards import FRAMES, framed

    if standard:
        pick(standard, FRAMES, "--standard", "one of " + ", ".join(FRAMES))  # before the run

    result = run(scene, in_process=in_process, verify="no")
    if result.outcome != "done":
        raise BadInput("new table", f"a run that {result.outcome}: {result.message}", "a scene that reaches its end")
    rows = [row for row in result.summary if isfinite(row.value) and not row.part]
    title, places = framed(standard, rows) if standard else ("", [(row, "") for row in rows])
    if not places:
        what = f"{result.scene.name}, which has no figures{' of that standard' if rows else ''}"
        raise BadInput("new table", what, "a scene of pantographs" if rows else "a scene whose [analysis] has a system")
    standings = ", ".join(standing for standing in STANDINGS if standing != MISSING)
    parts = [
        f"# Fill in of each row low, high or both, its standing ({standings}; unconfirmed needs a confidence), and source, a key of",
        "# [sources]. Remove rows that nothing limits. A number of a run is no source of a limit for it.",
        "",
        "[sources]",
        f'# sheet = "{title or "where ranges are from: document"}, page, date"',
        "",
    ]
    for row, place in places:
        parts += [f"# {title}, {place}"] if place else []
        parts += ["[[rows]]", f'quantity = "{row.text}"', f'measure = "{row.name}"', f'unit = "{row.unit}"']
        parts += [f'standing = "{MISSING}"  # {row.value:.6g} in one run of {result.scene.name}', ""]
    write_new(file, "\n".join(parts))
    print_written([file])
    print(f"{counted(len(places), 'row')} without ranges: fill them in; next: cosimo run {scene} --limits {file}")
