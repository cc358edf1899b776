// Shows one articulated mesh after the other; what is decided goes to the server, where there is one, else into a
// review.json.
(function () {
"use strict";
const { byId, make, say } = review;
const facts = JSON.parse(byId("data").textContent);
const store = "casa-assets review " + facts.digest;
let now = {};
let at = 0, part = 0;
let merging = "";
let written = true;
const undone = [];

function begin() {
  facts.rows.forEach(function (row) { now[row.sha256] = row.decisions; });
  if (facts.served) { return; }
  try { now = Object.assign(now, JSON.parse(window.localStorage.getItem(store) || "{}")); } catch (error) { /* none is kept */ }
}

function row() { return facts.rows[at]; }

function said() { return now[row().sha256] || {}; }

// The parts that were told, then those that an earlier run took away.
function partsOf(one) {
  const told = one.parts.map(function (p) { return p.name; });
  const others = Object.keys(said().parts || {}).filter(function (name) { return !told.includes(name); });
  return one.parts.concat(others.map(function (name) { return { name: name, kind: "", edge: "", on: "", reason: "" }; }));
}

function decide(changed, message) {
  if (!row().sha256) { say("the file could not be read: nothing can be decided about it", "bad"); return; }
  undone.push([at, part, row().sha256, said()]);
  put(row().sha256, changed);
  say(message, "good");
}

function put(sha256, changed) {
  now[sha256] = changed;
  show();
  if (facts.served) { send(sha256, changed); return; }
  written = false;
  try { window.localStorage.setItem(store, JSON.stringify(now)); } catch (error) { /* the page has to stay open */ }
}

function send(sha256, changed) {
  const body = JSON.stringify({ sha256: sha256, decisions: changed });
  fetch("decide_articulated", { method: "POST", body: body }).then(function (answer) {
    return answer.text().then(function (text) { if (!answer.ok) { say(text, "bad"); } });
  }).catch(function () { say("not saved: `casa-assets review` has ended; start it again", "bad"); });
}

function undo() {
  const last = undone.pop();
  if (!last) { say("there is nothing to undo"); return; }
  at = last[0];
  part = last[1];
  put(last[2], last[3]);
  say("undone");
}

function picture(corner, title) {
  const node = make("div", { "class": "cell", role: "img", "aria-label": title, title: title });
  node.style.width = node.style.height = facts.cell_px + "px";
  node.style.backgroundImage = "url(" + JSON.stringify(row().strip) + ")";
  node.style.backgroundPosition = -corner[0] + "px " + -corner[1] + "px";
  return node;
}

function pictures(one, chosen) {
  if (!one.strip) {
    return make("div", {}, one.picture ? make("img", { src: one.picture, alt: "Picture of " + one.name }) : null);
  }
  const cells = ["closed", "parts", "taken apart"].map(function (name) { return picture(one.corners[name], name); });
  if (chosen && chosen.corner) { cells.splice(1, 0, picture(chosen.corner, chosen.name + ", open")); }
  return make("div", {}, ...cells);
}

function partRow(told, number) {
  const state = decisions.stateOf(said(), told.name, told);
  const taken = state.gone ? "removed" : state.merged ? "a piece of " + state.merged : "";
  const changed = (said().parts || {})[told.name] !== undefined;
  const joint = (state.edge ? state.edge : told.joint || "") + (state.flipped ? ", the other way" : "");
  const line = make("tr", { "class": (number === part ? "here " : "") + (taken ? "gone " : "") + (changed ? "changed" : "") });
  const name = make("td", { text: number + " " + told.name });
  if (told.color) {
    const dot = make("span", { "class": "dot" });
    dot.style.background = told.color;
    name.prepend(dot);
  }
  line.append(name, make("td", { text: taken || state.kind }), make("td", { text: joint }), make("td", { text: told.on }),
    make("td", { text: told.confidence === undefined ? "" : Math.round(100 * told.confidence) + " %" }),
    make("td", { text: told.runner_up || "" }), make("td", { text: told.reason }), make("td", { text: told.goes || "" }));
  line.addEventListener("click", function () { part = number; show(); });
  return line;
}

function field(name, label, list) {
  const input = make("input", { id: name, autocomplete: "off", spellcheck: "false", placeholder: "as guessed" });
  if (list) { input.setAttribute("list", list); }
  input.value = said()[name] === undefined ? "" : said()[name];
  input.addEventListener("change", function () {
    const word = input.value.trim();
    const number = Number(word.replace(",", "."));
    if (name === "size_m" && word && !(number > 0)) { say(word + " is no length in metres", "bad"); return; }
    decide(decisions.withValue(said(), name, name === "size_m" && word ? number : word), label + ": " + (word || "as guessed"));
  });
  return [make("label", { "for": name, text: label }), input];
}

function show() {
  const one = row(), parts = partsOf(one);
  part = Math.min(part, Math.max(parts.length - 1, 0));
  const table = review.tableOf(["part", "type", "joint", "on", "sure", "else", "why", "goes"]);
  parts.forEach(function (told, number) { table.append(partRow(told, number)); });
  const status = said().decision ? said().decision + "ed by you" : one.status;
  const heading = make("div", {}, make("b", { text: status }), one.code ? make("span", { "class": "code", text: " " + one.code }) : null,
    " " + [one.message].concat(one.to_decide).filter(Boolean).join("; "));
  const words = make("form", {}, ...field("category", "Kind", "kinds"), ...field("up", "Axis of the file that is up", "axes"),
    ...field("front", "Axis of the file that is the front", "axes"), ...field("size_m", "Longest side, metres"));
  words.addEventListener("submit", function (event) { event.preventDefault(); document.activeElement.blur(); });
  const link = one.link ? make("a", { href: one.link, text: one.name }) : one.name;
  const right = make("div", {}, make("h3", {}, link), heading, make("div", { text: one.summary }), table, words);
  byId("now").replaceChildren(pictures(one, parts[part]), right);
  const open = facts.rows.filter(function (r) { return JSON.stringify(now[r.sha256]) !== JSON.stringify(r.decisions); }).length;
  byId("place").textContent = (at + 1) + " of " + facts.rows.length + (open ? ", " + open + " changed" : "");
}

function go(step) {
  at = Math.min(Math.max(at + step, 0), facts.rows.length - 1);
  part = 0;
  merging = "";
  show();
}

function goPart(step) {
  const count = partsOf(row()).length;
  if (count) { part = (part + step + count) % count; show(); }
}

function chosen() { return partsOf(row())[part]; }

function onPart(action) {
  return function () {
    if (!chosen()) { say("nothing moves in this one"); return; }
    if (chosen().added) { say("it came with an interior that was built; decisions.yaml beside the model leaves that out", "bad"); return; }
    action(chosen());
  };
}

function merge(told) {
  if (!merging) {
    merging = told.name;
    say("choose with n and p what " + merging + " is a piece of, then g again; Esc leaves it");
    return;
  }
  const changed = decisions.merged(said(), merging, told.name);
  if (changed === null) { say(merging + " cannot be a piece of itself", "bad"); } else { decide(changed, merging + " is a piece of " + told.name); }
  merging = "";
}

function write() {
  if (facts.served) { say("everything is in review.json of the library already", "good"); return; }
  const text = decisions.fileOf(facts.rows, now);
  const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "application/json" })), download: "review.json" });
  link.click();
  written = true;
  say("written: review.json, where your browser puts files; then run the command below", "good");
}

