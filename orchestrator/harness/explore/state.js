// The state of the page as an address, a command, Python and a scene.
"use strict";
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
  Object.assign(changes, values);
  for (const name of off) changes[unitOf(name).join(".effects.")] = false;
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
function inPython(changes) {
  const literal = (value) => (typeof value === "boolean" ? (value ? "True" : "False") : JSON.stringify(value));
  return `{\n${Object.entries(changes).map(([name, value]) => `    ${JSON.stringify(name)}: ${literal(value)},\n`).join("")}}`;
}
function elsewhere() {
  const { values, off, step, algorithm, extrapolation } = state, numbers = Object.entries(values).filter(([name]) => available(name));
  const sets = numbers.map(([name, value]) => ` --set ${name}=${text(value)}`);
  if (step !== usualStep) sets.push(` --step ${data.steps[step].length}`);
  if (algorithm !== usual.algorithm) sets.push(` --algorithm ${algorithm}`);
  if (extrapolation !== usual.extrapolation) sets.push(` --extrapolation ${extrapolation}`);
  for (const name of off) sets.push(` --set ${unitOf(name).join(".effects.")}=false`);
  byId("command").value = `cosimo run ${data.name}${sets.join("")}`;
  const changes = inPython(changesOf({ ...state, values: Object.fromEntries(numbers) }));
  const changed = address(state) !== address(initial());
  byId("python").value = `import cosimo\n\nscene = cosimo.load_scene(${JSON.stringify(data.name)})${changed ? `.with_changes(${changes})` : ""}\nresult = cosimo.run(scene)\nprint(result.summary)`;
  byId("toml").value = toml(settingsOf(state));
}
