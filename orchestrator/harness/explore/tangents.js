// Derivatives of a run by a parameter: of its signals by a module with tangents, of its figures along those of the signals.
"use strict";
const withTangents = [];
function tangentsOf(variant) { // the module of a variant, started once
  return (withTangents[variant] ??= (() => {
    const x = new WebAssembly.Instance(new WebAssembly.Module(tangentModules[variant]), {}).exports;
    x._initialize();
    return x;
  })());
}

// The signals of a run, and their derivatives by a parameter; null where there is a newer wish, no columns where it fails.
async function tangentRun(job, name, length, exact, newer) {
  const of = instanceOf(job.variant), x = tangentsOf(job.variant), n = of.names.length, count = Math.round(data.stop / length);
  const unit = made(of, job, length, exact), size = 8 * x.slope_size(), block = x.slope_block();
  const wanted = x.malloc(4 * n || 4), values = x.malloc(8 * n * (count + 1)), tangents = x.malloc(8 * n * (count + 1)), places = [wanted, values, tangents];
  const room = unit && block && places.every(Boolean);
  if (room) new Uint8Array(x.memory.buffer, block, size).set(new Uint8Array(of.x.memory.buffer, of.x.live_block(unit), size));
  if (unit) of.x.fmi3FreeInstance(unit);
  if (room) new Uint32Array(x.memory.buffer, wanted, n).set(of.names.map((signal) => of.x.live_cell(data.variants[job.variant].outputs[signal])));
  x.slope_macro_step(length, exact[0], exact[1]);
  const starts = room && !x.slope_start(of.x.live_cell(of.parameters[name]), 0);
  const take = (done, steps) => { // the first piece has the row of the start, too
    const at = 8 * n * (done && done + 1);
    return x.slope_run(steps, Number(!done), wanted, n, values + at, tangents + at);
  };
  const { done, gone } = await inPieces(starts ? count : 0, BEHIND, newer, take);
  const whole = starts && done === count, kept = whole ? count + 1 : 0;
  const result = { failed: !whole, columns: columnsOf(x, values, of.names, kept), tangents: columnsOf(x, tangents, of.names, kept), tied: x.slope_at_tie() !== 0 };
  places.forEach((place) => x.free(place));
  return gone ? null : result;
}

const SAME_RUN = 1e-6; // of a signal's largest number, by which the run with tangents may differ
const largestSize = (x) => x.reduce((m, v) => Math.max(m, Math.abs(v)), 0);
const other = (x, y) => { const least = SAME_RUN * largestSize(x); return x.some((v, k) => Math.abs(v - y[k]) > least + SAME_RUN * Math.abs(v)); };
// Length of differences in the space of signals, as `length` of derivatives/along.py; 0 where tangents are not finite.
function lengthAlong(columns, tangents, at) {
  const sizes = Object.entries(columns).map(([name, x]) => [largestSize(tangents[name]), largestSize(x)]);
  const fastest = Math.max(0, ...sizes.filter(([, size]) => size > 0).map(([tangent, size]) => tangent / size));
  return Number.isFinite(fastest) ? data.slope.along / Math.max(fastest, 1 / Math.max(Math.abs(at), 1)) : 0;
}

// Derivatives of the figures of a run along tangents of its signals, by a parameter that is `at`: name -> {derivative, error, smooth},
// smooth: whether both sides agree; as `_along` of derivatives/gradient.py.
function figuresAlong(run, tangents, name, at) {
  const step = lengthAlong(run.columns, tangents, at);
  const displaced = (way) => figuresOf(data.figures, { ...run, valueOf: (n) => run.valueOf(n) + (n === name ? way : 0),
    columns: Object.fromEntries(Object.entries(run.columns).map(([signal, x]) => [signal, x.map((v, k) => v + way * tangents[signal][k])])) }).numbers;
  const along = (by) => { const [ahead, back] = [by, -by].map(displaced); return (f) => [(ahead[f] - back[f]) / (2 * by), (ahead[f] - 2 * run.numbers[f] + back[f]) / by]; };
  const whole = step ? along(step) : () => [NaN], half = step ? along(0.5 * step) : () => [NaN, NaN];
  return Object.fromEntries(data.figures.map(({ name: f }) => {
    const [derivative, bend] = half(f), rounding = (1e-13 * Math.abs(run.numbers[f])) / step;
    return [f, { derivative, error: Math.abs(whole(f)[0] - derivative) + rounding, smooth: Math.abs(bend) <= data.slope.agree * Math.abs(derivative) + 10 * rounding }];
  }));
}

