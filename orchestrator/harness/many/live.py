"""What a sweep shows while it runs: a bar on the terminal, and a static page that reloads itself."""

from __future__ import annotations

import html
import sys
from collections import Counter
from contextlib import ExitStack, suppress
from pathlib import Path
from time import perf_counter, time

from ....components.core.errors import visible_in_page
from ....components.core.store import replaced
from ...run.progress import terminal_bar
from .executors import BatchRows

PAGE_EVERY = 2.0  # s
SHOWN_REASONS = 12
PAGE = """<!doctype html><html lang="en"><meta charset="utf-8">{refresh}<title>{percent:.0f} % of {title}</title><style>
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 2rem auto; padding: 0 1rem; color-scheme: light dark }}
.bar {{ height: 1.4rem; background: #8884; border-radius: .3rem; overflow: hidden; display: flex }}
.done {{ background: #0072b2 }} .failed {{ background: #d55e00 }} td {{ padding: .15rem 1rem .15rem 0; vertical-align: top }}
</style><h1>{title}</h1><div class="bar"><div class="done" style="width:{done_share:.3f}%"></div>
<div class="failed" style="width:{failed_share:.3f}%"></div></div>
<p>{state}</p><table>{rows}</table>{reasons}<p>{foot}</p></html>
"""


class Live:
    """Counts points. done and failed include what an earlier call has computed."""

    def __init__(self, directory: Path, title: str, total: int, before: int, progress: bool):
        self._path, self._title, self._total, self._before = directory / "progress.html", title, total, before
        self.done, self.failed = before, 0
        self.seconds = 0.0  # of real time in runs, of all workers
        self.workers = 1
        self._reasons: Counter[str] = Counter()
        self._since, self._page_at = perf_counter(), -PAGE_EVERY
        self._stack, self._bar = ExitStack(), None
        if progress and sys.stderr.isatty():
            self._bar = self._stack.enter_context(terminal_bar("{task.completed:g}/{task.total:g} {task.fields[failed]}"))
            self._task = self._bar.add_task(title, total=total, completed=before, failed="")

    def __enter__(self) -> Live:
        self.write("running")
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def count(self, rows: BatchRows, workers: int) -> None:
        """A batch has ended, of so many workers."""
        self.workers = workers
        self.seconds += rows.seconds
        ends = zip(rows.table.column("outcome").to_pylist(), rows.table.column("reason").to_pylist(), strict=True)
        reasons = [reason for outcome, reason in ends if outcome != "done"]
        self._reasons.update(reasons)
        self.failed += len(reasons)
        self.done += rows.table.num_rows - len(reasons)
        if self._bar is not None:
            self._bar.update(self._task, completed=self.done + self.failed, failed=f"{self.failed} failed" if self.failed else "")
        if perf_counter() - self._page_at >= PAGE_EVERY:
            self.write("running")

    def repeating(self) -> None:
        """All points have ended; some of them are run again."""
        if self._bar is not None:
            self._bar.update(self._task, description="Repeating some points with half of every step")

    def write(self, state: str) -> None:
        """The page; one that is not "running" no longer reloads itself."""
        self._page_at = perf_counter()
        spent = max(perf_counter() - self._since, 1e-9)
        ended, total = self.done + self.failed, max(self._total, 1)
        rate = (ended - self._before) / spent
        left = (self._total - ended) / rate if rate > 0.0 else float("nan")
        rows = [
            ("points", f"{ended} of {self._total}"),
            ("failed", str(self.failed)),
            ("rate", f"{rate:.3g} points/s"),
            ("time left", "–" if state != "running" or left != left else duration(left)),
            ("workers", f"{self.workers}, {100.0 * self.seconds / (spent * self.workers):.0f} % of their time in runs"),
        ]
        table = "".join(f"<tr><td>{name}<td>{value}" for name, value in rows)
        reasons = "".join(f"<tr><td>{n}<td>{html.escape(text)}" for text, n in self._reasons.most_common(SHOWN_REASONS))
        page = PAGE.format(
            refresh='<meta http-equiv="refresh" content="3">' if state == "running" else "",
            percent=100.0 * ended / total,
            title=html.escape(self._title),
            done_share=100.0 * self.done / total,
            failed_share=100.0 * self.failed / total,
            state=state,
            rows=table,
            reasons=f"<h2>Reasons</h2><table>{reasons}</table>" if reasons else "",
            foot='<a href="report.html">report</a>' if state == "done" else f"written at {int(time())} s since 1970",
        )
        with suppress(OSError), replaced(self._path) as file:  # a full disk: the points matter more
            file.write(visible_in_page(page))


def duration(seconds: float) -> str:
    """A time left, as a reader says it."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"
