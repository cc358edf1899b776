// Shows one input after the other and sends what is decided.
(function () {
"use strict";
const { byId, make, say, percent } = review;
const facts = JSON.parse(byId("data").textContent);
let at = 0;

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
  const table = review.tableOf(["", "guess", "sure", "why"]);
  row.guesses.forEach(function (g) {
    const doubted = row.decide.includes(g[0]);
    table.append(make("tr", {}, make("td", { text: g[0], "class": doubted ? "doubt" : "" }), make("td", { text: g[1] }),
      make("td", { text: percent(g[2]), "class": "share" }), make("td", { text: g[3] })));
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
  const right = make("div", {}, make("h3", { text: row.id }), make("div", { text: row.input }), make("div", { text: facts_line }), make("div", { "class": "scroll" }, table), form);
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

review.onKeys({
  a: function () { save("accept"); },
  x: function () { save("reject"); },
  j: function () { go(1); },
  k: function () { go(-1); },
  u: function () { const up = byId("up"); up.selectedIndex = (up.selectedIndex + 1) % up.options.length; },
  c: function () { byId("category").focus(); },
  s: function () { byId("size_m").focus(); },
  m: function () { byId("mass_kg").focus(); },
  Enter: function () { save(); },
});

const kinds = make("datalist", { id: "kinds" }, ...facts.categories.map(function (name) { return make("option", { value: name }); }));
document.body.append(kinds);
show();
})();
