"""The documentation site: `sphinx-build -W --keep-going docs out/site`, with the extra `docs`.

Pages of components, scenes, settings and the Python interface are written from the declarations into `generated` first; tutorials
are executed. Nothing on the site asks another host for anything.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "site"))

import cosimo_pages  # noqa: E402  (needs the path above)
import live  # noqa: E402
import plotly  # noqa: E402

project = "cosimo"
author = "the authors of cosimo"
release = version = cosimo_pages.version()
html_title = f"cosimo {release}"

extensions = ["myst_nb", "cosimo_pages", "mathml", "search", "accessible"]
exclude_patterns = ["site/*", "out/*"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["toc.not_included"]  # the index links every page, which tests/documentation/test_readme.py looks at
html_math_renderer = "mathml"

python_maximum_signature_line_length = 80

html_theme = "furo"
html_static_path = [str(HERE / "site" / "static")]
html_extra_path = [str(HERE / "llms.txt")]  # for programs that read the site
html_css_files = ["site.css"]
html_js_files = ["plots.js", "scrolling.js"]
html_search_scorer = str(HERE / "site" / "static" / "scorer.js")
html_show_sphinx = html_show_copyright = False
html_copy_source = False
pygments_style = "a11y-high-contrast-light"  # AA, as furo has it
pygments_dark_style = "a11y-high-contrast-dark"

nb_execution_mode = "force" if os.environ.get("COSIMO_DOCS_NOTEBOOKS", "run") == "run" else "off"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

# Cells that end in a figure show it with the site's one copy of Plotly: see site/plots.py.
_profile = Path(tempfile.mkdtemp(prefix="cosimo-docs-"))
(_profile / "profile_default" / "startup").mkdir(parents=True)
shutil.copy(HERE / "site" / "plots.py", _profile / "profile_default" / "startup")
os.environ["IPYTHONDIR"] = str(_profile)


def setup(app):
    """Put Plotly, which comes with its Python package, and live scenes beside the pages; remove the profile of the notebooks."""

    def copy_plotly(app, exception):
        shutil.rmtree(_profile, ignore_errors=True)
        if exception is None and app.builder.format == "html":
            source = Path(plotly.__file__).parent / "package_data" / "plotly.min.js"
            shutil.copy(source, Path(app.outdir) / "_static")
            live.build(Path(app.outdir))

    app.connect("build-finished", copy_plotly)