function asKind(kind) {
  return onPart(function (told) { decide(decisions.withKind(said(), told, kind), told.name + ": " + kind); });
}

const actions = {
  j: function () { go(1); },
  k: function () { go(-1); },
  n: function () { goPart(1); },
  p: function () { goPart(-1); },
  h: onPart(function (told) {
    const kind = decisions.stateOf(said(), told.name, told).kind;
    if (kind !== "door" && kind !== "lid") { say("only doors and lids have a hinge along an edge"); return; }
    decide(decisions.nextHinge(said(), told, facts.edges), told.name + ": another hinge");
  }),
  t: onPart(function (told) { decide(decisions.nextKind(said(), told, facts.kinds), told.name + ": another type"); }),
  f: onPart(function (told) { decide(decisions.flipped(said(), told.name), told.name + ": the other way"); }),
  g: onPart(merge),
  r: onPart(function (told) { decide(decisions.removed(said(), told.name), told.name + ": removed, or there again"); }),
  a: function () { decide(decisions.withValue(said(), "decision", "accept"), "accepted"); go(1); },
  x: function () { decide(decisions.withValue(said(), "decision", "reject"), "rejected"); go(1); },
  u: function () {
    const next = (facts.axes.indexOf(said().up || "") + 1) % (facts.axes.length + 1);
    decide(decisions.withValue(said(), "up", facts.axes[next] || ""), "up: " + (facts.axes[next] || "as guessed"));
  },
  c: function () { byId("category").focus(); },
  s: function () { byId("size_m").focus(); },
  z: undo,
  w: write,
  Escape: function () { merging = ""; say(""); },
};
actions.ArrowDown = actions.n;
actions.ArrowUp = actions.p;
facts.kinds.concat(["none"]).slice(0, 9).forEach(function (kind, i) { actions[String(i + 1)] = asKind(kind); });
review.onKeys(actions);
window.addEventListener("beforeunload", function (event) { if (!written) { event.preventDefault(); } });

[["kinds", facts.categories], ["axes", facts.axes]].forEach(function (list) {
  document.body.append(make("datalist", { id: list[0] }, ...list[1].map(function (word) { return make("option", { value: word }); })));
});
begin();
if (facts.rows.length) { show(); }
})();
