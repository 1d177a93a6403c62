// Computes runs: the latest wish wins, between pieces of a run the worker looks whether there is a newer one.
const PIECE = 20, BEHIND = 5; // ms of a run that a wish waits for, and of one behind it, between two looks for a newer wish
const GROWN = 3; // times the deviation of a signal with the shortest step: the coupling adds energy that is not there
let data, modules, tangentModules, wish = null, busy = false;
const instances = [];
const channel = new MessageChannel();
let resume = null;
channel.port1.onmessage = () => resume();
const breathe = () => new Promise((done) => { resume = done; channel.port2.postMessage(0); });

onmessage = ({ data: message }) => {
  if (message.modules) { ({ data, modules } = message); return; }
  if (message.tangents) { tangentModules = message.tangents; return; }
  wish = message;
  if (!busy) serve();
};

function instanceOf(variant) { // the module of a variant, started once
  return (instances[variant] ??= (() => {
    const said = [];
    const text = (at) => {
      const bytes = new Uint8Array(x.memory.buffer, at);
      return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
    };
    const log = (environment, status, category, message) => said.push(text(message));
    const x = new WebAssembly.Instance(new WebAssembly.Module(modules[variant]), { host: { log } }).exports;
    x._initialize();
    const put = (array) => {
      const at = x.malloc(array.byteLength || 8);
      new Uint8Array(x.memory.buffer, at).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
      return at;
    };
    const { outputs, token } = data.variants[variant], names = data.signals.map((s) => s.name).filter((name) => name in outputs);
    const bytes = (string) => put(new TextEncoder().encode(string + "\0"));
    const changes = Object.fromEntries(Object.entries(data.variants[variant].extrapolations).map(([degree, cells]) => [degree, {
      count: cells.length, cells: put(Uint32Array.from(cells, ([cell]) => cell)), values: put(Uint32Array.from(cells.flatMap(([, low, high]) => [low, high]))),
    }]));
    const elements = data.snapshots.filter((name) => name in outputs);
    return {
      changes, elements, seen: put(Uint32Array.from(elements, (name) => outputs[name])),
      x, said, put, names, token: bytes(token), unit: bytes("page"),
      outputs: put(Uint32Array.from(names, (name) => outputs[name])), parameters: data.variants[variant].parameters,
    };
  })());
}

// Of arrays that pictures show, in a run of so many steps: rows at every so many of them.
function picturesOf({ x, elements, seen }, count, wanted) {
  const machine = wanted && elements.length && data.machines.find((m) => m.snapshots.length), n = elements.length;
  const number = machine ? Math.max(machine.fewest, Math.min(machine.most, machine.a_second * data.stop)) : 1;
  const every = Math.max(1, Math.floor(count / number)), rows = machine ? x.malloc(8 * n * (Math.floor(count / every) + 1)) : 0;
  x.live_pictures(rows ? n : 0, seen, every, rows);
  const columns = (kept) => { // of a run that kept so many rows of its steps
    if (!rows) return {};
    const taken = Math.floor((kept - 1) / every) + 1, table = new Float64Array(x.memory.buffer, rows, n * taken);
    return Object.fromEntries(elements.map((name, c) => [name, Float64Array.from({ length: taken }, (_, k) => table[k * n + c])]));
  };
  return { every, rows, columns };
}

