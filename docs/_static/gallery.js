// Search and subjects above the cards of the gallery; without scripts all cards are there.
const grid = document.querySelector(".examples"), cards = [...grid.children];
const chosen = new Set();

const make = (tag, fields, ...children) => {
  const node = Object.assign(document.createElement(tag), fields);
  node.append(...children);
  return node;
};
const search = make("input", { type: "search", placeholder: "Search: four-bar, clearance, cam ..." });
search.setAttribute("aria-label", "Search the examples");
const count = make("span", { className: "count" });
count.setAttribute("role", "status");

function show() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  for (const card of cards) {
    const about = card.dataset.subjects.split(";"), text = `${card.textContent} ${about.join(" ")}`.toLowerCase();
    card.hidden = !(words.every((word) => text.includes(word)) && [...chosen].every((one) => about.includes(one)));
  }
  const left = cards.filter((card) => !card.hidden).length;
  count.textContent = left < cards.length ? `${left} of ${cards.length}` : `${cards.length} examples`;
}

const subjects = grid.dataset.subjects.split(";").map((name) => {
  const one = make("button", { type: "button", textContent: name });
  one.setAttribute("aria-pressed", "false");
  one.addEventListener("click", () => {
    if (!chosen.delete(name)) chosen.add(name);
    one.setAttribute("aria-pressed", String(chosen.has(name)));
    show();
  });
  return one;
});
search.addEventListener("input", show);
grid.before(make("div", { className: "find" }, search, count, make("div", { className: "subjects" }, ...subjects)));
show();
