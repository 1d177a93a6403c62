// The page asks for steps, one request after the other, and draws what comes. Names: see application.py.
"use strict";
const by = id => document.getElementById(id);
const LONGEST = 20000; // rows [x, least, largest] that a curve keeps: of more, neighbours become one. The file has all samples
let scene, shown = [], data = {}, running = false, begun = false, over = false, time = 0, busy = false, before = 0, revision = 0;

async function ask(action, content = {}) {
  const answer = await fetch("/" + action, {method: "POST", headers: {"content-type": "application/json"}, body: JSON.stringify(content)});
  const body = await answer.json();
  by("fault").hidden = answer.ok;
  if (!answer.ok) { by("fault").textContent = body.error; throw new Error(body.error); }
  return body;
}

function element(tag, attributes = {}, ...children) {
  const made = Object.assign(document.createElement(tag), attributes);
  made.append(...children);
  return made;
}

function entry(name, one, change) { // a row: label, field, unit of measure
  const id = "value-" + name;
  const logical = typeof one.value === "boolean" || one.kind === "boolean";
  const field = element("input", logical ? {id, type: "checkbox", checked: Boolean(one.value)} : {id, type: "text", value: one.value, inputMode: "decimal"});
  field.addEventListener("change", () => change(logical ? Number(field.checked) : number(field.value)));
  return [element("div", {className: "value"}, element("label", {htmlFor: id, textContent: one.name}), field, element("span", {className: "unit", textContent: one.unit})), field];
}

const number = text => text.trim() !== "" && isFinite(text) ? Number(text) : text; // "250 km/h" goes as it is

function build() {
  by("inputs").replaceChildren();
  by("parameters").replaceChildren();
  by("outputs").replaceChildren(by("outputs").firstElementChild);
  for (const unit of scene.units) {
    for (const input of unit.inputs) {
      const name = unit.name + "." + input.name;
      const move = async value => {
        if (!begun || over) return;
        await ask("move", {name, value}).then(now, () => 0);
      };
      const [row, field] = entry(name, {...input, name}, move);
      if (input.kind === "real") { // a slider about the present value
        const span = Math.max(2 * Math.abs(input.value), Math.abs(input.nominal), 1e-9);
        const slider = element("input", {type: "range", min: input.value - span, max: input.value + span, step: span / 200, value: input.value});
        slider.setAttribute("aria-label", name);
        slider.addEventListener("input", () => { field.value = Number(slider.value).toPrecision(4); move(Number(field.value)); });
        field.addEventListener("change", () => { slider.value = field.value; });
        row.append(slider);
      }
      by("inputs").append(row);
    }
    if (unit.parameters.length) by("parameters").append(element("h3", {textContent: unit.name}));
    for (const parameter of unit.parameters) {
      const name = unit.name + "." + parameter.name;
      const [row] = entry(name, parameter, value => { starts[name] = value; by("status").textContent = "Start anew to use the start values."; });
      by("parameters").append(row);
    }
    for (const output of unit.outputs) {
      const name = unit.name + "." + output.name;
      const box = element("input", {type: "checkbox", checked: shown.includes(name)});
      box.addEventListener("change", () => choose(name, box.checked));
      by("outputs").append(element("p", {className: "choice"}, element("label", {}, box, ` ${name}${output.unit ? ", " + output.unit : ""}`)));
    }
  }
  if (!by("inputs").children.length) by("inputs").append(element("p", {className: "settings", textContent: "All inputs are connected."}));
}

const measure = name => { const dot = name.indexOf("."); return scene.units.find(u => u.name === name.slice(0, dot)).outputs.find(o => o.name === name.slice(dot + 1)).unit; };
const starts = {};

function choose(name, wanted) {
  shown = wanted ? [...shown, name] : shown.filter(n => n !== name);
  data[name] = [[], [], []];
  draw();
}

function keep(times, rows, names) {
  names.forEach((name, k) => {
    const curve = data[name] ??= [[], [], []];
    times.forEach((t, i) => { const y = rows[i][k] ?? NaN; [t, y, y].forEach((value, c) => curve[c].push(value)); });
    if (curve[0].length > LONGEST) data[name] = halved(curve);
  });
}