// An instance before initialization, with its parameters set; 0 where it refuses them. exact: the macro step as whole numbers.
function made(of, { values, extrapolation }, length, exact) {
  const { x, said, put } = of, { count: cells, cells: at, values: to } = of.changes[extrapolation];
  said.length = 0;
  x.live_macro_step(length, exact[0], exact[1]);
  x.live_cells(cells, at, to);
  const unit = x.fmi3InstantiateCoSimulation(of.unit, of.token, 0, 0, 0, 0, 0, 0, 0, 0, x.host_logger(), 0);
  const names = Object.keys(values).filter((name) => name in of.parameters);
  const references = put(Uint32Array.from(names, (name) => of.parameters[name]));
  const numbers = put(Float64Array.from(names, (name) => values[name]));
  const taken = unit && x.fmi3SetFloat64(unit, references, names.length, numbers, names.length) <= 1;
  [references, numbers].forEach((place) => x.free(place));
  if (unit && !taken) x.fmi3FreeInstance(unit);
  return taken ? unit : 0;
}
// Steps in pieces, until one fails or there is a newer wish. take: so many steps behind those done; returns how many were taken.
async function inPieces(count, most, newer, take, progress) {
  let done = 0, piece = 50, spent = 0, gone = false;
  while (done < count) {
    const from = performance.now(), wanted = Math.min(piece, count - done), taken = take(done, wanted), took = performance.now() - from;
    done += taken; spent += took;
    if (taken < wanted) break;
    piece = Math.max(1, Math.min(4 * piece, Math.round((piece * most) / Math.max(took, 0.1))));
    if (done < count) {
      await breathe();
      if ((gone = newer())) break;
      progress?.(done);
    }
  }
  return { done, spent, gone };
}
function columnsOf(x, rows, names, kept) { // of a table in the memory of a module, until it is freed
  const columns = {}, n = names.length, table = new Float64Array(x.memory.buffer, rows, n * kept);
  names.forEach((name, c) => {
    const column = (columns[name] = new Float64Array(kept));
    for (let k = 0, at = c; k < kept; k++, at += n) column[k] = table[at];
  });
  return columns;
}

// A run of whole steps. `newer` says whether to give up; returns null then.
async function run(job, length, exact, newer, progress) {
  const of = instanceOf(job.variant), { x, said } = of, n = of.names.length, count = Math.round(data.stop / length);
  const began = performance.now(), unit = made(of, job, length, exact);
  const rows = x.malloc(8 * n * (count + 1)), pictures = picturesOf(of, count, progress);
  const starts = unit && rows && x.fmi3EnterInitializationMode(unit, 0, 0, 0, 0, 0) <= 1 && x.fmi3ExitInitializationMode(unit) <= 1;
  const started = performance.now() - began, take = (done, wanted) => x.live_run(unit, done * length, wanted, of.outputs, n, rows + 8 * n * done);
  const { done, spent, gone } = await inPieces(starts ? count : 0, progress ? PIECE : BEHIND, newer, take, progress && ((steps) => progress(steps * length)));
  const kept = gone || !starts || !done ? 0 : done + 1, columns = columnsOf(x, rows, of.names, kept);
  const taken = { every: pictures.every, columns: kept ? pictures.columns(kept) : {} };
  [rows, pictures.rows].forEach((at) => x.free(at));
  if (unit) x.fmi3FreeInstance(unit);
  if (gone || !rows) return null;
  const whole = kept === count + 1;
  return { step: length, count: kept, columns, pictures: taken, whole, spent: started + spent, memory: x.memory.buffer.byteLength, said: whole ? "" : said.at(-1) ?? "the run ended early" };
}

function everySecond(run, from) { // rows from, from + 2, from + 4 ... of a whole run
  const columns = {};
  for (const [name, x] of Object.entries(run.columns)) columns[name] = x.filter((_, k) => k >= from && (k - from) % 2 === 0);
  return { ...run, step: 2 * run.step, begin: from * run.step, count: Math.ceil((run.count - from) / 2), columns };
}
// Of two runs in one signal, as `differences` of judgement/comparison.py has it: y is the finer one.
const isWhole = (x) => x.every((v) => v === Math.round(v));
const turns = (x) => largest(x) - least(x) < 2 * Math.PI + 1e-6 && x.some((v, k) => k > 0 && Math.abs(v - x[k - 1]) > Math.PI);
function scaleOf(x, nominal) {
  const size = Math.sqrt(x.reduce((s, v) => s + v * v, 0) / x.length);
  return Math.max(spread(x), data.error.hardly * size, data.error.nothing * nominal);
}
function deviation(x, y, { unit, nominal, counts }) {
  const n = x.length, anew = unit === "rad" && (turns(x) || turns(y)), whole = 2 * Math.PI;
  if (counts || (unit === "1" && isWhole(x) && isWhole(y))) return x.reduce((s, v, k) => s + Number(v !== y[k]), 0) / n;
  let square = 0;
  for (let k = 0; k < n; k++) {
    let gap = Math.abs(x[k] - y[k]);
    if (anew) gap = Math.abs(((gap + Math.PI) % whole) - Math.PI);
    square += gap ** 2;
  }
  return square > 0 ? Math.sqrt(square / n) / (scaleOf(y, nominal) || scaleOf(x, nominal)) : 0;
}
const spread = (x) => { const mean = x.reduce((s, v) => s + v, 0) / x.length; return Math.sqrt(x.reduce((s, v) => s + (v - mean) ** 2, 0) / x.length); };

