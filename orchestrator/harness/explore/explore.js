// The page: settings on the left, their answer on the right; the worker computes.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const parameters = Object.fromEntries(data.parameters.map((p) => [p.name, p]));
const usualStep = data.steps.findIndex((s) => s.length === data.step);
const usual = { algorithm: data.algorithms[0], extrapolation: data.extrapolation };
const initial = () => ({ values: {}, off: [], step: usualStep, ...usual });
let state = initial(), pinned = null, shown = null, ladder = [], influences = [], scanned = [], question = 0, problem = "";
const element = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};
const unitText = (unit) => unit && ` ${unit}`;
const scaleOf = (p) => shownAs(p, Math.max(Math.abs(p.from), Math.abs(p.to))); // of a slider and what belongs to it
const readable = (p, value) => text(Number((value * scaleOf(p).factor).toPrecision(6)));
function declared(p, shown) { // the parameter's number for a text in the unit of its slider; what stands for its own is that
  const value = Number((Number(shown) / scaleOf(p).factor).toPrecision(12));
  return Math.abs(value - p.value) <= 1e-6 * Math.abs(p.value) ? p.value : value;
}

// ---- settings ----
const variantOf = ({ off, algorithm }) => data.variants.findIndex((v) => v.algorithm === algorithm
  && Object.entries(v.effects).every(([name, on]) => on !== off.includes(name)));
