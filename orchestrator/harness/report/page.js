// Figures are drawn when they come near the screen, and all of them before printing.
function draw(element, dark = wantsDark.matches) {
  const scheme = dark ? "dark" : "light";
  if (element.dataset.drawn === scheme) return;
  element.dataset.drawn = scheme;
  const json = document.getElementById(element.id + "-data").textContent;
  const spec = JSON.parse(dark ? recoloured(json) : json);
  if (location.hash === "#print") {
    flatter(element, spec.layout);
    spec.data = spec.data.filter((trace) => trace.visible !== "legendonly"); // no one switches it on
  }
  const coarse = spec.data.map(({ x, y, xaxis = "x" }) => ({ x, y, xaxis })); // Plotly changes what it is given
  return Plotly.newPlot(element, spec.data, spec.layout, config).then(() => {
    element.querySelectorAll(".modebar-btn").forEach((button) => { button.tabIndex = -1; }); // Tab goes on to the text
    if (spec.frames) Plotly.addFrames(element, spec.frames);
    if (samplesFile || document.getElementById("samples-inside")) element.on("plotly_relayout", () => refine(element, coarse));
  });
}
const { paper } = document.getElementById("page").dataset, MM = 96 / 25.4; // px
const SHEETS = { A4: [184, 267], Letter: [189.9, 249.4] }; // mm, without margins
const PRINTED = 0.66; // height of the panels of a printed figure over that on a screen, before it is fitted to its sheet
function flatter(element, layout) {
  if (layout.sliders?.length) { // no one moves it on paper
    layout.height -= Math.max(0, layout.margin.b - 48);
    layout.margin.b = 48;
    layout.sliders = layout.updatemenus = [];
  }
  const around = layout.margin.t + layout.margin.b; // legend, labels
  const most = Math.min(MM * SHEETS[paper][1] - 90, around + Math.max(PRINTED * (layout.height - around), 130)); // no longer than a sheet
  layout.height = Math.round(square(layout) ? Math.min(most, around + tallest(layout)) : most);
  element.style.height = `${layout.height}px`;
}
const panels = (layout, way) => Object.entries(layout).filter(([key]) => key.startsWith(`${way}axis`)).map(([, axis]) => axis);
const square = (layout) => panels(layout, "y").some((y) => y.scaleanchor); // an orbit has no more height than its width allows
function tallest(layout) { // px that panels of one row need where a length is the same in both directions
  const width = MM * SHEETS[paper][0] - layout.margin.l - layout.margin.r, [xs, ys] = ["x", "y"].map((way) => panels(layout, way));
  if (ys.some((y) => !y.scaleanchor || !y.range || (y.domain ?? [0, 1])[1] - (y.domain ?? [0, 1])[0] < 0.99)) return Infinity;
  const long = ({ range }) => range[1] - range[0];
  return Math.max(...ys.map((y, k) => (width * (xs[k].domain[1] - xs[k].domain[0]) * long(y)) / long(xs[k])));
}
// Sheets are filled: figures of one that ends early grow, those of one that the next figure nearly fits on shrink.
const GROWN = 1.5, SHRUNK = 0.72; // at most, of the panels
const SAFE = 0.985; // a sheet is taken for a little shorter than it is
async function fillSheets() {
  const height = SAFE * MM * SHEETS[paper][1];
  const box = (e) => e.getBoundingClientRect(), places = [...document.querySelectorAll("main figure")];
  const motions = [...document.querySelectorAll("figure.motion canvas")];
  const inner = (plot) => plot.layout.height - plot.layout.margin.t - plot.layout.margin.b, usual = new Map(plots.map((p) => [p, inner(p)]));
  const scale = (some, factor) => Promise.all(some.map((plot) => {
    const grown = square(plot.layout) ? 1 : GROWN;
    const high = Math.round(Math.min(Math.max(factor * inner(plot), SHRUNK * usual.get(plot)), grown * usual.get(plot))) + plot.layout.height - inner(plot);
    plot.style.height = `${high}px`;
    return Plotly.relayout(plot, { height: high });
  }));
  const begins = (figure) => { // with the headings that stay with it
    let first = figure;
    while (/^H\d$/.test(first.previousElementSibling?.tagName)) first = first.previousElementSibling;
    return first;
  };
  let top = box(document.body).top, here = [];
  for (const figure of places) {
    const plot = figure.querySelector(".plot"), first = begins(figure);
    while (box(first).top > top + height) { top += height; here = []; } // text and tables run over to the next sheet
    const over = box(figure).bottom - top - height;
    if (over > 0) {
      const all = [...here, ...(plot ? [plot] : [])], room = all.reduce((sum, p) => sum + inner(p) - SHRUNK * usual.get(p), 0);
      const total = (some) => some.reduce((sum, p) => sum + inner(p), 0);
      if (over <= room) await scale(all, 1 - over / total(all));
      if (box(figure).bottom - top - height > 1) { // the next sheet begins with it
        if (here.length) await scale(here, 1 + (top + height - box(first).top) / total(here));
        const picture = motions.filter((c) => box(c).top > top && box(c).bottom < box(first).top).at(-1), left = top + height - box(first).top;
        if (picture && left > 40) picture.style.height = `${Math.min(picture.clientHeight + left, 360)}px`; // its script draws it anew
        top = box(first).top;
        here = [];
      }
    }
    if (plot) here.push(plot);
  }
}
async function layOut() { // as it will be printed
  const [width] = SHEETS[paper];
  for (const { cssRules } of document.styleSheets) for (const rule of cssRules) if (rule.media?.mediaText === "print") rule.media.mediaText = "all";
  document.body.style.width = `${width * MM}px`;
  document.body.style.margin = "0";
  document.querySelectorAll("details").forEach((d) => { d.open = true; });
  await Promise.all(plots.map((p) => draw(p, false)));
  await fillSheets();
}
// Bands become the lines that they are of where one zooms in, from samples in the page or the file beside it.
const samplesFile = document.getElementById("page").dataset.samples;
let loading;
const samples = () => (loading ??= samplesFile ? fromFile() : unpacked("samples-inside").then((json) => {
  window.samples = JSON.parse(json); return true;
}));
const fromFile = () => new Promise((done) => {
  const file = Object.assign(document.createElement("script"), { src: samplesFile, onload: () => done(true), onerror: () => done(false) });
  document.head.append(file);
});
function numbers(packed) {
  if (packed.values) return packed.values;
  const bytes = Uint8Array.from(atob(packed.bdata), (c) => c.charCodeAt(0)).buffer;
  return (packed.values = packed.dtype === "f8" ? new Float64Array(bytes) : new Float32Array(bytes));
}
const plain = (values) => (values.bdata ? numbers(values) : values);
function place(x, value) { // of the first that is not below a value
  let low = 0, high = x.length;
  while (low < high) { const middle = (low + high) >> 1; if (x[middle] < value) low = middle + 1; else high = middle; }
  return low;
}
async function refine(element, coarse) {
  if (!(await samples())) return;
  const of = window.samples.lines[element.id.slice(1) - 1] ?? {}, traces = [], xs = [], ys = [];
  for (const [trace, places] of Object.entries(of)) {
    const rows = places.map((k) => numbers(window.samples.arrays[k])), [x] = rows;
    const coarsely = unfolded(plain(coarse[trace].x), plain(coarse[trace].y)), [cx] = coarsely;
    const axis = element._fullLayout["xaxis" + coarse[trace].xaxis.slice(1)];
    const [low, high] = axis.range.map((v) => (axis.type === "log" ? 10 ** v : v)).sort((a, b) => a - b);
    const margin = 0.5 * (high - low); // drawn finely beyond the view, for a little panning
    const first = Math.max(0, place(x, low - margin) - 1), last = Math.min(x.length, place(x, high + margin) + 1);
    const fine = first < last && last - first < x.length;
    const [before, after] = fine ? [place(cx, x[first]), place(cx, x[last - 1])] : [cx.length, cx.length];
    const kept = fine ? band(rows, first, last) : [[], [], []];
    const drawn = outline(coarsely.map((column, k) => [...column.slice(0, before), ...kept[k], ...column.slice(after)]));
    traces.push(Number(trace)); xs.push(drawn.x); ys.push(drawn.y);
  }
  if (traces.length) await Plotly.restyle(element, { x: xs, y: ys }, traces);
}
const plots = [...document.querySelectorAll(".plot")];
const drawAgain = () => plots.filter((p) => p.dataset.drawn).forEach((p) => draw(p));
function showStills() { // in the place of figures that cannot be drawn
  document.getElementById("no-plotly").hidden = false;
  for (const plot of plots) { plot.innerHTML = document.getElementById(plot.id + "-still").textContent; plot.style.height = ""; }
}
async function start() {
  try {
    const library = await unpacked("plotly-inside");
    if (library) document.head.append(Object.assign(document.createElement("script"), { textContent: library }));
  } catch { /* a browser without DecompressionStream */ }
  if (typeof Plotly === "undefined") return showStills();
  if (location.hash === "#print") return layOut();
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) { watcher.unobserve(entry.target); draw(entry.target); }
  }, { rootMargin: "1200px" });
  plots.forEach((p) => watcher.observe(p));
  wantsDark.addEventListener("change", drawAgain);
}
if (plots.length) start();
// On paper figures are light, and everything is unfolded.
let folded = [];
window.addEventListener("beforeprint", () => {
  if (typeof Plotly !== "undefined") plots.forEach((p) => draw(p, false));
  folded = [...document.querySelectorAll("details:not([open])")];
  folded.forEach((d) => { d.open = true; });
});
window.addEventListener("afterprint", () => { drawAgain(); folded.forEach((d) => { d.open = false; }); });
