"""railway-contact.svg from railway-contact.csv, and the error of the present numerics, measured anew.

python docs/pictures/railway_contact.py [measure SPEED_KMH ELEMENT_M SUBSTEP_S]
"""

import csv
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
COLOURS = {
    "static kink (before)": "#c44e52",
    "four nodes, mass between lumped and consistent": "#dd8452",
    "four nodes, fourth order": "#4c72b0",
}
MARKS = {"strings": "circle", "beams": "square", "other line": "triangle"}
LEFT, RIGHT, TOP, BOTTOM, WIDTH, HEIGHT = 70, 20, 60, 50, 760, 420


def measure(speed: float, element: float, substep: float) -> float:
    """Strings: 20 Hz-filtered force over spans 5 and 6 against a sine series of 6000 modes, rms over sigma, %."""
    import numpy as np
    from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter
    from cosimo.orchestrator.run.run import run
    from cosimo.orchestrator.systems import load_scene
    from cosimo.orchestrator.systems.railway.modal import Head, Line, passage
    from cosimo.orchestrator.systems.railway.runs import at_speed

    scene = at_speed(load_scene("en50318-2002"), speed, {"catenary.element": element, "catenary.substep": substep})
    result = run(scene, in_process=True)
    reference = passage(Line(), Head(), speed / 3.6, 30.0, scene.stop_time, 6000, 5e-4)
    grid = np.linspace(240.0, 360.0, 2401)
    filtered = ButterworthFilter().apply(result["pantograph.contact_force"], 1.0 / scene.master.step)
    a = np.interp(grid, result["pantograph.contact_position"], filtered)
    b = np.interp(grid, reference[1], ButterworthFilter().apply(reference[2], 2000.0))
    return float(100.0 * np.sqrt(np.mean((a - b) ** 2)) / b.std())


def picture(rows: list[dict[str, str]]) -> str:
    x0, x1, y0, y1 = math.log10(2000), math.log10(80_000), math.log10(0.08), math.log10(12.0)

    def place(work, error):
        x = LEFT + (math.log10(work) - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT)
        return x, TOP + (y1 - math.log10(error)) / (y1 - y0) * (HEIGHT - TOP - BOTTOM)

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for error in (0.1, 0.2, 0.5, 1, 2, 5, 10):
        _, y = place(2000, error)
        out.append(
            f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="{"#333" if error == 1 else "#ddd"}"/>'
            f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{error:g} %</text>'
        )
    for work in (2000, 5000, 10_000, 20_000, 50_000):
        x, _ = place(work, 1)
        out.append(
            f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
            f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{work}</text>'
        )
    out.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 8}" text-anchor="middle">work: node steps per millisecond</text>')
    lines: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in rows:
        at = place(float(row["node steps per ms"]), float(row["error %"]))
        lines.setdefault((row["scheme"], row["case"]), []).append(at)
    for (scheme, case), points in lines.items():
        colour, dash = COLOURS[scheme], ' stroke-dasharray="5 3"' if "300" in case else ""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}"{dash}/>')
        for x, y in points:
            mark = MARKS[case.rsplit(" ", 2)[0]]
            out.append(
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>'
                if mark == "circle"
                else f'<rect x="{x - 4:.1f}" y="{y - 4:.1f}" width="8" height="8" fill="{colour}"/>'
                if mark == "square"
                else f'<path d="M{x:.1f} {y - 5:.1f}l5 9h-10z" fill="{colour}"/>'
            )
    for i, (scheme, colour) in enumerate(COLOURS.items()):
        x = LEFT + (0, 170, 500)[i]
        out.append(f'<rect x="{x}" y="12" width="10" height="10" fill="{colour}"/><text x="{x + 15}" y="21">{scheme}</text>')
    legend = "circles strings, squares beams, triangles other line; solid 250, dashed 300 km/h"
    return "\n".join([*out, f'<text x="{LEFT}" y="42">{legend}</text></svg>'])


if __name__ == "__main__":
    if sys.argv[1:2] == ["measure"]:
        print(f"{measure(*map(float, sys.argv[2:5])):.2f} %")
    else:
        with (HERE / "railway-contact.csv").open(encoding="utf-8") as file:
            (HERE / "railway-contact.svg").write_text(picture(list(csv.DictReader(file))), encoding="utf-8")
