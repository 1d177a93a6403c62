// Texts whose contrast with what is behind them is below AA of WCAG 2.2: 4.5, or 3 for large letters. Figures of Plotly are left out.
() => {
  const parse = (c) => { const v = c.match(/[\d.]+/g).map(Number); return [v[0], v[1], v[2], v.length > 3 ? v[3] : 1]; };
  const over = (a, b) => a.slice(0, 3).map((v, k) => v * a[3] + b[k] * (1 - a[3])).concat(1);
  const light = (c) => { const [r, g, b] = c.map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4)); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const paper = (e) => { const layers = []; for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if (c[3] > 0) layers.push(c); if (c[3] === 1) break; }
    return layers.reverse().reduce((below, c) => over(c, below), [255, 255, 255, 1]); };
  const bad = new Map();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const e = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || !e.checkVisibility({ visibilityProperty: true }) || e.closest("script, style, title, desc, .plot, iframe, option")) continue;
    const style = getComputedStyle(e), svg = e instanceof SVGElement;
    if (svg && style.fill === "none") continue;
    let ink = parse(svg ? style.fill : style.color); ink[3] *= +style.opacity;
    const below = paper(svg ? e.closest("svg").parentElement : e);
    const [a, b] = [light(over(ink, below)), light(below)].sort((x, y) => y - x), ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize), least = size >= 24 || (size >= 18.66 && +style.fontWeight >= 700) ? 3 : 4.5;
    if (ratio < least) bad.set(`${e.tagName.toLowerCase()}.${e.getAttribute("class") ?? ""} in ${e.parentElement.getAttribute("class") ?? ""}`, [ratio.toFixed(2), walker.currentNode.data.trim().slice(0, 20), svg ? style.fill : style.color]);
  }
  return [...bad].map(([k, v]) => `${k}: ${v.join(" ")}`);
}
