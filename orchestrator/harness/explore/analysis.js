// Figures of a run, as the page's data describes them. Filters come with their coefficients; see `figures.py` for the words.
"use strict";
function sections(x, filter) { // one pass, from rest at the first sample
  let y = x;
  filter.sections.forEach(([b0, b1, b2, , a1, a2], k) => {
    let z0 = filter.rest[k][0] * x[0], z1 = filter.rest[k][1] * x[0];
    const out = new Float64Array(y.length);
    for (let i = 0; i < y.length; i++) {
      const v = b0 * y[i] + z0;
      z0 = b1 * y[i] - a1 * v + z1;
      z1 = b2 * y[i] - a2 * v;
      out[i] = v;
    }
    y = out;
  });
  return y;
}
function filtered(x, filter) { // forward and backward, with both ends reflected
  const n = x.length, ends = Math.min(n - 1, filter.ends), long = new Float64Array(n + 2 * ends);
  for (let i = 0; i < ends; i++) {
    long[i] = 2 * x[0] - x[ends - i];
    long[ends + n + i] = 2 * x[n - 1] - x[n - 2 - i];
  }
  long.set(x, ends);
  return sections(sections(long, filter).reverse(), filter).reverse().slice(ends, ends + n);
}
function firstNotBelow(x, value) {
  let low = 0, high = x.length;
  while (low < high) { const middle = (low + high) >> 1; if (x[middle] < value) low = middle + 1; else high = middle; }
  return low;
}
// [first, last) of the rows that count; null where the run does not reach that far.
function rowsOf(figure, run) {
  const n = run.count, end = (n - 1) * run.step;
  if (figure.window) {
    const [name, from, to] = figure.window, x = run.columns[name], first = firstNotBelow(x, from), last = firstNotBelow(x, to);
    if (last - first < 2 || x[0] > from || x[n - 1] < to - 2 * (x[n - 1] - x[n - 2])) return null;
    return [first, last];
  }
  const first = Math.min(Math.ceil((figure.transient / run.step) * (1 - 1e-12)), n - 1);
  const last = Math.floor(((end - figure.edge) / run.step) * (1 + 1e-12)) + 1;
  return [first, Math.max(last, first + 1)];
}
function amplitude(x, rate, frequency) {
  const n = x.length, mean = x.reduce((s, v) => s + v, 0) / n;
  let re = 0, im = 0, sum = 0;
  for (let k = 0; k < n; k++) {
    const w = n > 1 ? Math.sin((Math.PI * k) / n) ** 2 : 1, turn = (-2 * Math.PI * frequency * k) / rate;
    re += (x[k] - mean) * w * Math.cos(turn); im += (x[k] - mean) * w * Math.sin(turn); sum += w;
  }
  return (2 * Math.hypot(re, im)) / sum;
}
function statistic(x, figure, rate) {
  const n = x.length;
  if (figure.kind === "end") return x[n - 1];
  if (figure.kind === "maximum") return x.reduce((a, b) => Math.max(a, b));
  if (figure.kind === "minimum") return x.reduce((a, b) => Math.min(a, b));
  if (figure.kind === "share not above zero") return (100 * x.reduce((s, v) => s + (v <= 0), 0)) / n;
  if (figure.kind === "amplitude") return amplitude(x, rate, figure.frequency);
  const mean = x.reduce((s, v) => s + v, 0) / n;
  if (figure.kind === "mean") return mean;
  const deviation = Math.sqrt(x.reduce((s, v) => s + (v - mean) ** 2, 0) / n);
  return figure.kind === "mean + 3 σ" ? mean + 3 * deviation : figure.kind === "mean - 3 σ" ? mean - 3 * deviation : deviation;
}
// run: {step, count, columns, filters}. Returns name -> number, NaN where it cannot be had, and the filtered signals.
function figuresOf(figures, run) {
  const numbers = {}, smooth = {};
  const signal = (name, { filter, cutoff }) => {
    if (!filter) return run.columns[name];
    return run.filters[filter] && (smooth[`${name} below ${cutoff} Hz`] ??= filtered(run.columns[name], run.filters[filter]));
  };
  for (const figure of figures) {
    const rows = run.whole ? rowsOf(figure, run) : null;
    const values = rows === null ? [NaN] : figure.signals.map((name) => {
      const x = signal(name, figure);
      return x ? figure.factor * statistic(x.subarray(...rows), figure, 1 / run.step) : NaN;
    });
    numbers[figure.name] = Math.max(...values);
  }
  return { numbers, smooth };
}
