"""The documentation site: built with warnings as errors, then opened in a browser that refuses every other host."""

from __future__ import annotations

import functools
import http.server
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile
import threading
from importlib.util import find_spec
from pathlib import Path

import lxml.html
import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.scene.scene import scene_files

CONTRAST = (Path(__file__).parents[1] / "contrast.js").read_text(encoding="utf-8")
DOCS = Path(__file__).resolve().parents[2] / "docs"
NEEDED = ("sphinx", "myst_nb", "furo", "latex2mathml", "ipykernel", "xarray", "zarr", "SALib", "sklearn", "emcee", "gymnasium")
pytestmark = [
    pytest.mark.full,
    pytest.mark.skipif(
        bool(missing := [n for n in NEEDED if find_spec(n) is None]),
        reason=f"not installed: {', '.join(missing)} (extras docs and test)",
    ),
]
PICTURES = [p.stem for p in (DOCS / "pictures" / "scenes").glob("*.svg")]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of a whole build, tutorials executed, from a copy of the sources."""
    source = tmp_path_factory.mktemp("source") / "docs"
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("generated", "__pycache__"))
    out = source.parent / "site"
    path = os.pathsep.join(p or os.curdir for p in sys.path)
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", str(source), str(out)],
        env={**os.environ, "PYTHONPATH": path, "COSIMO_DOCS_LIVE": "mass-on-spring"},
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return out


def test_every_component_and_scene_has_a_page(site):
    pages = [site / "generated" / "components" / f"{name}.html" for name in CATALOGUE]
    pages += [site / "generated" / "scenes" / f"{name}.html" for name in scene_files()]
    assert [p.name for p in pages if not p.is_file()] == []
    assert "<svg" in (site / "generated/components/Pantograph.html").read_text(encoding="utf-8")


def test_the_gallery_has_a_picture_of_every_scene_and_no_other():
    """Of a new scene docs/pictures/thumbnails.py makes it."""
    assert sorted(PICTURES) == sorted(scene_files())


def test_the_python_interface_is_searchable(site):
    import cosimo

    page = (site / "generated/reference/python.html").read_text(encoding="utf-8")
    assert [name for name in cosimo.__all__ if f'id="cosimo.{name}"' not in page] == []
    assert "model_" not in page  # nothing of pydantic
    assert "Pantograph" in (site / "searchindex.js").read_text(encoding="utf-8")


# Marks of an equation written as text: two primes, roots, powers, a derivative or a Greek name beside a sign. Equations in words,
# and those that have none of these marks, pass unseen.
ASCII = re.compile(
    r"\w''|\bsqrt\(|[A-Za-z_)]\^[\d(-]|(?<!['\w])\w+' [-+=] |[-+=] \w+'(?:\s|$)"
    r"|\b(?:theta|phi|psi|alpha|beta|omega|rho|zeta|tau)(?:_\w+)? [-+=*/] "
)
MEASURE = re.compile(r"\bN/m\^1\.5")  # a unit of measure; nobody writes it otherwise in a declaration


def test_no_page_has_an_equation_as_text(site):
    """In paragraphs, lists, tables and blocks of plain text; blocks of a language are programs."""
    seen = {}
    for path in site.rglob("*.html"):
        tree = lxml.html.fromstring(path.read_bytes())
        for node in tree.xpath(
            "//math | //svg | //script | //dt | //div[starts-with(@class, 'highlight-') and not(contains(@class, 'text'))]"
        ):
            node.drop_tree()
        texts = [e.text_content() for e in tree.xpath("//article//*[self::p or self::li or self::td or self::dd or self::pre]")]
        marks = [match[0] for text in texts for match in ASCII.finditer(MEASURE.sub("", text))]
        if marks and "_static" not in path.parts:
            seen[path.name] = marks[:5]
    assert seen == {}


@pytest.fixture(scope="module")
def address(site):
    """The site on this machine's own interface."""
    handler = functools.partial(
        type("Quiet", (http.server.SimpleHTTPRequestHandler,), {"log_message": lambda *_: None}), directory=str(site)
    )
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()