// What runs below and above give, name -> [[difference, what it does not resolve], the same above]; NaN where a side cannot run.
async function besideOf(job, base, at, length, exact, newer) {
  const step = data.slope.beside * (Math.abs(at) || 1), sides = Object.fromEntries(data.figures.map((f) => [f.name, []]));
  for (const way of [-step, step]) {
    const numbers = [];
    for (const share of [1, 0.5]) {
      const values = { ...job.values, [job.slope]: at + share * way }, one = await run({ ...job, values }, length, exact, newer);
      if (!one) return null;
      numbers.push(figuresOf(data.figures, { ...one, filters: base.filters, valueOf: valuesOf({ values }) }).numbers);
    }
    for (const { name: f } of data.figures) {
      const [whole, near] = [1, 0.5].map((share, k) => (numbers[k][f] - base.numbers[f]) / (share * way));
      sides[f].push([2 * near - whole, Math.abs(near - whole) + (1e-11 * Math.abs(base.numbers[f])) / step]);
    }
  }
  return sides;
}
// Whether a derivative is what runs below, above say, as `_fits` of derivatives/gradient.py.
const fits = (derivative, sides, at, value) => sides.map(([difference, unsure]) => {
  const size = Math.max(Math.abs(derivative), Math.abs(difference)), { said, counts, agree } = data.slope;
  const silent = unsure > said * size && unsure * (Math.abs(at) || 1) > counts * Math.abs(value);
  return !silent && Math.abs(derivative - difference) <= agree * size + 2 * unsure;
});
// Which of the derivatives at a boundary, and close below and above, holds, and for which side: [place, how, reason], as `_verdict` there.
function verdict(derivatives, sides, at, value) {
  const fit = derivatives.map((derivative) => fits(derivative, sides, at, value)), both = ([below, above]) => below && above;
  if (both(fit[0])) return [0, "", ""];
  if (fit.length > 1 && both(fit[2])) return [2, "", ""];
  for (const [which, side, how] of [[0, 1, "above"], [0, 0, "below"], [2, 1, "above"], [1, 0, "below"]]) if (fit[which]?.[side]) return [which, how, ""];
  const [[below], [above]] = sides;
  return [0, "", Number.isNaN(below) && Number.isNaN(above) ? "no other value comes to its end in this scene"
    : `a decision stands at its boundary; runs give ${below.toPrecision(4)} below and ${above.toPrecision(4)} above`];
}

// Derivatives of signals and figures by the parameter `job.slope` at a run: {name, at, tangents, smooth, figures: name -> {derivative,
// how, why}}, how: "", "below" or "above" where one side has it, why: "" or the reason for which there is none, as `slopes_of` of
// derivatives/gradient.py. Null where there is a newer wish.
async function slopeOf(job, run, length, exact, newer) {
  const name = job.slope, at = valuesOf(job)(name), answer = { name, at, tangents: {}, smooth: {}, figures: {} };
  const none = (why) => ({ ...answer, figures: Object.fromEntries(data.figures.map((f) => [f.name, { derivative: NaN, how: "", why }])) });
  if (data.slope.refused[name]) return none(data.slope.refused[name]);
  const same = (columns) => !Object.keys(run.columns).some((signal) => other(run.columns[signal], columns[signal]));
  const follower = await tangentRun(job, name, length, exact, newer);
  if (!follower) return null;
  if (follower.failed) return none("the run with derivatives has failed");
  if (!same(follower.columns)) return none("the run with derivatives is another one");
  const ways = [figuresAlong(run, follower.tangents, name, at)], sides = follower.tied ? await besideOf(job, run, at, length, exact, newer) : {};
  if (!sides) return null;
  if (follower.tied && data.figures.some(({ name: f }) => !fits(ways[0][f].derivative, sides[f], at, run.numbers[f]).some(Boolean))) {
    for (const way of [-data.slope.close, data.slope.close]) {
      const values = { ...job.values, [name]: at + way * (Math.abs(at) || 1) }, beside = await tangentRun({ ...job, values }, name, length, exact, newer);
      if (!beside) return null;
      const known = !beside.failed && same(beside.columns);
      ways.push(known ? figuresAlong(run, beside.tangents, name, at) : Object.fromEntries(data.figures.map((f) => [f.name, { derivative: NaN }])));
    }
  }
  const figures = Object.fromEntries(data.figures.map(({ name: f }) => {
    let [which, how, why] = [0, "", ways[0][f].smooth ? "" : "the figure itself jumps or bends there"];
    if (follower.tied) [which, how, why] = verdict(ways.map((way) => way[f].derivative), sides[f], at, run.numbers[f]);
    const { derivative } = ways[which][f];
    if (!Number.isFinite(derivative)) why = "infinite, or not a number";
    return [f, { derivative: why ? NaN : derivative, how, why }];
  }));
  return { ...answer, tangents: follower.tangents, smooth: figuresOf(data.figures, { ...run, columns: follower.tangents }).smooth, figures };
}
