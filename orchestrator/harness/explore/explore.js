// The page: settings on the left, their answer on the right; the worker computes.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const parameters = Object.fromEntries(data.parameters.map((p) => [p.name, p]));
const usualStep = data.steps.findIndex((s) => s.length === data.step);
const usual = { algorithm: data.algorithms[0], extrapolation: data.extrapolation };
const initial = () => ({ values: {}, off: [], step: usualStep, ...usual });
let state = initial(), pinned = null, shown = null, ladder = [], question = 0, problem = "";
const element = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};
const unitText = (unit) => (unit === "1" ? "" : ` ${unit}`);

// ---- the state as an address, a command, a scene ----
const text = (value) => String(value);
function address({ values, off, step, ...master }) {
  const parts = Object.entries(values).map(([name, value]) => `${name}=${text(value)}`);
  off.forEach((name) => parts.push(`off=${name}`));
  if (step !== usualStep) parts.push(`step=${data.steps[step].length}`);
  for (const [key, value] of Object.entries(usual)) if (master[key] !== value) parts.push(`${key}=${master[key]}`);
  return parts.join("&");
}
function stateOf(hash) { // what is not known is left out, with a sentence
  const next = initial(), unknown = [];
  for (const part of decodeURIComponent(hash.replace(/^#/, "")).split("&").filter(Boolean)) {
    const [name, value] = part.split("="), number = Number(value);
    if (name === "off" && data.effects.some((e) => e.name === value)) next.off.push(value);
    else if (name === "step" && data.steps.some((s) => s.length === number)) next.step = data.steps.findIndex((s) => s.length === number);
    else if (name === "algorithm" && data.algorithms.includes(value)) next.algorithm = value;
    else if (name === "extrapolation" && value in data.variants[0].extrapolations) next.extrapolation = number;
    else if (name in parameters && value !== "" && !refusal(parameters[name], value)) next.values[name] = number;
    else if (part !== "results") unknown.push(part);
  }
  problem = unknown.length ? `Left out of the address, which this page does not know: ${unknown.join(", ")}.` : "";
  return next;
}
const place = (name) => { const dot = name.indexOf("."); return [name.slice(0, dot), name.slice(dot + 1)]; };
function unitOf(name) { // a unit of a subsystem has dots in its name
  const units = Object.keys(data.settings.units).filter((unit) => name.startsWith(`${unit}.`));
  const unit = units.sort((a, b) => b.length - a.length)[0];
  return unit === undefined ? place(name) : [unit, name.slice(unit.length + 1)];
}
function changesOf({ values, off, step, ...master }) { // as `with_changes` takes them
  const changes = {};
  for (const [name, value] of Object.entries(values)) {
    const [unit, parameter] = unitOf(name);
    changes[`units.${unit}.parameters.${parameter}`] = value;
  }
  for (const name of off) {
    const [unit] = unitOf(name);
    const without = off.filter((n) => unitOf(n)[0] === unit).map((n) => unitOf(n)[1]);
    changes[`units.${unit}.effects`] = data.settings.units[unit].effects.filter((e) => !without.includes(e));
  }
  if (step !== usualStep) changes["master.step"] = data.steps[step].length;
  for (const [key, value] of Object.entries(usual)) if (master[key] !== value) changes[`master.${key}`] = master[key];
  return changes;
}
function settingsOf({ values, off, step, algorithm, extrapolation }) {
  const settings = structuredClone(data.settings);
  for (const name of off) {
    const [unit, effect] = unitOf(name), of = settings.units[unit];
    of.effects = of.effects.filter((e) => e !== effect);
    of.parameters = Object.fromEntries(Object.entries(of.parameters ?? {}).filter(([n]) => !n.startsWith(`${effect}.`)));
  }
  for (const [name, value] of Object.entries(values)) {
    const [unit, parameter] = unitOf(name);
    if (available(name)) (settings.units[unit].parameters ??= {})[parameter] = value;
  }
  Object.assign(settings.master, { step: data.steps[step].length, algorithm, extrapolation });
  return settings;
}
function elsewhere() {
  const { values, off, step, algorithm, extrapolation } = state, numbers = Object.entries(values).filter(([name]) => available(name));
  const sets = numbers.map(([name, value]) => ` --set ${name}=${text(value)}`);
  if (step !== usualStep) sets.push(` --step ${data.steps[step].length}`);
  if (algorithm !== usual.algorithm) sets.push(` --algorithm ${algorithm}`);
  if (extrapolation !== usual.extrapolation) sets.push(` --extrapolation ${extrapolation}`);
  byId("command").value = off.length ? "cosimo run scene.toml  # the scene below: effects are off" : `cosimo run ${data.name}${sets.join("")}`;
  const changes = JSON.stringify(changesOf({ ...state, values: Object.fromEntries(numbers) }), null, 4);
  const changed = address(state) !== address(initial());
  byId("python").value = `import cosimo\n\nscene = cosimo.load_scene(${JSON.stringify(data.name)})${changed ? `.with_changes(${changes})` : ""}\nresult = cosimo.run(scene)\nprint(result.summary)`;
  byId("toml").value = toml(settingsOf(state));
}

// ---- settings ----
const variantOf = ({ off, algorithm }) => data.variants.findIndex((v) => v.algorithm === algorithm
  && Object.entries(v.effects).every(([name, on]) => on !== off.includes(name)));
const available = (name) => name in data.variants[variantOf(state)].parameters;
function refusal(p, value) { // why a text is no value of a parameter; "" for one that is
  const number = Number(value);
  const range = p.low === null && p.high === null ? "" : p.high === null ? `, at least ${digits(p.low, 6)}`
    : p.low === null ? `, at most ${digits(p.high, 6)}` : ` from ${digits(p.low, 6)} to ${digits(p.high, 6)}`;
  const fits = String(value).trim() !== "" && Number.isFinite(number) && (p.low === null || number >= p.low) && (p.high === null || number <= p.high);
  return fits ? "" : `${JSON.stringify(String(value))}: expected a number${range}${unitText(p.unit)}`;
}
function knob(p) {
  const id = `p-${p.name}`, box = element("div", { className: "knob" });
  const label = element("label", { htmlFor: id }, `${p.text} `, element("small", {}, `${p.name}${p.unit === "1" ? "" : `, ${p.unit}`}`));
  const slider = element("input", { type: "range", min: p.from, max: p.to, step: "any", value: p.value });
  slider.setAttribute("aria-label", `${p.text}, slider${unitText(p.unit)}`);
  const field = element("input", { type: "text", inputMode: "decimal", id, value: text(p.value), autocomplete: "off" });
  const wrong = element("div", { className: "wrong", id: `${id}-wrong`, hidden: true });
  field.setAttribute("aria-describedby", wrong.id);
  const take = (value, settled) => {
    const why = refusal(p, value);
    field.setAttribute("aria-invalid", String(Boolean(why)));
    wrong.hidden = !why;
    wrong.textContent = why;
    if (why) return;
    const values = { ...state.values, [p.name]: Number(value) };
    if (Number(value) === p.value) delete values[p.name];
    change({ ...state, values }, settled, field);
  };
  const rounded = () => Number(Number(slider.value).toPrecision(4));
  slider.addEventListener("input", () => { field.value = text(rounded()); take(rounded(), false); });
  slider.addEventListener("change", () => take(rounded(), true));
  slider.addEventListener("keydown", (event) => { // 1 % of the range a key, 10 % a page
    const width = p.to - p.from;
    const by = { ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01, PageDown: -0.1, PageUp: 0.1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    slider.value = Number(slider.value) + by * width; // kept within its ends
    slider.dispatchEvent(new Event("input"));
    slider.dispatchEvent(new Event("change"));
  });
  field.addEventListener("input", () => take(field.value, false));
  field.addEventListener("change", () => take(field.value, true));
  box.append(label, slider, field, wrong);
  p.show = (keep) => {
    const value = state.values[p.name] ?? p.value, there = available(p.name);
    box.classList.toggle("changed", p.name in state.values);
    slider.min = Math.min(p.from, value); // a field takes more than the usual range
    slider.max = Math.max(p.to, value);
    slider.value = value;
    if (keep !== field) { field.value = text(value); field.setAttribute("aria-invalid", "false"); wrong.hidden = true; }
    slider.disabled = field.disabled = !there;
  };
  return box;
}
function choice(key, values, shownAs) { // of a setting of the master: nothing to choose, nothing shown
  const select = byId(key);
  select.parentElement.hidden = values.length < 2;
  values.forEach((value) => select.append(element("option", { value }, `${shownAs(value)}${value === usual[key] ? ", as the scene" : ""}`)));
  select.addEventListener("change", () => change({ ...state, [key]: values[select.selectedIndex] }, true));
}
function build() {
  const first = new Set(data.first);
  byId("first").append(...data.first.map((name) => knob(parameters[name])));
  const others = data.parameters.filter((p) => !first.has(p.name));
  byId("further").append(...others.map(knob));
  byId("others").hidden = !others.length;
  byId("effects").hidden = !data.effects.length;
  for (const { name, text: meaning } of data.effects) {
    const box = element("input", { type: "checkbox", id: `e-${name}`, checked: true });
    box.addEventListener("change", () => {
      const off = data.effects.map((e) => e.name).filter((n) => (n === name ? !box.checked : state.off.includes(n)));
      change({ ...state, off }, true);
    });
    byId("effects").append(element("div", { className: "effect" }, box, element("label", { htmlFor: box.id }, name), element("small", {}, meaning)));
  }
  data.steps.forEach((s, k) => byId("step").append(element("option", { value: k }, `${digits(1000 * s.length, 6)} ms${k === usualStep ? ", as the scene" : ""}`)));
  byId("step").addEventListener("change", () => change({ ...state, step: Number(byId("step").value) }, true));
  choice("algorithm", data.algorithms, String);
  choice("extrapolation", Object.keys(data.variants[0].extrapolations).map(Number), (degree) => ["0, held", "1, linear", "2, quadratic"][degree]);
  for (const preset of data.presets) {
    const button = element("button", { type: "button" }, preset.name);
    button.addEventListener("click", () => {
      const { name, values: given, effects = {}, step, ...master } = preset, values = { ...state.values, ...given };
      for (const name of Object.keys(given)) if (Math.abs(values[name] - parameters[name].value) <= 1e-6 * Math.abs(parameters[name].value)) delete values[name];
      const off = data.effects.map((e) => e.name).filter((n) => (n in effects ? !effects[n] : state.off.includes(n)));
      change({ ...state, ...master, off, values, step: step === undefined ? state.step : data.steps.findIndex((s) => s.length === step) }, true);
    });
    byId("presets").append(button);
  }
  const judged = [...new Set(data.figures.flatMap((f) => f.signals))], names = data.signals.map((s) => s.name);
  const start = [judged[0] ?? names[0], judged.find((n) => n !== judged[0]) ?? names.find((n) => n !== judged[0])];
  [1, 2].forEach((k) => {
    data.signals.forEach((s) => byId(`signal${k}`).append(element("option", { value: s.name }, s.name)));
    byId(`signal${k}`).value = start[k - 1] ?? names[0];
    byId(`signal${k}`).addEventListener("change", () => drawCurve(k));
  });
  data.signals.forEach((s) => byId("over2").append(element("option", { value: s.name }, s.name)));
  byId("over2").addEventListener("change", () => drawCurve(2));
  byId("reset").addEventListener("click", () => change(initial(), true));
  byId("pin").addEventListener("click", () => {
    pinned = pinned ? null : shown && { run: shown, address: address(state) };
    byId("pin").textContent = pinned ? "Unpin" : "Pin for comparison";
    byId("pin").setAttribute("aria-pressed", String(Boolean(pinned)));
    showNumbers();
    drawAll();
  });
  window.addEventListener("hashchange", () => { if (location.hash.slice(1) !== address(state)) change(stateOf(location.hash), false); });
}

// ---- a change asks, the latest one is answered ----
let worker, workerUrl, sources, asked = 0, waiting = 0, patience = 5000;
let answered = () => {}; // once the first run has an answer
function startWorker() {
  worker = new Worker((workerUrl ??= URL.createObjectURL(new Blob([byId("worker").textContent], { type: "text/javascript" }))));
  worker.onmessage = ({ data: message }) => { if (message.id === question) answers[message.kind](message); };
  worker.onerror = (event) => tell(`The computation could not be started: ${event.message}.`);
  worker.postMessage({ data: { ...data, parameters: undefined, layouts: undefined, settings: undefined }, modules: sources });
}
function change(next, settled, keep) {
  state = next;
  if (settled && address(state) !== location.hash.slice(1)) location.hash = address(state); // an entry of the history
  data.parameters.forEach((p) => p.show(keep));
  data.effects.forEach(({ name }) => { byId(`e-${name}`).checked = !state.off.includes(name); });
  byId("step").value = state.step;
  for (const key of Object.keys(usual)) byId(key).value = state[key];
  elsewhere();
  ask();
}
function ask() {
  question += 1;
  asked = performance.now();
  byId("results").classList.add("waiting");
  clearTimeout(waiting);
  waiting = setTimeout(() => { // a run whose start or single step takes this long cannot be asked to give up
    patience *= 2; // this machine may only be slow
    worker.terminate();
    startWorker();
    send();
  }, patience);
  send();
}
function send() { worker.postMessage({ id: question, variant: variantOf(state), values: Object.fromEntries(Object.entries(state.values).filter(([n]) => available(n))), step: state.step, extrapolation: state.extrapolation }); }
const tell = (sentence) => { byId("sentence").hidden = !sentence; byId("sentence").textContent = sentence; };
const answers = {
  progress({ time }) { clearTimeout(waiting); byId("status").textContent = `Computing: ${digits(time, 3)} of ${data.stop} s.`; },
  run(run) {
    clearTimeout(waiting);
    shown = { ...run, errors: {} };
    ladder = [];
    byId("results").classList.remove("waiting");
    const reached = (run.count - 1) * run.step;
    byId("status").textContent = `${digits(reached, 6)} s computed in ${run.spent.toFixed(0)} ms, ${digits((1000 * reached) / run.spent, 2)} times as fast as real time.`;
    tell([problem, run.whole ? windowOf(run) : `The run ended at ${digits(reached, 4)} s: ${run.said}.`].filter(Boolean).join(" "));
    showNumbers();
    drawCurve(1);
    drawCurve(2);
    byId("results").dataset.answered = (performance.now() - asked).toFixed(1);
    answered();
  },
  errors({ errors, worst, figure, said }) {
    shown.errors = errors;
    if (said || worst > 0.05) {
      tell([problem, said ? `With half the steps the run ends early: ${said}.`
        : `${figure} is known to ${digits(100 * worst, 2)} % of its size only: the macro step is too long for this state, or the motion is so sensitive that a longer run is needed.`].filter(Boolean).join(" "));
    }
    showNumbers();
    byId("results").dataset.judged = question;
  },
  ladder(rung) {
    ladder[rung.place] = rung;
    drawAccuracy();
    if (rung.place === state.step && !rung.stable && shown.whole) {
      tell([problem, `The macro step of ${digits(1000 * rung.length, 4)} ms is beyond the stability limit of this state: the coupling makes the signals grow.`].filter(Boolean).join(" "));
    }
    if (rung.place === data.steps.length - 1) byId("results").dataset.laddered = question;
  },
  error({ text: what }) { clearTimeout(waiting); tell(`The computation failed: ${what}.`); },
};

function windowOf(run) { // why there are no numbers: "" where there are some
  const none = data.figures.find((f) => f.window && Number.isNaN(run.numbers[f.name]));
  if (!none) return "";
  const [signal, from, to] = none.window, x = run.columns[signal];
  return `The figures are those from ${digits(from, 6)} to ${digits(to, 6)} of ${signal}, and this run covers ${digits(x[0], 4)} to ${digits(x.at(-1), 4)}: there are no numbers.`;
}

// ---- numbers ----
function showNumbers() {
  if (!shown) return;
  byId("numbers").replaceChildren(...data.figures.map((f) => {
    const value = element("dd", {}, `${withError(shown.numbers[f.name], shown.errors[f.name])}${unitText(f.unit)}`);
    const before = pinned?.run.numbers[f.name];
    if (pinned) value.append(element("small", {}, `pinned ${digits(before, 5)}, change ${digits(shown.numbers[f.name] - before, 3)}`));
    return element("div", {}, element("dt", {}, f.text), value);
  }));
  showRanges();
}
function showRanges() {
  const table = data.table, box = byId("ranges");
  const near = (name, value) => Math.abs((state.values[name] ?? parameters[name].value) - value) <= 0.01 * Math.abs(value);
  const condition = table && Object.keys(table.conditions).find((c) => Object.entries(table.conditions[c]).every(([n, v]) => near(n, v)));
  box.hidden = !table;
  if (!table) return;
  const rows = table.rows.filter((r) => r.condition === condition);
  const caption = condition ? `${table.title}, ${condition}` : `${table.title}: no ranges for this state, only for ${Object.keys(table.conditions).join(" and ")}`;
  const head = element("tr", {}, ...["Quantity", "Value", "Range", "Unit", "Answer"].map((h) => element("th", { scope: "col" }, h)));
  const body = rows.map((r) => {
    const figure = data.figures.find((f) => f.measure === r.measure);
    const value = shown.numbers[figure.name], error = shown.errors[figure.name];
    const margin = Math.min(value - (r.low ?? -Infinity), (r.high ?? Infinity) - value);
    const answer = !Number.isFinite(value) ? "not computed" : margin < 0 ? "outside" : error > margin ? "undecided" : "inside";
    const row = element("tr", { className: { outside: "out", undecided: "undecided", inside: "in" }[answer] ?? "", title: `${data.standings[r.standing]}: ${r.source}` });
    row.append(element("td", {}, r.quantity), element("td", { className: "measured" }, withError(value, error)),
      element("td", {}, `${r.low ?? ""} to ${r.high ?? ""}`), element("td", {}, r.unit), element("td", {}, element("span", { className: `badge ${{ inside: "passed", outside: "failed" }[answer] ?? "undecided"}` }, answer)));
    return row;
  });
  box.replaceChildren(element("caption", {}, caption), ...(rows.length ? [element("thead", {}, head), element("tbody", {}, ...body)] : []));
}

// ---- curves ----
const POINTS = 1500;
function thinned(run, y) { // the least and the largest of each piece
  const n = y.length, pieces = POINTS / 2, xs = [], ys = [];
  if (n <= POINTS) return { x: Array.from(y, (_, k) => k * run.step), y: Array.from(y) };
  for (let piece = 0; piece < pieces; piece++) {
    const end = Math.floor((n * (piece + 1)) / pieces);
    let least = Math.floor((n * piece) / pieces), largest = least;
    for (let k = least; k < end; k++) { if (y[k] < y[least]) least = k; if (y[k] > y[largest]) largest = k; }
    for (const k of least === largest ? [least] : [Math.min(least, largest), Math.max(least, largest)]) { xs.push(k * run.step); ys.push(y[k]); }
  }
  return { x: xs, y: ys };
}
let plotting = false;
const again = new Set();
async function plot(id, traces, layout) {
  if (!plotting) return;
  const spec = JSON.stringify({ traces, layout });
  const { traces: drawn, layout: of } = JSON.parse(wantsDark.matches ? recoloured(spec) : spec);
  if (again.has(id)) return Plotly.react(id, drawn, of, config);
  again.add(id);
  return Plotly.newPlot(id, drawn, of, config);
}
const ORBIT = 4000; // points of one signal over another
function orbit(x, y) {
  const every = Math.max(1, Math.ceil(y.length / ORBIT)), some = (values) => Array.from(values).filter((_, k) => k % every === 0);
  return { x: some(x), y: some(y) };
}
const labelled = ({ name, unit, text: what }) => { // of an axis
  const whole = `${what}${unit === "1" ? "" : `, ${unit}`}`;
  return whole.length > 42 ? `${name.split(".").at(-1)}, ${unit}` : whole;
};
function drawCurve(k) {
  if (!shown) return;
  const name = byId(`signal${k}`).value, over = k === 2 ? byId("over2").value : "", colours = data.colours, traces = [];
  const of = (signal) => data.signals.find((s) => s.name === signal);
  const line = (run, y, title, colour, more = {}) => ({
    type: "scatter", name: title, ...(over ? { ...orbit(run.columns[over], y), mode: "markers", marker: { color: colour, size: 2.5 } }
      : { ...thinned(run, y), mode: "lines", line: { color: colour, width: 1.4, ...more } }),
  });
  const parts = (run) => Object.entries(run.smooth).filter(([key]) => key.startsWith(`${name} below`));
  if (pinned) traces.push(line(pinned.run, parts(pinned.run)[0]?.[1] ?? pinned.run.columns[name], "pinned", colours.pinned, { dash: "dot" }));
  const smooth = parts(shown);
  traces.push(line(shown, shown.columns[name], smooth.length ? "unfiltered" : "this state", smooth.length ? colours.raw : colours.line));
  smooth.forEach(([key, y]) => traces.push(line(shown, y, key.slice(name.length + 1), colours.line, { width: 2 })));
  const layout = structuredClone(data.layouts.curve);
  layout.yaxis.title.text = labelled(of(name));
  if (over) layout.xaxis.title.text = labelled(of(over));
  return plot(`curve${k}`, traces, layout);
}
function drawAccuracy() {
  const rungs = ladder.filter(Boolean), good = rungs.filter((r) => r.stable && r.error > 0), bad = rungs.find((r) => !r.stable), colours = data.colours;
  const layout = structuredClone(data.layouts.accuracy), here = data.steps[state.step].length;
  layout.yaxis.title.text = "error of the numbers";
  const traces = [{ type: "scatter", mode: "lines+markers", name: "error", x: good.map((r) => r.length), y: good.map((r) => r.error), line: { color: colours.line } }];
  const at = good.find((r) => r.length === here);
  if (at) traces.push({ type: "scatter", mode: "markers", name: "this state", x: [here], y: [at.error], marker: { size: 13, color: colours.bad, symbol: "diamond" } });
  layout.shapes = bad ? [{ type: "line", x0: bad.length, x1: bad.length, y0: 0, y1: 1, yref: "paper", line: { color: colours.bad, dash: "dash" } }] : [];
  const ends = [data.steps[0].length, data.steps.at(-1).length].map(Math.log10);
  layout.xaxis.range = [ends[0] - 0.1, ends[1] + 0.1];
  byId("limit").textContent = `Largest difference of the numbers from those of the shortest step, over their size. ${
    bad ? `The dashed line: with ${digits(1000 * bad.length, 4)} ms the run is unstable${bad.said ? ` (${bad.said})` : ""}.` : rungs.length === data.steps.length ? "No step that the page offers is unstable here." : ""}`;
  return plot("accuracy", traces, layout);
}
const drawAll = () => { drawCurve(1); drawCurve(2); drawAccuracy(); };

async function begin() {
  build();
  try {
    sources = await Promise.all(data.variants.map((_, k) => unpacked(`module${k}`, "arrayBuffer")));
  } catch { return tell("This browser cannot unpack the page: it is older than 2023."); }
  if (typeof WebAssembly === "undefined") return tell("This browser has no WebAssembly, or has it switched off.");
  const first = new Promise((done) => { answered = done; setTimeout(done, 2000); });
  startWorker();
  change(stateOf(location.hash), false);
  await first; // numbers first: the library that draws takes a second to start
  try {
    document.head.append(Object.assign(document.createElement("script"), { textContent: await unpacked("plotly-inside") }));
    plotting = typeof Plotly !== "undefined";
  } catch { /* said below */ }
  byId("no-plotly").hidden = plotting;
  wantsDark.addEventListener("change", drawAll);
  drawAll();
}
begin();
