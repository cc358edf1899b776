// Shows one input after the other and sends what is decided. Text only ever becomes text nodes, never markup.
(function () {
"use strict";
const facts = JSON.parse(document.getElementById("data").textContent);
const byId = function (id) { return document.getElementById(id); };
let at = 0;

function make(tag, attributes) {
  const node = document.createElement(tag);
  Object.keys(attributes || {}).forEach(function (key) {
    if (key === "text") { node.textContent = attributes[key]; } else { node.setAttribute(key, attributes[key]); }
  });
  for (let i = 2; i < arguments.length; i++) { if (arguments[i]) { node.append(arguments[i]); } }
  return node;
}

function say(text, kind) { byId("said").textContent = text; byId("said").className = kind || ""; }

function field(row, name, label, options) {
  const input = options
    ? make("select", { id: name }, ...[""].concat(options).map(function (o) { return make("option", { value: o, text: o || "as guessed" }); }))
    : make("input", { id: name, autocomplete: "off", spellcheck: "false" });
  if (name === "category") { input.setAttribute("list", "kinds"); }
  input.value = row.set[name];
  return [make("label", { "for": name, text: label }), input];
}

function show() {
  const row = facts.rows[at];
  const table = make("table", {}, make("tr", {}, ...["", "guess", "sure", "why"].map(function (h) { return make("th", { text: h }); })));
  row.guesses.forEach(function (g) {
    const doubted = row.decide.includes(g[0]);
    table.append(make("tr", {}, make("td", { text: g[0], "class": doubted ? "doubt" : "" }), make("td", { text: g[1] }),
      make("td", { text: Math.round(100 * g[2]) + " %" }), make("td", { text: g[3] })));
  });
  const size = row.size_m.map(function (v) { return (100 * v).toFixed(1); }).join(" × ");
  const facts_line = row.rejected || row.category + ", " + size + " cm, " + Number(row.mass_kg.toPrecision(3)) + " kg";
  const form = make("form", { id: "words" },
    ...field(row, "decision", "Decision", ["accept", "reject"]),
    ...field(row, "category", "Kind"),
    ...field(row, "up", "Axis of the file that is up", facts.ups),
    ...field(row, "turn_deg", "Turn about z, degrees"),
    ...field(row, "size_m", "Longest side, metres"),
    ...field(row, "mass_kg", "Mass, kilograms"));
  form.addEventListener("submit", function (event) { event.preventDefault(); save(); });
  form.append(make("button", { type: "submit", "class": "quiet", text: "Save" }));
  const picture = make("img", { src: row.number, alt: "Picture of " + row.id });
  const right = make("div", {}, make("h3", { text: row.id }), make("div", { text: row.input }), make("div", { text: facts_line }), table, form);
  byId("now").replaceChildren(make("div", {}, picture), right);
  byId("place").textContent = (at + 1) + " of " + facts.rows.length;
}

function save(decision) {
  const row = facts.rows[at];
  if (decision) { byId("decision").value = decision; }
  const words = { sha256: row.sha256 };
  Object.keys(row.set).forEach(function (name) { words[name] = byId(name).value.trim(); });
  fetch("decide", { method: "POST", body: JSON.stringify(words) }).then(function (answer) {
    return answer.text().then(function (text) {
      if (!answer.ok) { say(text, "bad"); return; }
      Object.keys(row.set).forEach(function (name) { row.set[name] = words[name]; });
      say("saved: " + row.id, "good");
      go(1);
    });
  }).catch(function () { say("not saved: `casa-assets review` has ended; start it again", "bad"); });
}

function go(step) {
  at = Math.min(Math.max(at + step, 0), facts.rows.length - 1);
  show();
}

document.addEventListener("keydown", function (event) {
  const inside = /^(INPUT|SELECT)$/.test(document.activeElement.tagName);
  if (event.key === "Escape") { document.activeElement.blur(); return; }
  if (inside || event.ctrlKey || event.metaKey || event.altKey) { return; }
  const focus = { c: "category", s: "size_m", m: "mass_kg" }[event.key];
  if (event.key === "a") { save("accept"); }
  else if (event.key === "x") { save("reject"); }
  else if (event.key === "j") { go(1); }
  else if (event.key === "k") { go(-1); }
  else if (event.key === "u") { const up = byId("up"); up.selectedIndex = (up.selectedIndex + 1) % up.options.length; }
  else if (event.key === "Enter") { save(); }
  else if (focus) { byId(focus).focus(); }
  else { return; }
  event.preventDefault();
});

const kinds = make("datalist", { id: "kinds" }, ...facts.categories.map(function (name) { return make("option", { value: name }); }));
document.body.append(kinds);
show();
})();
