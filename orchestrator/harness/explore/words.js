// Numbers as the reports print them, and a state in the forms in which cosimo takes it.
"use strict";
const digits = (value, n) => { // as Python's %.ng
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(n)))));
  if (power < -4 || power >= n) return value.toExponential(n - 1).replace(/\.?0+e/, "e").replace(/e([+-])(\d)$/, "e$10$2");
  const text = value.toPrecision(n);
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
};
function withError(value, error) {
  if (!Number.isFinite(value) || error === undefined || Number.isNaN(error)) return digits(value, 4);
  if (!Number.isFinite(error)) return `${digits(value, 4)} ± unknown`;
  if (error === 0) return `${digits(value, 6)} ± 0`;
  const size = value ? Math.floor(Math.log10(Math.abs(value))) : -Infinity;
  let digit = Math.floor(Math.log10(error));
  if (error < 10 ** (size - 5)) { digit = size - 4; error = 10 ** digit; } // negligible: five digits
  else if (error < 3 * 10 ** digit && digit > size - 5) digit -= 1;
  const shown = Math.ceil((error / 10 ** digit) * (1 - 1e-9)) * 10 ** digit;
  if (digit >= 0 && digit < 5 && Math.abs(value) < 1e6) {
    return `${(Math.round(value / 10 ** digit) * 10 ** digit).toFixed(0)} ± ${shown.toFixed(0)}`;
  }
  if (digit >= 0 || digit < -9 || (size > -Infinity && size < -5)) return `${digits(value, value ? Math.max(size - digit, 1) + 1 : 1)} ± ${digits(shown, 2)}`;
  return `${value.toFixed(-digit)} ± ${shown.toFixed(-digit)}`;
}
// The unit and factor in which a quantity is shown whose largest number is `size`; its choices come from the one table of units.
function shownAs({ choices }, size) {
  const fits = Number.isFinite(size) && size !== 0 ? choices.find(([, , least]) => Math.abs(size) >= least * (1 - 1e-12)) : choices.find(([, factor]) => factor === 1);
  const [unit, factor] = fits ?? choices[0];
  return { unit, factor };
}
// A number with its unit. of: the number that decides on the unit, if not this one.
function quantity(value, what, error, of = value) {
  const { unit, factor } = shownAs(what, of);
  return { number: factor * value, error: error === undefined ? undefined : factor * error, unit: unit && ` ${unit}` };
}
// TOML of plain data: numbers, texts, truth values, lists, tables.
function toml(settings) {
  const key = (k) => (/^[\w-]+$/.test(k) ? k : JSON.stringify(k));
  const isTable = (v) => typeof v === "object" && v !== null && !Array.isArray(v);
  const value = (v) => Array.isArray(v) ? `[${v.map(value).join(", ")}]`
    : isTable(v) ? `{ ${Object.entries(v).filter(([, x]) => x !== null).map(([k, x]) => `${key(k)} = ${value(x)}`).join(", ")} }`
      : JSON.stringify(v);
  const lines = [], tables = [];
  for (const [k, v] of Object.entries(settings)) {
    if (v === null) continue;
    if (!isTable(v)) { lines.push(`${key(k)} = ${value(v)}`); continue; }
    const nested = k === "units" ? Object.entries(v).map(([unit, x]) => [`units.${key(unit)}`, x]) : [[key(k), v]];
    for (const [name, table] of nested) {
      tables.push("", `[${name}]`, ...Object.entries(table).filter(([, x]) => x !== null).map(([n, x]) => `${key(n)} = ${value(x)}`));
    }
  }
  return [...lines, ...tables].join("\n") + "\n";
}