// The largest difference of figures over their size: a number, or the deviation of its signal where that is larger. With its figure.
function apart(numbers, others, run) {
  let largest = { share: 0, figure: "" };
  for (const f of data.figures) {
    const size = Math.max(Math.abs(numbers[f.name]), ...(f.of_the_signal ? f.signals.map((name) => Math.abs(f.factor) * spread(run.columns[name] ?? [0])) : []));
    const share = size > 0 ? Math.abs(numbers[f.name] - others[f.name]) / size : 0;
    if (share > largest.share) largest = { share, figure: f.name };
  }
  return largest;
}

async function serve() {
  busy = true;
  while (wish) {
    const job = wish;
    wish = null;
    try { await answer(job, () => wish !== null); } catch (error) { postMessage({ id: job.id, kind: "error", text: String(error) }); }
  }
  busy = false;
}
const shorter = (job, parts) => ({ ...job, values: { ...job.values, ...Object.fromEntries(Object.entries(data.usual).filter(([name]) => data.refined.includes(name))
  .map(([name, value]) => [name, (job.values[name] ?? value) / parts])) } }); // internal steps, too
// What lies between rows: how far the figures of every second row are from those of all, as `_gaps` of judgement/verification.py.
// Where that matters, with the ends of the run, from which changes and integrals count.
function gapsOf(run, numbers, from, numbersOf) {
  if (!run.whole) return {};
  const rows = everySecond(run, from), some = numbersOf(rows), gaps = {};
  const gap = ({ name }) => (Number.isFinite(some[name] - numbers[name]) ? Math.abs(some[name] - numbers[name]) : 0);
  const matters = data.figures.some((f) => gap(f) > data.error.no_matter * Math.abs(numbers[f.name]));
  for (const f of data.figures) gaps[f.name] = matters && ["end", "change", "rate of change"].includes(f.kind) && !f.edge ? 0 : gap(f);
  return gaps;
}
const judged = ({ variant }) => [...new Set(data.figures.flatMap((f) => [...f.signals, ...(f.over?.signals ?? [])]))].filter((n) => n in data.variants[variant].outputs);
const valuesOf = ({ values }) => (name) => values[name] ?? data.usual[name];

async function answer(job, newer) {
  const { length, exact, half, quarter, filters, coarse } = data.steps[job.step];
  const began = performance.now();
  const first = await run(job, length, exact, newer, (time) => postMessage({ id: job.id, kind: "progress", time }));
  if (!first) return;
  if (!first.count) return void postMessage({ id: job.id, kind: "refused", text: first.said });
  const { numbers, smooth } = figuresOf(data.figures, { ...first, filters, valueOf: valuesOf(job) });
  postMessage({ id: job.id, kind: "run", ...first, numbers, smooth, took: performance.now() - began });
  if (job.quick) return;
  await breathe();
  if (newer() || !first.whole) return first.whole ? undefined : ladder(job, newer);
  if (job.slope) {
    const slope = await slopeOf(job, { ...first, numbers, filters, valueOf: valuesOf(job) }, length, exact, newer);
    if (!slope) return;
    postMessage({ id: job.id, kind: "slope", ...slope });
  }
  const second = await run(shorter(job, 2), 0.5 * length, half, newer);
  if (!second) return;
  const valueOf = valuesOf(job), numbersOf = (rows, by) => figuresOf(data.figures, { ...rows, filters: by, valueOf }).numbers;
  const same = everySecond(second, 0), others = numbersOf(same, filters);
  const worst = second.whole ? Math.max(0, ...data.signals.filter(({ name }) => name in first.columns).map((signal) => deviation(first.columns[signal.name], same.columns[signal.name], signal))) : Infinity;
  const third = second.whole && worst > data.error.limit ? await run(shorter(job, 4), 0.25 * length, quarter, newer) : { whole: false };
  if (!third) return;
  const finest = third.whole ? numbersOf(everySecond(everySecond(third, 0), 0), filters) : null, factor = worst > data.error.limit ? data.error.unsure : data.error.sure;
  const gaps = [[first, numbers, 0, coarse], [first, numbers, 1, coarse], [second, others, 1, filters]].map(([whole, of, from, by]) => gapsOf(whole, of, from, (rows) => numbersOf(rows, by)));
  const errors = Object.fromEntries(Object.entries(numbers).map(([name, value]) => {
    const apart = Math.abs(value - others[name]), steps = finest ? apart + 2 * Math.abs(others[name] - finest[name]) : factor * apart;
    return [name, steps + Math.max(0, ...gaps.map((gap) => gap[name]))];
  }));
  const { share, figure } = apart(numbers, others, first);
  postMessage({ id: job.id, kind: "errors", errors, worst: factor * share, figure, said: second.said });
  await breathe();
  if (newer()) return;
  await ladder(job, newer);
  if (!newer()) await influences(job, newer);
  if (!newer()) await scan(job, newer, first.spent);
}

