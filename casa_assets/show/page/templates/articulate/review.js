// Shows one articulated mesh after the other; what is decided goes to the server, where there is one, else into a
// review.json.
(function () {
"use strict";
const { byId, make, say, percent } = review;
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

// One picture of the strip, as wide as its place.
function picture(corner, title) {
  const node = make("div", { "class": "cell", role: "img", "aria-label": title, title: title });
  const share = function (i) { const rest = row().strip_px[i] - facts.cell_px; return rest ? 100 * corner[i] / rest : 0; };
  node.style.backgroundImage = "url(" + JSON.stringify(row().strip) + ")";
  node.style.backgroundSize = 100 * row().strip_px[0] / facts.cell_px + "% auto";
  node.style.backgroundPosition = share(0) + "% " + share(1) + "%";
  return node;
}

// What is seen of the mesh: a large picture, or the model in 3D once somebody has asked for it; small ones below.
const stage = { at: -1, node: null, viewer: null, in3d: false };

function showPictures(one, told) {
  if (stage.at !== at) {
    if (stage.viewer) { stage.viewer.dispose(); }
    Object.assign(stage, { at: at, viewer: null, node: make("div", { "class": "stage" }) });
    const closed = one.picture ? make("img", { src: one.picture, alt: "Picture of " + one.name })
      : one.strip ? picture(one.corners.closed, "closed") : null;
    if (closed) { stage.node.append(closed); }
    if (one.model) {
      const button = make("button", { type: "button", "class": "quiet stage-open", text: "Open in 3D" });
      button.addEventListener("click", openModel);
      stage.node.append(button);
      if (stage.in3d) { openModel(); }
    }
    byId("stage").replaceChildren(...(closed || one.model ? [stage.node] : []));
  }
  const cells = one.strip ? ["parts", "taken apart"].map(function (name) { return picture(one.corners[name], name); }) : [];
  if (told && told.corner) { cells.unshift(picture(told.corner, told.name + ", open")); }
  byId("cells").replaceChildren(...cells);
}

function openModel() {
  const one = row(), number = at, node = stage.node, button = node.children[node.children.length - 1];
  stage.in3d = true;
  button.textContent = "Loading …";
  loadViewer(one.model.viewer)
    .then(function () { return casaViewer.loadModel(one.model.script, one.model.name); })
    .then(function (bytes) { return casaViewer.mount(node, bytes, { title: one.name, panel: false }); })
    .then(function (viewer) {
      if (stage.at !== number) { viewer.dispose(); return; } // another mesh is shown by now
      stage.viewer = viewer;
      viewer.onPick(function (found) {
        const picked = found && found.joint ? one.parts.findIndex(function (p) { return p.joint_name === found.joint; }) : -1;
        if (picked >= 0 && picked !== part) { part = picked; show(); }
      });
    })
    .catch(function (error) {
      button.textContent = "Open in 3D";
      say("the model cannot be shown: " + error.message, "bad");
    });
}

// Opens the chosen part in 3D and closes the others.
function openChosen() {
  const told = chosen();
  (stage.viewer ? stage.viewer.jointFacts() : []).forEach(function (joint) {
    const position = told && joint.name === told.joint_name ? joint.open : joint.closed;
    if (position !== joint.position) { stage.viewer.setJoint(joint.name, position, { animate: true }); }
  });
}

function partRow(told, number) {
  const state = decisions.stateOf(said(), told.name, told);
  const taken = state.gone ? "removed" : state.merged ? "a piece of " + state.merged : "";
  const changed = (said().parts || {})[told.name] !== undefined;
  const joint = (state.edge ? state.edge : told.joint || "") + (state.flipped ? ", the other way" : "");
  const line = make("tr", { "class": (number === part ? "here " : "") + (taken ? "gone " : "") + (changed ? "changed" : "") });
  const name = make("td", { text: told.name, "class": "name" });
  if (told.color) {
    const dot = make("span", { "class": "dot" });
    dot.style.background = told.color;
    name.prepend(dot);
  }
  line.append(name, make("td", { text: taken || state.kind }), make("td", { text: joint, "class": "joint" }), make("td", { text: told.on }),
    make("td", { text: told.confidence === undefined ? "" : percent(told.confidence), "class": "share" }),
    make("td", { text: told.runner_up || "" }), make("td", { text: told.reason, "class": "why" }), make("td", { text: told.goes || "" }));
  line.addEventListener("click", function () { choose(number); });
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
  byId("told").replaceChildren(make("h3", {}, link), heading, make("div", { text: one.summary }));
  byId("parts").replaceChildren(...(parts.length ? [table] : []));
  byId("words").replaceChildren(words);
  byId("chosen").textContent = parts[part] ? parts[part].name : "no moving part";
  byId("kind").disabled = !parts[part] || parts[part].added === true;
  byId("kind").value = parts[part] ? kindOf(parts[part]) : "";
  showPictures(one, parts[part]);
  const open = facts.rows.filter(function (r) { return JSON.stringify(now[r.sha256]) !== JSON.stringify(r.decisions); }).length;
  byId("place").textContent = (at + 1) + " of " + facts.rows.length + (open ? ", " + open + " changed" : "");
}

function go(step) {
  at = Math.min(Math.max(at + step, 0), facts.rows.length - 1);
  part = 0;
  merging = "";
  show();
}

function choose(number) {
  part = number;
  show();
  openChosen();
}

function goPart(step) {
  const count = partsOf(row()).length;
  if (count) { choose((part + step + count) % count); }
}

// The type of a part as it is now; `none` for one that was removed.
function kindOf(told) {
  const state = decisions.stateOf(said(), told.name, told);
  return state.gone ? "none" : state.kind;
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
    say("choose the part that " + merging + " is a piece of, then press g or the button again; Esc leaves it");
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
byId("kind").append(...facts.kinds.concat(["none"]).map(function (kind) { return make("option", { value: kind, text: kind }); }));
byId("kind").addEventListener("change", function () { asKind(byId("kind").value)(); byId("kind").blur(); });
window.addEventListener("beforeunload", function (event) { if (!written) { event.preventDefault(); } });

[["kinds", facts.categories], ["axes", facts.axes]].forEach(function (list) {
  document.body.append(make("datalist", { id: list[0] }, ...list[1].map(function (word) { return make("option", { value: word }); })));
});
begin();
if (facts.rows.length) { show(); }
})();
