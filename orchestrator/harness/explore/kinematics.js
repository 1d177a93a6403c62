// The picture of a machine from formulas of a run's signals: what a report draws from numbers.
const OF_NUMBERS = {
  "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b, "/": (a, b) => a / b, abs: Math.abs, sin: Math.sin, cos: Math.cos,
  "not above": (x, limit) => (Number.isNaN(limit) || x < limit ? x : limit),
  "not below": (x, limit) => (Number.isNaN(limit) || x > limit ? x : limit),
  "known below": (x, limit) => (x < limit ? x : NaN),
};
const OF_ALL_INSTANTS = {
  largest: (x) => x.reduce((most, v) => (v > most ? v : most), -Infinity),
  smallest: (x) => x.reduce((least, v) => (v < least ? v : least), Infinity),
  last: (x) => x.at(-1),
};
// Numbers of the machine's steps at some instants, each step once: signal and parameter give what a name has there.
function evaluator(steps, signal, parameter) {
  const values = [];
  const value = (place) => (values[place] ??= computed(steps[place]));
  function computed(step) {
    if (typeof step === "number") return Float64Array.of(step);
    const [operation, ...of] = step;
    if (operation === "signal") return signal(of[0]);
    if (operation === "parameter") return Float64Array.of(parameter(of[0]));
    const parts = of.map(value);
    if (operation in OF_ALL_INSTANTS) return Float64Array.of(OF_ALL_INSTANTS[operation](parts[0]));
    const apply = OF_NUMBERS[operation], [a, b = a] = parts, answer = new Float64Array(Math.max(a.length, b.length));
    for (let k = 0; k < answer.length; k++) answer[k] = apply(a[a.length > 1 ? k : 0], b[b.length > 1 ? k : 0]);
    return answer;
  }
  return value;
}
function boxOf(lines, room) { // least and largest x, least and largest y, with room about them
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const { points } of lines) {
    for (let k = 0; k < points.length; k += 2) {
      if (!Number.isFinite(points[k]) || !Number.isFinite(points[k + 1])) continue;
      for (const axis of [0, 1]) { low[axis] = Math.min(low[axis], points[k + axis]); high[axis] = Math.max(high[axis], points[k + axis]); }
    }
  }
  const size = Math.max(high[0] - low[0], high[1] - low[1]) || 10;
  const about = [0, 1].map((axis) => room * Math.max(high[axis] - low[axis], 0.1 * size));
  return [low[0] - about[0], high[0] + about[0], low[1] - about[1], high[1] + about[1]];
}
// What `moving` shows of a run, with the caption's numbers; null where the run has not all signals. every: rows from one
// snapshot to the next.
function motionOf(machine, { columns, count, step, pictures }, parameter) {
  const inPictures = machine.snapshots.length > 0, every = inPictures ? pictures.every : 1;
  const needed = machine.steps.filter((s) => s[0] === "signal").map((s) => s[1]);
  const at = Float64Array.from({ length: Math.floor((count - 1) / every) + 1 }, (_, k) => k * every * step);
  if (!at.length || needed.some((name) => name !== "time" && !(name in columns) && !(inPictures && name in pictures.columns))) return null;
  const signals = (rows) => (name) => {
    if (name === "time") return rows.map((k) => at[k]);
    if (name in columns) return rows.map((k) => columns[name][k * every]);
    return rows.map((k) => pictures.columns[name][k]);
  };
  const all = Float64Array.from(at, (_, k) => k);
  const begin = machine.begin === null ? 0 : evaluator(machine.steps, signals(all), parameter)(machine.begin)[0];
  const first = Math.max(0, Math.min(at.length - 1, Math.ceil(begin / (every * step) - 1e-9))) || 0;
  const end = Math.min(at.at(-1), at[first] + (machine.longest ?? Infinity)), span = end - at[first];
  const shown = Math.max(machine.fewest, Math.min(machine.most, Math.floor(machine.a_second * span)));
  const rows = Float64Array.from(new Set(Array.from({ length: shown }, (_, k) =>
    Math.min(at.length - 1, Math.ceil((at[first] + (span * k) / (shown - 1)) / (every * step) - 1e-9)))));
  const value = evaluator(machine.steps, signals(rows), parameter);
  const lines = machine.lines.map(({ look, joints, points }) => {
    const parts = points.map(value), stands = parts.every((p) => p.length < 2), instants = stands ? 1 : rows.length;
    const flat = new Float32Array(instants * parts.length);
    parts.forEach((p, c) => { for (let k = 0; k < instants; k++) flat[k * parts.length + c] = p[p.length > 1 ? k : 0]; });
    return { look, joints, corners: parts.length / 2, points: flat };
  });
  return { time: rows.map((k) => at[k]), box: boxOf(lines, machine.room), equal: machine.equal, lines, numbers: machine.numbers.map((n) => value(n)[0]) };
}