const halved = rows => rows.map((column, c) => Array.from({length: Math.ceil(column.length / 2)}, (_, k) => {
  const both = column.slice(2 * k, 2 * k + 2).filter(v => !Number.isNaN(v));
  return !both.length ? NaN : c === 0 ? both[0] : c === 1 ? Math.min(...both) : Math.max(...both);
}));

function draw() { // a picture for each unit of measure
  const panels = new Map();
  for (const name of shown) panels.set(measure(name), [...(panels.get(measure(name)) ?? []), name]);
  const places = by("curves");
  while (places.children.length > panels.size) places.lastChild.remove();
  while (places.children.length < panels.size) places.append(element("div", {className: "plot", role: "img"}));
  [...panels].forEach(([unit, names], k) => {
    const lines = names.map((n, k) => ({...outline(band(data[n] ?? [[], [], []], 0, data[n]?.[0].length ?? 0)), name: n, mode: "lines", fill: "toself", hoveron: "points",
      line: {width: 1.6, color: LAYOUT.colorway[k % LAYOUT.colorway.length]}, fillcolor: LAYOUT.colorway[k % LAYOUT.colorway.length] + "66"}));
    const layout = {...LAYOUT, xaxis: {...LAYOUT.xaxis}, yaxis: {...LAYOUT.yaxis, title: {text: unit}}, datarevision: ++revision, legend: {orientation: "h", y: 1.02, yanchor: "bottom"}, uirevision: "kept"};
    places.children[k].setAttribute("aria-label", names.join(", ") + " over time");
    Plotly.react(places.children[k], lines, layout, {displayModeBar: false, responsive: true});
  });
}

function tell(extra = "") {
  by("status").textContent = `t = ${Number(time.toPrecision(6))} s of ${scene.stop} s${extra}`;
  by("run").textContent = running ? "Pause" : "Run";
  by("run").disabled = by("one").disabled = over || !begun;
}

async function begin() {
  running = false;
  const description = await ask("begin", {values: starts});
  scene = description; begun = true; over = false; time = scene.start; data = {};
  build(); // inputs have their start values again
  await now();
  by("table").hidden = true;
  tell();
}

async function now() { // a point at this instant: behind a jump of an input the curve has the values from before and after it
  const names = [...shown], present = await ask("present", {names});
  keep(present.times, present.rows, names);
  draw();
}

async function advance(to) {
  const names = [...shown];
  const answer = await ask("advance", {to, names});
  keep(answer.times, answer.rows, names);
  time = answer.time;
  over = answer.done || answer.failure !== "";
  if (answer.failure) { by("fault").textContent = answer.failure; by("fault").hidden = false; }
  if (over) running = false;
  draw(); tell(over && !answer.failure ? ", done" : "");
}

async function frame(now) {
  if (!running) return;
  if (!busy) {
    busy = true;
    const pace = Number(by("pace").value), past = Math.min((now - before) / 1000, 0.25);
    const ahead = pace ? pace * past : (scene.stop - scene.start) / 100;
    if (ahead >= scene.step || !pace) { before = now; await advance(time + Math.max(ahead, scene.step)).catch(() => { running = false; tell(); }); }
    busy = false;
  }
  requestAnimationFrame(frame);
}

by("run").addEventListener("click", async () => {
  if (over) return;
  running = !running; before = performance.now(); tell();
  requestAnimationFrame(frame);
});
by("one").addEventListener("click", () => { if (!running && !over) advance(time + 0.5 * scene.step).catch(() => 0); });
by("begin").addEventListener("click", () => begin().catch(() => 0));
by("errors").addEventListener("click", async () => {
  running = false; tell(", repeating with half of every step");
  const rows = await ask("errors").catch(() => null);
  tell();
  if (!rows) return;
  const share = e => e === null ? "not known" : `${e ? (100 * e).toPrecision(2) : 0} %`;
  by("table").tBodies[0].replaceChildren(...rows.map(r => element("tr", {}, ...[r.name, share(r.rms) + (r.parted ? ", histories part" : ""), share(r.largest)].map(text => element("td", {textContent: text})))));
  by("table").hidden = false;
});
addEventListener("load", async () => { scene = await ask("description"); shown = scene.shown; await begin().catch(() => 0); document.body.dataset.ready = "yes"; });
