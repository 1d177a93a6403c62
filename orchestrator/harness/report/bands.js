// Bands of long lines, as in charts/bands.py: [x, least, largest] for each piece of a history; NaN and NaN where it is broken.
"use strict";
const IN_VIEW = 4000; // samples of a line in view; of more, the band of a quarter as many pieces
function band([x, least, largest], first, last) { // of the places from `first` to before `last`
  const count = last - first, pieces = IN_VIEW / 4;
  if (count <= IN_VIEW) return [x, least, largest].map((column) => Array.from(column.slice(first, last)));
  const rows = [[], [], []], push = (...row) => row.forEach((value, k) => rows[k].push(value));
  for (let piece = 0; piece < pieces; piece++) {
    const at = (k) => first + Math.floor(((count - 1) * k) / pieces), begin = at(piece), end = at(piece + 1);
    let low = Infinity, high = -Infinity, broken = false;
    for (let k = begin; k <= end; k++) { // neighbours share a sample: nothing of the line is between them
      if (Number.isNaN(least[k])) { broken = true; continue; }
      if (least[k] < low) low = least[k];
      if (largest[k] > high) high = largest[k];
    }
    if (broken && Number.isNaN(least[begin])) push(x[begin], NaN, NaN);
    if (low <= high) push(piece === 0 ? x[begin] : piece === pieces - 1 ? x[end] : 0.5 * (x[begin] + x[end]), low, high);
    if (broken && !Number.isNaN(least[begin])) push(x[end], NaN, NaN);
  }
  return rows;
}
function outline([x, least, largest]) { // there along the largest values, back along the least: a closed line for each part
  const out = { x: [], y: [] };
  for (let begin = 0, end; begin < x.length; begin = end + 1) {
    for (end = begin; end < x.length && !Number.isNaN(least[end]); end++);
    if (end === begin) continue;
    if (out.x.length) { out.x.push(null); out.y.push(null); }
    for (let k = begin; k < end; k++) { out.x.push(x[k]); out.y.push(largest[k]); }
    for (let k = end - 1; k >= begin; k--) { out.x.push(x[k]); out.y.push(least[k]); }
  }
  return out;
}
function unfolded(x, y) { // the rows of an outline
  const rows = [[], [], []], known = (k) => k < x.length && x[k] !== null && !Number.isNaN(x[k]);
  for (let begin = 0, end; begin < x.length; begin = end + 1) {
    for (end = begin; known(end); end++);
    if (begin) rows.forEach((column, i) => column.push(i ? NaN : column.at(-1)));
    for (let k = 0; k < (end - begin) / 2; k++) [x[begin + k], y[end - 1 - k], y[begin + k]].forEach((value, i) => rows[i].push(value));
  }
  return rows;
}
