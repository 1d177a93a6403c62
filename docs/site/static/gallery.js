// Choices above the gallery. Without scripts all cards are there, and no choices.
(() => {
  const form = document.querySelector(".gallery-filter");
  const cards = [...document.querySelectorAll("ul.gallery > li")];
  if (!form) return;
  const of = {
    system: (card) => [card.parentElement.dataset.system],
    effect: (card) => card.dataset.effects.split(" "),
    figure: (card) => card.dataset.figures.split("|"),
  };
  const names = (values) => [...new Set(values)].filter(Boolean).sort((a, b) => a.localeCompare(b));
  const field = (label, control) => {
    const box = document.createElement("label");
    box.append(label, control);
    form.append(box);
    return control;
  };
  const fields = Object.fromEntries(Object.keys(of).map((key) => {
    const select = document.createElement("select");
    select.append(new Option("all", ""));
    names(cards.flatMap(of[key])).forEach((name) => select.append(new Option(name.replaceAll("_", " "), name)));
    return [key, field(key, select)];
  }));
  const text = field("words", Object.assign(document.createElement("input"), { type: "search" }));
  const count = document.createElement("output");
  form.append(count);
  const show = () => {
    const words = text.value.toLowerCase().split(/\s+/);
    for (const card of cards) {
      const whole = card.querySelector("a > strong").textContent + " " + card.querySelector("a > strong + span").textContent;
      card.hidden = !(Object.keys(of).every((key) => !fields[key].value || of[key](card).includes(fields[key].value))
        && words.every((word) => whole.toLowerCase().includes(word)));
    }
    for (const list of document.querySelectorAll("ul.gallery")) {
      const none = [...list.children].every((card) => card.hidden);
      (list.closest("section") ?? list).hidden = none;
    }
    count.value = `${cards.filter((card) => !card.hidden).length} of ${cards.length} scenes`;
  };
  form.addEventListener("input", show);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.hidden = false;
  show();
})();