@pytest.fixture(scope="module")
def browser():
    """A Chromium, the system's one where there is none of playwright."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extras docs and test)")
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with sync_api.sync_playwright() as playwright:
        try:
            opened = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        except sync_api.Error as error:
            pytest.skip(f"no browser starts: {error}")
        yield opened
        opened.close()


class Visit:
    """A page as the browser sees it: what it asked of others, and what went wrong."""

    def __init__(self, browser, address: str, path: str, scheme: str = "light"):
        self.page = browser.new_page(color_scheme=scheme)
        self.elsewhere: list[str] = []
        self.errors: list[str] = []
        self.page.route("**/*", lambda route: self._route(route, address))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda message: self.errors.append(message.text) if message.type == "error" else None)
        self.page.goto(address + path, wait_until="load")

    def _route(self, route, address: str) -> None:
        if route.request.url.startswith((address, "data:", "blob:")):
            route.continue_()
        else:
            self.elsewhere.append(route.request.url)
            route.abort()

    def count(self, selector: str) -> int:
        """Elements that there are."""
        return self.page.locator(selector).count()

    def close(self) -> None:
        """The page has to be without errors and requests to others."""
        broken = self.page.evaluate(
            "[...document.images].filter(i => i.complete && !i.naturalWidth && i.loading !== 'lazy').map(i => i.src)"
        )
        self.page.close()
        assert (self.errors, self.elsewhere, broken) == ([], [], [])


@pytest.mark.parametrize(
    ("path", "selector", "least"),
    [
        ("index.html", "nav, .sidebar-tree", 1),
        ("start.html", "pre", 5),
        ("coupling.html", "math", 3),
        ("systems/railway.html", "ul.gallery svg.machine", 6),
        ("papers/index.html", "table", 10),
        ("generated/scenes/index.html", "ul.gallery svg.curve", len(PICTURES)),
        ("generated/scenes/en50318-2002.html", "svg.machine", 1),
        ("generated/components/DeepGrooveBearing.html", ".sketch svg line", 10),
        ("generated/reference/scene-keys.html", "table", 5),
        ("generated/reference/analysis-keys.html", "table", 5),
        ("generated/reference/command-line.html", "pre", 10),
        ("generated/reference/python.html", "dl.py", 30),
        ("tutorials/pantograph.html", ".plot .main-svg", 1),
        ("tutorials/bearing.html", ".plot .main-svg", 1),
        ("tutorials/classifier.html", ".plot .main-svg", 1),
        ("tutorials/force-and-speed.html", ".plot .main-svg", 1),
        ("tutorials/accuracy.html", ".plot .main-svg", 1),
        ("tutorials/component.html", "math", 1),
        ("tutorials/sweep.html", ".plot .main-svg", 1),
    ],
)
def test_a_kind_of_page_is_whole(browser, address, path, selector, least):
    visit = Visit(browser, address, path)
    visit.page.locator(selector).first.wait_for(state="attached")
    assert visit.count(selector) >= least
    assert visit.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth + 1")  # nothing runs out of the page
    visit.close()


WIDTHS = (320, 390, 480, 768, 1024, 1280, 1400, 2560)  # px
# What is wider than the column of the page, without scrolling on its own. Marks beside headings hang out a little.
BEYOND = """() => {
  if (document.documentElement.scrollWidth > innerWidth + 1) return ["the page"];
  const column = document.querySelector("article").getBoundingClientRect().right + 12;
  const scrolls = (e) => e && e.tagName !== "ARTICLE" && (getComputedStyle(e).overflowX !== "visible" || scrolls(e.parentElement));
  return [...document.querySelectorAll("article *")].filter((e) => getComputedStyle(e).display !== "inline" && e.clientWidth
    && e.getBoundingClientRect().left + e.scrollWidth > column && !scrolls(e)).map((e) => `${e.tagName} ${e.className}`).slice(0, 3);
}"""


# In a frame as wide as each window in turn: all widths of a page take what painting a window of one takes.
AT_WIDTHS = """async ([address, widths, beyond]) => {
  const frame = document.createElement("iframe");
  frame.style = "border: 0; height: 900px";
  frame.src = address;
  document.body.replaceChildren(frame);
  await new Promise((loaded) => { frame.onload = loaded; });
  if (!frame.contentDocument.querySelector("article")) return [];
  const wide = frame.contentWindow.eval(`(${beyond})`);
  return widths.map((width) => { frame.style.width = `${width}px`; return wide(); });
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_page_is_cut_or_moves_sideways_at_any_width(browser, site, address, scheme):
    pages = [*site.glob("*.html"), *site.glob("systems/*.html"), *site.glob("papers/*.html"), *site.glob("development/*.html")]
    pages += [*site.glob("generated/reference/*.html"), *sorted(site.glob("generated/*/*.html"))[::12]]
    page = browser.new_page(color_scheme=scheme)
    page.route("**/plotly*", lambda route: route.abort())
    page.goto(f"{address}llms.txt")  # a page without styles, of the same place
    wide, seen = {}, 0
    for path in pages if scheme == "light" else pages[::8]:  # colours change no width
        cut = page.evaluate(AT_WIDTHS, [address + path.relative_to(site).as_posix(), WIDTHS, BEYOND])
        wide |= {f"{path.name} at {width} px": beyond for width, beyond in zip(WIDTHS, cut, strict=False) if beyond}
        seen += len(cut) == len(WIDTHS)
    page.close()
    assert wide == {}
    assert seen > 5


def test_the_gallery_chooses_and_shows_all_without_scripts(browser, site):
    place = (site / "generated/scenes/index.html").as_uri()
    seen = "[...document.querySelectorAll('ul.gallery > li')].filter((e) => e.checkVisibility()).length"
    plain = browser.new_context(java_script_enabled=False).new_page()
    plain.goto(place)
    assert plain.locator("ul.gallery > li:visible").count() == len(PICTURES)
    assert not plain.locator(".gallery-filter").is_visible()
    plain.close()
    page = browser.new_page()
    page.goto(place)
    page.get_by_label("system").select_option("railway")
    railway = page.evaluate(seen)
    page.get_by_label("effect").select_option("second_wire")
    assert 0 < page.evaluate(seen) < railway < len(PICTURES)
    page.get_by_label("words").fill("overlap")
    assert page.locator("ul.gallery > li:visible strong").all_text_contents() == ["overlap"]
    page.close()


@pytest.mark.skipif(find_spec("ziglang") is None, reason="zig is not installed (extra 'native')")
def test_the_page_of_a_system_computes_its_scene(browser, address):
    visit = Visit(browser, address, "systems/two_axis_joint.html")
    frame = visit.page.frame_locator("iframe.live")
    frame.locator("#numbers dd").first.wait_for()
    assert "computed in" in frame.locator("#status").text_content()
    assert frame.locator("#curve1 .main-svg").count()
    visit.close()


def test_the_search_finds_a_component(browser, address):
    visit = Visit(browser, address, "search.html?q=LumpedCatenary")
    visit.page.locator("#search-results li a").first.wait_for()
    assert any("LumpedCatenary" in (a.get_attribute("href") or "") for a in visit.page.locator("#search-results li a").all())
    visit.close()


KINDS = (
    "index.html",
    "start.html",
    "new-system.html",
    "systems/railway.html",
    "papers/ball-bearing.html",
    "tutorials/bearing.html",
    "generated/components/Pantograph.html",
    "generated/scenes/index.html",
    "generated/scenes/en50318-2002.html",
    "generated/reference/python.html",
)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_can_be_read(browser, address, scheme):
    """Contrast AA of WCAG 2.2, from the colours that are drawn."""
    faint = {}
    for path in KINDS:
        visit = Visit(browser, address, path, scheme)
        seen = visit.page.evaluate(CONTRAST)
        assert seen["measured"] > 50
        if seen["pale"]:
            faint[path] = seen["pale"]
        visit.close()
    assert faint == {}


def test_a_page_can_be_used_by_keyboard_and_ear(browser, address):
    visit = Visit(browser, address, "tutorials/bearing.html")
    visit.page.locator(".plot .modebar").first.wait_for(state="attached")
    stops = "[...document.querySelectorAll('.plot *')].filter((e) => e.tabIndex >= 0 && e.closest('.modebar')).length"
    assert visit.page.evaluate(stops) == 0
    assert all(visit.page.locator(".plot").evaluate_all("all => all.map((e) => (e.ariaLabel ?? '').length > 20)"))
    visit.page.keyboard.press("Tab")
    assert visit.page.evaluate("document.activeElement.textContent").strip() == "Skip to content"
    visit.close()


def test_no_plot_is_white_in_the_dark_theme(browser, address):
    """What is drawn, not what the style sheet says: the lightest tenth of a picture's pixels."""
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed (extra test)")
    for path, selector in (
        ("tutorials/bearing.html", ".plot"),
        ("accuracy.html", "article img"),
        ("railway-contact.html", "article img"),
    ):
        visit = Visit(browser, address, path, "dark")
        visit.page.locator(selector).first.scroll_into_view_if_needed()
        visit.page.wait_for_timeout(500)
        pixels = sorted(image.open(io.BytesIO(visit.page.locator(selector).first.screenshot())).convert("L").getdata())
        assert pixels[len(pixels) // 2] < 60, path
        visit.close()


def test_dark_pages_are_dark(browser, address):
    """Paper and letters of both schemes, as luminance of their colours, 0 to 255."""

    def luminance(selector: str, what: str) -> float:
        colour = visit.page.evaluate(f"getComputedStyle(document.querySelector('{selector}')).{what}")
        red, green, blue = (float(v) for v in colour.strip("rgba()").split(",")[:3])
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    seen = {}
    for scheme in ("light", "dark"):
        visit = Visit(browser, address, "generated/components/Pantograph.html", scheme)
        seen[scheme] = luminance("body", "backgroundColor"), luminance(".signals text", "fill")
        visit.close()
    assert seen["light"][0] > 200 > 100 > seen["light"][1]
    assert seen["dark"][0] < 60 < 150 < seen["dark"][1]


@pytest.fixture(scope="module")
def axe(tmp_path_factory):
    """The source of axe-core, of the npm registry."""
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("npm is not installed")
    folder = tmp_path_factory.mktemp("axe")
    done = subprocess.run(
        [npm, "pack", "axe-core@4", "--silent"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    if done.returncode:
        pytest.skip(f"axe-core cannot be fetched: {done.stderr.strip()[:200]}")
    with tarfile.open(next(folder.glob("*.tgz"))) as package:
        return package.extractfile("package/axe.min.js").read().decode()


def test_pages_keep_the_rules_of_axe_core(browser, address, axe):
    """Without contrast, the one rule that depends on the scheme: a test of its own looks at that on all pages."""
    page, broken = browser.new_page(), []
    settings = "{resultTypes: ['violations'], rules: {'color-contrast': {enabled: false}}}"
    for path in ("index.html", "search.html", "stability.html", "generated/components/Pantograph.html"):
        page.goto(address + path, wait_until="load")
        page.evaluate(axe)
        rules = page.evaluate(f"axe.run({settings}).then((r) => r.violations.map((v) => [v.id, v.nodes[0].html]))")
        broken += [(path, *rule) for rule in rules]
    page.close()
    assert broken == []
