// How figures and curves move with one parameter: exact derivatives at a state, and what they say of the states beside it.
"use strict";
let slopeBy = "", slope = null, slopeSources = null; // the parameter asked for; the last answer, with the run and the state that it is of
const STEP = 0.1; // of a slider's range: a curve is shown so far beside one that nobody moves
const signedText = (value, n) => `${value < 0 ? "−" : "+"}${digits(Math.abs(value), n)}`;
function slopeButton(p) {
  const why = data.slope.refused[p.name], button = element("button", { type: "button", className: "by", id: `s-${p.name}`, disabled: Boolean(why) }, "slope");
  button.title = why ? `No slope: ${why}` : `How the figures and curves move with: ${p.text}`;
  button.setAttribute("aria-label", `slope by ${p.text}`);
  button.setAttribute("aria-pressed", "false");
  button.addEventListener("click", () => askSlope(slopeBy === p.name ? "" : p.name));
  p.pressed = () => button.setAttribute("aria-pressed", String(slopeBy === p.name));
  return button;
}
function slopeFollows(name) { if (slopeBy && slopeBy !== name && !data.slope.refused[name]) askSlope(name); } // to the slider in use
async function askSlope(name) { // modules are unpacked once somebody asks
  slopeBy = name;
  data.parameters.forEach((p) => p.pressed());
  if (!name) { slope = null; showNumbers(); return void draw("curve1", "curve2"); }
  if (!slopeSources) {
    slopeSources = await Promise.all(data.variants.map((_, k) => unpacked(`tangents${k}`, "arrayBuffer")));
    worker.postMessage({ tangents: slopeSources });
  }
  dragged = false; // the slope at the state that is there
  ask();
}
const besides = (one, name) => address({ ...one, values: Object.fromEntries(Object.entries(one.values).filter(([n]) => n !== name)) });
// By how much the parameter has moved from where the slope was computed; null where something else has moved, too.
function movedBy() {
  if (!slope || slope.name !== slopeBy || slope.beside !== besides(state, slope.name)) return null;
  return (state.values[slope.name] ?? parameters[slope.name].value) - slope.at;
}
function slopeText(figure) { // of a figure: its slope and elasticity, and what it says of the present state; nothing where nobody asks
  const by = movedBy();
  if (by === null) return [];
  const { derivative, how, why } = slope.figures[figure.name], p = parameters[slope.name], was = slope.run.numbers[figure.name];
  if (why) return [`no slope: ${why}`];
  const { unit, factor } = shownAs(figure, was), across = scaleOf(p);
  const elasticity = was && slope.at ? `; 1 % moves it ${signedText((derivative * slope.at) / was, 2)} %` : "";
  const lines = [`slope ${signedText((derivative * factor) / across.factor, 3)}${unitText(unit)} per ${across.unit || "1"}${how && `, ${how === "above" ? "upwards" : "downwards"} alone`}${elasticity}`];
  if (by) lines.push(`by the slope ${digits((was + derivative * by) * factor, 5)}${unitText(unit)}`);
  return lines;
}
// The curve of a signal by the slope: at the present value of the parameter, or a step beside it where that has not moved.
function predictedCurve(name) {
  const by = movedBy(), tangent = by !== null && slope.tangents[name];
  if (!tangent) return null;
  const p = parameters[slope.name], step = STEP * (p.to - p.from), way = by || (slope.at + step > p.to ? -step : step), { unit, factor } = scaleOf(p);
  const below = Object.keys(slope.smooth).find((key) => key.startsWith(`${name} below`)), from = below ? slope.run.smooth[below] : slope.run.columns[name];
  const along = below ? slope.smooth[below] : tangent;
  const title = by ? "by the slope" : `by the slope, ${signedText(way * factor, 3)}${unitText(unit)}`;
  return { run: slope.run, y: from.map((v, k) => v + way * along[k]), title };
}
