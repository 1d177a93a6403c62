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
  const n = run.count, begin = run.begin ?? 0, reach = (n - 1) * run.step;
  if (figure.window) {
    const [name, from, to] = figure.window, x = run.columns[name], first = firstNotBelow(x, from), last = firstNotBelow(x, to);
    if (last - first < 2 || x[0] > from || x[n - 1] < to - 2 * (x[n - 1] - x[n - 2])) return null;
    return [first, last];
  }
  const first = Math.min(Math.max(Math.ceil(((figure.transient - begin) / run.step) * (1 - 1e-12)), 0), n - 1);
  const last = Math.floor(((reach - figure.edge) / run.step) * (1 + 1e-12)) + 1;
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
const meanOf = (x) => x.reduce((s, v) => s + v, 0) / x.length;
const momentOf = (x, mean, power) => x.reduce((s, v) => s + (v - mean) ** power, 0) / x.length;
const integralOf = (x, rate) => x.reduce((s, v, k) => (k ? s + 0.5 * (v + x[k - 1]) : 0), 0) / rate;
const largest = (x) => x.reduce((a, b) => Math.max(a, b));
const least = (x) => x.reduce((a, b) => Math.min(a, b));
const percent = (x, holds) => (100 * x.reduce((s, v) => s + holds(v), 0)) / x.length;
const STATISTICS = {
  end: (x) => x.at(-1),
  maximum: largest,
  minimum: least,
  mean: meanOf,
  "standard deviation": (x) => Math.sqrt(momentOf(x, meanOf(x), 2)),
  "mean + 3 σ": (x) => meanOf(x) + 3 * STATISTICS["standard deviation"](x),
  "mean - 3 σ": (x) => meanOf(x) - 3 * STATISTICS["standard deviation"](x),
  kurtosis: (x) => momentOf(x, meanOf(x), 4) / momentOf(x, meanOf(x), 2) ** 2,
  "peak to peak": (x) => largest(x) - least(x),
  "largest size": (x) => largest(x.map(Math.abs)),
  "largest drift": (x) => largest(x.map((v) => Math.abs(v - x[0]))) / (largest(x.map(Math.abs)) || 1),
  change: (x) => x.at(-1) - x[0],
  "rate of change": (x, rate) => ((x.at(-1) - x[0]) * rate) / (x.length - 1),
  integral: integralOf,
  amplitude: (x, rate, { frequency }) => amplitude(x, rate, frequency),
  "share not above zero": (x) => percent(x, (v) => v <= 0),
  "share of zeros": (x) => percent(x, (v) => Math.round(v) === 0),
  "share of time at 1": (x, rate) => (100 * rate * integralOf(x.map((v) => Number(v >= 1 - 1e-9)), rate)) / (x.length - 1),
  overshoot: (x, rate, { moves }) => Math.max(...moves.map(([, from, to, sign]) => Math.max(0, largest(rowsBetween(x, rate, from, to).map((v) => -sign * v))))),
  "settling time": (x, rate, { moves }) => { // NaN where one does not settle
    const times = moves.map(([begin, from, to, , band]) => {
      const part = rowsBetween(x, rate, from, to), after = part.findLastIndex((v) => Math.abs(v) > band);
      if (after < 0) return from - begin;
      if (after === part.length - 1) return NaN;
      const edge = part[after] > 0 ? band : -band; // between the last row outside and the first inside, on a straight line
      return Math.round(from * rate) / rate + (after + (part[after] - edge) / (part[after] - part[after + 1])) / rate - begin;
    });
    return Math.max(...times);
  },
  starts(x, rate, { limits: [standstill, pause] }) {
    const runs = [];
    for (let k = 0, first = -1; k <= x.length; k++) {
      const moves = k < x.length && x[k] > standstill;
      if (moves && first < 0) first = k;
      if (moves || first < 0) continue;
      if (runs.length && (first - runs.at(-1)[1]) / rate <= pause) runs.at(-1)[1] = k; else runs.push([first, k]);
      first = -1;
    }
    return runs.filter(([first, end]) => first > 0 && integralOf(x.subarray(first, end), rate) >= 2 * Math.PI).length;
  },
};
const rowsBetween = (x, rate, from, to) => x.subarray(Math.round(from * rate), Math.round(to * rate)); // without the last
const ROW_BY_ROW = {
  size: (columns) => columns[0].map((_, k) => Math.hypot(...columns.map((x) => x[k]))),
  product: (columns) => columns[0].map((_, k) => columns.reduce((p, x) => p * x[k], 1)),
  difference: ([a, b]) => a.map((v, k) => v - b[k]),
  "largest size": (columns) => columns[0].map((_, k) => Math.max(...columns.map((x) => Math.abs(x[k])))),
};
// Signals where an angle, possibly wrapped, passes multiples of the spacing; between samples a cubic over the angle.
function sectionOf(angle, spacing, columns) {
  const turned = Float64Array.from(angle), n = angle.length, points = columns.map(() => []);
  for (let k = 1; k < n; k++) turned[k] = turned[k - 1] + angle[k] - angle[k - 1] - 2 * Math.PI * Math.round((angle[k] - angle[k - 1]) / (2 * Math.PI));
  if (turned[n - 1] < turned[0]) turned.forEach((v, k) => { turned[k] = -v; });
  for (let k = 1, at = Math.ceil(turned[0] / spacing) * spacing; k < n && n > 3; k++) {
    for (; at <= turned[k]; at += spacing) {
      const first = Math.min(Math.max(k - 2, 0), n - 4), weights = [0, 1, 2, 3].map((i) => [0, 1, 2, 3].reduce((w, j) => (i === j ? w : (w * (at - turned[first + j])) / (turned[first + i] - turned[first + j])), 1));
      columns.forEach((x, c) => points[c].push(weights.reduce((s, w, i) => s + w * x[first + i], 0)));
    }
  }
  return points;
}
const SAME = 0.02; // of the range: points nearer to one another count as one
function groupsOf(points, reaches) { // linked by gaps of at most SAME
  const n = points[0].length, group = new Int32Array(n).fill(-1);
  let count = 0;
  for (let start = 0; start < n; start++) {
    if (group[start] >= 0) continue;
    const open = [start];
    group[start] = count;
    while (open.length) {
      const k = open.pop();
      for (let j = 0; j < n; j++) {
        if (group[j] < 0 && Math.hypot(...points.map((x, c) => (x[k] - x[j]) / reaches[c])) <= SAME) { group[j] = count; open.push(j); }
      }
    }
    count += 1;
  }
  return count;
}
function distinctPoints(columns) { // the last signal is the angle
  const angle = columns.at(-1), signals = columns.slice(0, -1), sizes = signals.map(STATISTICS["peak to peak"]), half = signals.length / 2;
  const reaches = sizes.map((_, c) => Math.max(...(c < half ? sizes.slice(0, half) : sizes.slice(half))) || 1);
  return (spacing) => groupsOf(sectionOf(angle, spacing, signals), reaches);
}
function statistic(columns, figure, rate) {
  if (figure.section) return distinctPoints(columns)(figure.section[1]);
  if (figure.kind === "at the largest") { // the last signal where the size of the others is largest
    const size = ROW_BY_ROW.size(columns.slice(0, -1));
    return columns.at(-1)[size.indexOf(largest(size))];
  }
  const combined = figure.combine ? [ROW_BY_ROW[figure.combine](columns)] : columns;
  return Math.max(...combined.map((x) => STATISTICS[figure.kind](x, rate, figure)));
}
// run: {step, count, begin, columns, filters, valueOf}, begin: time of the first row, 0 where it is not given. Returns name -> number, NaN where it cannot be had, and the filtered signals.
function figuresOf(figures, run) {
  const numbers = {}, smooth = {};
  const signal = (name, { filter, cutoff }) => {
    if (!filter) return run.columns[name];
    return run.filters[filter] && (smooth[`${name} below ${cutoff} Hz`] ??= filtered(run.columns[name], run.filters[filter]));
  };
  const valueOf = (figure) => {
    if (!run.whole) return NaN;
    const rows = rowsOf(figure, run), columns = [...figure.signals, ...(figure.section?.slice(0, 1) ?? [])].map((name) => signal(name, figure));
    if (rows === null || !columns.every(Boolean)) return NaN;
    const factor = figure.powers.reduce((f, [name, exponent]) => f * run.valueOf(name) ** exponent, figure.factor);
    const number = factor * statistic(columns.map((x) => x.subarray(...rows)), figure, 1 / run.step);
    if (!figure.over) return number;
    const over = valueOf(figure.over);
    return over > 0 ? number / over : NaN;
  };
  for (const figure of figures) numbers[figure.name] = valueOf(figure);
  return { numbers, smooth };
}
