// Machines in motion: a canvas with a slider over time. They run while they are seen, unless the reader's system asks for less motion.
"use strict";
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
const PASSAGE = 8; // s of real time for the whole motion, at most ten times slower or faster than it is
const LOOKS = { ground: ["--muted", 1.5, 0.6], part: ["--ink", 4, 1], second: ["--in", 4, 1], load: ["--out", 1.8, 1], trace: ["--in", 1.2, 0.55] };
const floats = (text) => new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
// A figure that shows what it is given: time, lines with their points at all instants, box, whether both axes have one scale.
function moving(figure) {
  const canvas = figure.querySelector("canvas"), slider = figure.querySelector("input");
  const button = figure.querySelector("button"), output = figure.querySelector("output");
  let motion = { time: [0], lines: [], box: [0, 1, 0, 1] }, running = false, frame = 0, shown = 0, since = 0, start = 0;
  const last = () => motion.time.length - 1, span = () => motion.time[last()] - motion.time[0] || 1;
  function draw() {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio; canvas.height = height * ratio;
    const pen = canvas.getContext("2d"), style = getComputedStyle(figure), [x0, x1, y0, y1] = motion.box;
    let sx = width / (x1 - x0), sy = height / (y1 - y0);
    if (motion.equal) sx = sy = Math.min(sx, sy);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const px = (x) => width / 2 + sx * (x - (x0 + x1) / 2), py = (y) => height / 2 - sy * (y - (y0 + y1) / 2);
    for (const { look, joints, corners, points } of motion.lines) {
      const [colour, thick, alpha] = LOOKS[look];
      const stands = points.length === 2 * corners, first = stands ? 0 : 2 * corners * shown;
      const places = look === "trace" ? Array.from({ length: shown + 1 }, (_, k) => 2 * corners * k) : Array.from({ length: corners }, (_, k) => first + 2 * k);
      pen.strokeStyle = pen.fillStyle = style.getPropertyValue(colour); pen.lineWidth = thick; pen.globalAlpha = alpha;
      pen.lineJoin = pen.lineCap = "round"; pen.beginPath();
      let gap = true;
      for (const k of places) {
        if (Number.isNaN(points[k + 1])) { gap = true; continue; }
        if (gap) pen.moveTo(px(points[k]), py(points[k + 1])); else pen.lineTo(px(points[k]), py(points[k + 1]));
        gap = false;
      }
      pen.stroke();
      if (joints) for (const k of places) { pen.beginPath(); pen.arc(px(points[k]), py(points[k + 1]), 1.6 * thick, 0, 2 * Math.PI); pen.fill(); }
    }
    slider.value = shown;
    output.textContent = `${motion.time[shown].toPrecision(4)} s`;
    slider.setAttribute("aria-valuetext", output.textContent);
  }
  function tick(now) {
    const whole = span(), end = motion.time[last()], passage = Math.min(10 * whole, Math.max(whole / 10, PASSAGE));
    const reached = start + ((now - since) / 1000 / passage) * whole;
    if (reached > end) { start = motion.time[0]; since = now; }
    let k = 0;
    while (k < last() && motion.time[k + 1] <= reached) k++;
    if (k !== shown) { shown = k; draw(); }
    frame = requestAnimationFrame(tick);
  }
  function run(wanted) {
    cancelAnimationFrame(frame);
    running = wanted; button.textContent = wanted ? "Pause" : "Play";
    start = shown === last() ? motion.time[0] : motion.time[shown]; since = performance.now();
    if (wanted) frame = requestAnimationFrame(tick);
  }
  function show(next) { // from the share of the time on that the former one had reached
    const share = shown / Math.max(last(), 1);
    motion = next;
    shown = Math.round(share * last());
    slider.max = last();
    if (running) run(true);
    draw();
  }
  button.addEventListener("click", () => { figure.dataset.chosen = "yes"; run(!running); });
  slider.addEventListener("input", () => { figure.dataset.chosen = "yes"; run(false); shown = Number(slider.value); draw(); });
  new ResizeObserver(draw).observe(canvas);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  new IntersectionObserver((entries) => {
    for (const entry of entries) if (!figure.dataset.chosen && !calm.matches) run(entry.isIntersecting);
  }, { threshold: 0.4 }).observe(figure);
  return show;
}
for (const script of document.querySelectorAll("figure.motion script")) { // of a report, whose numbers are in the page
  const data = JSON.parse(script.textContent);
  moving(script.closest("figure"))({ ...data, time: floats(data.time), lines: data.lines.map((line) => ({ ...line, points: floats(line.points) })) });
}