// The same state with a parameter changed: the figures, and of a section its points.
async function varied(job, name, value, newer) {
  const { length, exact, filters } = data.steps[job.step], values = { ...job.values, [name]: value };
  const one = await run({ ...job, values }, length, exact, newer);
  if (!one) return null;
  const section = data.figures.find((f) => f.section), angle = one.columns[section?.section[0]], rows = angle && one.whole && rowsOf(section, one);
  const points = rows ? sectionOf(angle.subarray(...rows), section.section[1], [one.columns[section.signals[0]].subarray(...rows)])[0] : [];
  await breathe();
  return newer() ? null : { name, value, spent: one.spent, rows: one.count, numbers: figuresOf(data.figures, { ...one, filters, valueOf: valuesOf({ values }) }).numbers, points };
}
const PART = 0.1; // of a slider's range, by which a parameter is moved to see what follows
async function influences(job, newer) {
  for (const { name, from, to } of data.sliders) {
    if (!(name in data.variants[job.variant].parameters)) continue;
    const here = valuesOf(job)(name), by = (here + PART * (to - from) > to ? -PART : PART) * (to - from);
    const answered = await varied(job, name, here + by, newer);
    if (!answered) return;
    postMessage({ id: job.id, kind: "influence", ...answered, by });
  }
}
const SCANNED = 41, BUDGET = 8000; // points over a parameter; ms that they may take
async function scan(job, newer, spent) {
  const slider = data.sliders.find((s) => s.name === job.over && s.name in data.variants[job.variant].parameters);
  if (!slider) return;
  const count = Math.round(Math.min(SCANNED, Math.max(9, BUDGET / spent)));
  for (let k = 0; k < count; k++) {
    const answered = await varied(job, slider.name, slider.from + ((slider.to - slider.from) * k) / (count - 1), newer);
    if (!answered) return;
    postMessage({ id: job.id, kind: "scan", place: k, count, ...answered });
  }
}

// The same state with every macro step that the page offers, the shortest first, which is the reference of the others.
async function ladder(job, newer) {
  let reference = null, size = {}, best = null;
  for (let k = 0; k < data.steps.length; k++) {
    const { length, exact, filters } = data.steps[k];
    const one = await run(job, length, exact, newer);
    if (!one) return;
    const names = judged(job), { numbers } = figuresOf(data.figures, { ...one, filters, valueOf: valuesOf(job) });
    if (!reference && one.whole) {
      reference = one;
      best = numbers;
      size = Object.fromEntries(names.map((name) => [name, spread(one.columns[name])]));
    }
    let error = NaN, stable = one.whole;
    if (one.whole && reference) {
      error = apart(best, numbers, reference).share;
      stable = names.every((name) => spread(one.columns[name]) <= GROWN * size[name] || size[name] === 0);
    }
    postMessage({ id: job.id, kind: "ladder", place: k, length, error: one === reference ? NaN : error, stable, said: one.said, spent: one.spent });
    await breathe();
    if (newer()) return;
  }
}