const available = (name) => name in data.variants[variantOf(state)].parameters;
function refusal(p, value) { // why a text is no value of a parameter; "" for one that is
  const number = declared(p, value), [low, high] = [p.low, p.high].map((end) => (end === null ? null : digits(end * scaleOf(p).factor, 6)));
  const range = low === null && high === null ? "" : high === null ? `, at least ${low}` : low === null ? `, at most ${high}` : ` from ${low} to ${high}`;
  const fits = String(value).trim() !== "" && Number.isFinite(number) && (p.low === null || number >= p.low) && (p.high === null || number <= p.high);
  return fits ? "" : `${JSON.stringify(String(value))}: expected a number${range}${unitText(scaleOf(p).unit)}`;
}
function knob(p) {
  const id = `p-${p.name}`, box = element("div", { className: "knob" });
  const label = element("label", { htmlFor: id }, `${p.text} `, element("small", {}, `${p.name}${scaleOf(p).unit && `, ${scaleOf(p).unit}`}`));
  const asks = slopeButton(p);
  const slider = element("input", { type: "range", min: p.from, max: p.to, step: "any", value: p.value });
  slider.setAttribute("aria-label", `${p.text}, slider${unitText(scaleOf(p).unit)}`);
  const field = element("input", { type: "text", inputMode: "decimal", id, value: readable(p, p.value), autocomplete: "off" });
  const wrong = element("div", { className: "wrong", id: `${id}-wrong`, hidden: true });
  field.setAttribute("aria-describedby", wrong.id);
  const take = (value, settled) => {
    const why = refusal(p, value);
    field.setAttribute("aria-invalid", String(Boolean(why)));
    wrong.hidden = !why;
    wrong.textContent = why;
    if (why) return;
    const values = { ...state.values, [p.name]: declared(p, value) };
    if (values[p.name] === p.value) delete values[p.name];
    change({ ...state, values }, settled, field);
  };
  const rounded = () => Number((slider.value * scaleOf(p).factor).toPrecision(4));
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
  [slider, field].forEach((one) => one.addEventListener("focus", () => slopeFollows(p.name)));
  box.append(label, asks, slider, field, wrong);
  p.show = (keep) => {
    const value = state.values[p.name] ?? p.value, there = available(p.name);
    box.classList.toggle("changed", p.name in state.values);
    slider.min = Math.min(p.from, value); // a field takes more than the usual range
    slider.max = Math.max(p.to, value);
    slider.value = value;
    if (keep !== field) { field.value = readable(p, value); field.setAttribute("aria-invalid", "false"); wrong.hidden = true; }
    slider.disabled = field.disabled = !there;
    asks.hidden = !there;
  };
  return box;
}
function choice(key, values, shownAs) { // of a setting of the master: nothing to choose, nothing shown
  const select = byId(key);
  select.parentElement.hidden = values.length < 2;
  values.forEach((value) => select.append(element("option", { value }, `${shownAs(value)}${value === usual[key] ? ", scene" : ""}`)));
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
  data.steps.forEach((s, k) => byId("step").append(element("option", { value: k }, `${digits(1000 * s.length, 6)} ms${k === usualStep ? ", scene" : ""}`)));
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
  data.figures.forEach((f) => byId("figure").append(element("option", {}, f.text)));
  byId("figure").addEventListener("change", () => { showInfluences(); draw("scan"); });
  data.first.forEach((name) => byId("scanned").append(element("option", { value: name }, parameters[name].text)));
  byId("scanned").addEventListener("change", ask);
  byId("moves").hidden = !data.first.length || !data.figures.length;
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
let dragged = false; // a slider or a field: curves follow in the axes that are there until it is let go
let answered = () => {}; // once the first run has an answer
function startWorker() {
  worker = new Worker((workerUrl ??= URL.createObjectURL(new Blob([byId("worker").textContent], { type: "text/javascript" }))));
  worker.onmessage = ({ data: message }) => { if (message.id === question) answers[message.kind](message); };
  worker.onerror = (event) => tell(`The computation could not be started: ${event.message}.`);
  worker.postMessage({ data: { ...data, usual: Object.fromEntries(data.parameters.map((p) => [p.name, p.value])), sliders: data.first.map((n) => ({ name: n, from: parameters[n].from, to: parameters[n].to })), parameters: undefined, layouts: undefined, settings: undefined }, modules: sources });
  if (slopeSources) worker.postMessage({ tangents: slopeSources });
}
function change(next, settled, keep) {
  state = next;
  dragged = Boolean(keep) && !settled;
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
  byId("results").classList.remove("refused");
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
function send() { worker.postMessage({ id: question, variant: variantOf(state), values: Object.fromEntries(Object.entries(state.values).filter(([n]) => available(n))), step: state.step, extrapolation: state.extrapolation, over: byId("scanned").value, slope: dragged ? "" : slopeBy }); }
const tell = (sentence) => { byId("sentence").hidden = !sentence; byId("sentence").textContent = sentence; };
function none(sentence) { // no numbers of this state: those of the last one stay, in grey
  clearTimeout(waiting);
  byId("results").classList.replace("waiting", "refused");
  byId("status").textContent = shown ? "The numbers and curves below are those of the last state that was computed." : "";
  tell([problem, sentence.replace(/[^.]$/, "$&.")].filter(Boolean).join(" "));
  byId("results").dataset.judged = byId("results").dataset.laddered = question;
}
const answers = {
  progress({ time }) { clearTimeout(waiting); byId("status").textContent = `Computing: ${digits(time, 3)} of ${data.stop} s.`; },
  run(run) {
    clearTimeout(waiting);
    shown = { ...run, errors: {} };
    ladder = [];
    influences = [];
    scanned = [];
    byId("results").classList.remove("waiting", "refused");
    const reached = (run.count - 1) * run.step;
    noteTime({ spent: run.spent, rows: run.count });
    tell([problem, run.whole ? windowOf(run) : `The run ended at ${digits(reached, 4)} s: ${run.said}.`].filter(Boolean).join(" "));
    showNumbers();
    draw("curve1", "curve2", ...Object.keys(shows));
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
    showLimit();
    draw("accuracy");
    if (rung.place === state.step && !rung.stable && shown.whole) {
      tell([problem, `The macro step of ${digits(1000 * rung.length, 4)} ms is beyond the stability limit of this state: the coupling makes the signals grow.`].filter(Boolean).join(" "));
    }
    if (rung.place === data.steps.length - 1) byId("results").dataset.laddered = question;
  },
  influence(answer) { influences.push(answer); noteTime(answer); showInfluences(); },
  scan(answer) {
    scanned[answer.place] = answer;
    noteTime(answer);
    if (answer.place % 4 === 0 || answer.place === answer.count - 1) draw("scan");
    if (answer.place === answer.count - 1) byId("results").dataset.scanned = question;
  },
  slope(answer) {
    slope = { ...answer, run: shown, beside: besides(state, answer.name) };
    showNumbers();
    draw("curve1", "curve2");
    byId("results").dataset.sloped = question;
  },
  refused({ text: what }) { none(`This state does not start: ${what.replace(/^at t = [^:]*: /, "")}`); },
  error({ text: what }) { none(`The computation failed: ${what}`); },
};

function windowOf(run) { // why there are no numbers: "" where there are some
  const none = data.figures.find((f) => f.window && Number.isNaN(run.numbers[f.name]));
  if (!none) return "";
  const [signal, from, to] = none.window, x = run.columns[signal];
  return `The figures are those from ${digits(from, 6)} to ${digits(to, 6)} of ${signal}, and this run covers ${digits(x[0], 4)} to ${digits(x.at(-1), 4)}: there are no numbers.`;
}

const wholeFrom = (least, x) => (x < least ? digits(x, 2) : x.toFixed(0));
function noteTime({ spent, rows }) { // of a run with the macro step of this state: the fastest of them counts, the others were disturbed
  const reached = (shown.count - 1) * shown.step, steps = Math.max(rows - 1, 1);
  shown.perStep = Math.min(shown.perStep ?? Infinity, (1000 * spent) / steps);
  const perStep = (run) => `${digits(run.perStep, 2)} µs`;
  byId("status").textContent = `${digits(reached, 6)} s computed in ${shown.spent.toFixed(0)} ms, ${wholeFrom(10, (1000 * reached) / shown.spent)} times as fast as real time; ${
    perStep(shown)} a macro step at best${pinned ? `, pinned ${perStep(pinned.run)}` : ""}.`;
}

// ---- numbers ----
function showNumbers() {
  if (!shown) return;
  byId("numbers").replaceChildren(...data.figures.map((f) => {
    const now = shown.numbers[f.name], { number, error, unit } = quantity(now, f, shown.errors[f.name]);
    const value = element("dd", {}, `${withError(number, error)}${unit}`);
    if (pinned) {
      const before = pinned.run.numbers[f.name], [was, change] = [before, now - before].map((v) => quantity(v, f, 0, now).number);
      value.append(element("small", {}, `pinned ${digits(was, 5)}, change ${digits(change, 3)}`));
    }
    value.append(...slopeText(f).map((line) => element("small", { className: "slope" }, line)));
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

// ---- what moves a figure ----
const chosenFigure = () => data.figures[byId("figure").selectedIndex];
function showInfluences() {
  const figure = chosenFigure(), box = byId("influences");
  if (!figure || !shown) return;
  const base = shown.numbers[figure.name], error = shown.errors[figure.name];
  const rows = influences.map((one) => ({ ...one, change: one.numbers[figure.name] - base })).filter((one) => Number.isFinite(one.change));
  rows.sort((a, b) => Math.abs(b.change) - Math.abs(a.change));
  const most = Math.abs(rows[0]?.change) || 1, signed = (v, n) => `${v < 0 ? "−" : "+"}${digits(Math.abs(v), n)}`;
  box.replaceChildren(...rows.map(({ name, by, change }) => {
    const { text: meaning } = parameters[name], { unit, factor } = scaleOf(parameters[name]), share = Math.abs(change) / most, hidden = Math.abs(change) <= error;
    const bar = element("span", { className: `influence ${change < 0 ? "down" : "up"}` });
    bar.style.width = `${100 * share}%`;
    return element("tr", { className: hidden ? "below" : "", title: hidden ? "within the numerical error" : "" },
      element("th", { scope: "row" }, meaning, element("small", {}, ` ${signed(by * factor, 2)}${unitText(unit)}`)),
      element("td", {}, bar), element("td", { className: "num" }, `${signed(quantity(change, figure, 0, base).number, 3)}${quantity(base, figure).unit}`));
  }));
}
function drawScan() {
  const figure = chosenFigure(), name = byId("scanned").value, points = scanned.filter(Boolean), colours = data.colours;
  if (!figure || !name) return;
  const layout = structuredClone(data.layouts.curve), p = parameters[name], here = state.values[name] ?? p.value;
  const across = scaleOf(p), up = shownAs(figure, Math.max(...points.map((one) => Math.abs(one.numbers?.[figure.name] ?? 0))));
  layout.xaxis.title.text = labelled({ name, unit: across.unit, text: p.text });
  layout.xaxis.range = [p.from * across.factor, p.to * across.factor];
  layout.shapes = [{ type: "line", x0: here * across.factor, x1: here * across.factor, y0: 0, y1: 1, yref: "paper", line: { color: colours.bad, width: 1.2 } }];
  const signal = figure.section ? data.signals.find((s) => s.name === figure.signals[0]) : null;
  layout.yaxis.title.text = signal ? labelled({ ...signal, unit: shownAs(signal, 0).unit }) : labelled({ ...figure, unit: up.unit });
  const trace = signal ? { mode: "markers", marker: { size: 2.5, color: colours.line }, name: "section",
    x: points.flatMap((one) => one.points.map(() => one.value * across.factor)), y: points.flatMap((one) => one.points) }
    : { mode: "lines+markers", marker: { size: 4 }, line: { color: colours.line }, name: figure.text, x: points.map((one) => one.value * across.factor), y: points.map((one) => one.numbers[figure.name] * up.factor) };
  return plot("scan", [{ type: "scatter", showlegend: false, ...trace }], layout);
}

// ---- machines in motion ----
const shows = Object.fromEntries(data.machines.map((_, k) => [`motion${k}`, moving(byId(`motion${k}`))]));
function drawMotion(k) {
  const machine = data.machines[k], box = byId(`motion${k}`), motion = shown && motionOf(machine, shown, (name) => state.values[name] ?? parameters[name].value);
  box.hidden = Boolean(shown) && !motion; // of an effect that is off
  again.add(box.id);
  if (!motion) return;
  shows[box.id](motion);
  const caption = machine.caption.replace(/\{(\d)\}/g, (_, n) => digits(motion.numbers[n], 4));
  const part = machine.longest && machine.longest < data.stop ? ` The first ${digits(machine.longest, 4)} s of ${digits(data.stop, 4)} s.` : "";
  box.querySelector(".caption").textContent = caption + part;
}

// ---- curves ----
const MOST_POINTS = 1500;
function thinned(run, y, width) { // the least and the largest of each piece; a piece is 1.5 px wide
  const points = Math.min(MOST_POINTS, Math.max(400, Math.round(width / 0.75))), n = y.length, pieces = points / 2, xs = [], ys = [];
  if (n <= points) return { x: Array.from(y, (_, k) => k * run.step), y: Array.from(y) };
  for (let piece = 0; piece < pieces; piece++) {
    const end = Math.floor((n * (piece + 1)) / pieces);
    let least = Math.floor((n * piece) / pieces), largest = least;
    for (let k = least; k < end; k++) { if (y[k] < y[least]) least = k; if (y[k] > y[largest]) largest = k; }
    for (const k of least === largest ? [least] : [Math.min(least, largest), Math.max(least, largest)]) { xs.push(k * run.step); ys.push(y[k]); }
  }
  return { x: xs, y: ys };
}
let plotting = false;
const again = new Set(), drawings = { curve1: () => drawCurve(1), curve2: () => drawCurve(2), accuracy: () => drawAccuracy(), scan: () => drawScan(),
  ...Object.fromEntries(data.machines.map((_, k) => [`motion${k}`, () => drawMotion(k)])) };
const inSight = new Set(), behind = new Set(); // plots that can be seen; those that are drawn anew when they come into sight
const sight = new IntersectionObserver((entries) => {
  for (const { target: { id }, isIntersecting } of entries) {
    if (!isIntersecting) { inSight.delete(id); continue; }
    inSight.add(id);
    if (behind.delete(id)) drawings[id]();
  }
}, { rootMargin: "100px" });
function draw(...ids) {
  for (const id of ids) if (inSight.has(id) || !again.has(id)) drawings[id](); else behind.add(id);
}
// Lines of a plot drawn anew in the axes that are there, in a twentieth of the time of Plotly's layout. False where they do not fit:
// then the next axis has room for more.
function followed(id, traces, layout) {
  const box = byId(id), { xaxis, yaxis } = box._fullLayout ?? {}, paths = box.querySelectorAll(".scatterlayer path.js-line");
  if (paths.length !== traces.length || traces.some(({ mode }) => mode !== "lines") || xaxis.type !== "linear" || yaxis.type !== "linear") return false;
  const [low, high] = yaxis.range, all = traces.flatMap(({ y }) => y), [least, most] = [Math.min(low, ...all), Math.max(high, ...all)];
  if (least < low || most > high || traces.some(({ x }) => x[0] < xaxis.range[0] || x.at(-1) > xaxis.range[1])) {
    layout.yaxis.range = [least < low ? least - ROOM * (most - least) : low, most > high ? most + ROOM * (most - least) : high];
    return false;
  }
  traces.forEach(({ x, y }, k) => paths[k].setAttribute("d", `M${x.map((v, i) => `${xaxis.c2p(v).toFixed(1)},${yaxis.c2p(y[i]).toFixed(1)}`).join("L")}`));
  return true;
}
const ROOM = 0.25; // of a range, for a curve that has left it and moves on
async function plot(id, traces, layout) {
  if (!plotting || (dragged && followed(id, traces, layout))) return;
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
  const whole = `${what}${unit && `, ${unit}`}`;
  return whole.length > 42 ? `${name.split(".").at(-1)}${unit && `, ${unit}`}` : whole;
};
function drawCurve(k) {
  if (!shown) return;
  const name = byId(`signal${k}`).value, over = k === 2 ? byId("over2").value : "", colours = data.colours, traces = [], width = byId(`curve${k}`).clientWidth;
  const of = (signal) => data.signals.find((s) => s.name === signal);
  const line = (run, y, title, colour, more = {}) => ({
    type: "scatter", name: title, ...(over ? { ...orbit(run.columns[over], y), mode: "markers", marker: { color: colour, size: 2.5 } }
      : { ...thinned(run, y, width), mode: "lines", line: { color: colour, width: 1.4, ...more } }),
  });
  const parts = (run) => Object.entries(run.smooth).filter(([key]) => key.startsWith(`${name} below`));
  if (!shown.columns[name] || (over && !shown.columns[over])) return; // of an effect that is off
  if (pinned?.run.columns[name] && (!over || pinned.run.columns[over])) traces.push(line(pinned.run, parts(pinned.run)[0]?.[1] ?? pinned.run.columns[name], "pinned", colours.pinned, { dash: "dot" }));
  const smooth = parts(shown);
  traces.push(line(shown, shown.columns[name], smooth.length ? "unfiltered" : "this state", smooth.length ? colours.raw : colours.line));
  smooth.forEach(([key, y]) => traces.push(line(shown, y, key.slice(name.length + 1), colours.line, { width: 2 })));
  const predicted = over ? null : predictedCurve(name);
  if (predicted) traces.unshift({ ...line(predicted.run, predicted.y, predicted.title, colours.predicted, { width: 3 }), opacity: 0.6 });
  const layout = structuredClone(data.layouts.curve);
  const scaled = (axis, signal) => { // its numbers and its label in a unit for a reader
    const { unit, factor } = shownAs(of(signal), traces.reduce((most, trace) => trace[axis].reduce((m, v) => Math.max(m, Math.abs(v) || 0), most), 0));
    traces.forEach((trace) => { trace[axis] = Array.from(trace[axis], (v) => v * factor); });
    layout[`${axis}axis`].title.text = labelled({ ...of(signal), unit });
  };
  scaled("y", name);
  if (over) scaled("x", over);
  return plot(`curve${k}`, traces, layout);
}
function showLimit() {
  const rungs = ladder.filter(Boolean), bad = rungs.find((r) => !r.stable);
  byId("limit").textContent = `Largest difference of the numbers from those of the shortest step, over their size. ${
    bad ? `The dashed line: with ${digits(1000 * bad.length, 4)} ms the run is unstable${bad.said ? ` (${bad.said})` : ""}.` : rungs.length === data.steps.length ? "No step that the page offers is unstable here." : ""}`;
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
  return plot("accuracy", traces, layout);
}
const drawAll = () => draw(...Object.keys(drawings));

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
  Object.keys(drawings).forEach((id) => sight.observe(byId(id)));
  window.addEventListener("beforeprint", () => [...behind].forEach((id) => { behind.delete(id); drawings[id](); }));
}
begin();
