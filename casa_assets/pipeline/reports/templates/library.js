// Draws the lists from the facts embedded in the page. Text only ever becomes text nodes, never markup.
(function () {
"use strict";
const facts = JSON.parse(document.getElementById("data").textContent);
const byId = function (id) { return document.getElementById(id); };
const STEP = 120;
const state = {
  tab: "assets", text: "", warned: false, category: "", code: "", gallery: false,
  sort: { assets: ["category", 1], rejects: ["path", 1] }
};

function make(tag, attributes) {
  const node = document.createElement(tag);
  Object.keys(attributes || {}).forEach(function (key) {
    if (key === "text") { node.textContent = attributes[key]; }
    else if (key === "click") { node.addEventListener("click", attributes[key]); }
    else { node.setAttribute(key, attributes[key]); }
  });
  for (let i = 2; i < arguments.length; i++) { if (arguments[i]) { node.append(arguments[i]); } }
  return node;
}

function show(number) {
  if (number === null || number === undefined) { return "–"; }
  if (number === 0) { return "0"; }
  const size = Math.abs(number);
  if (size >= 1e6 || size < 1e-3) { return number.toExponential(2); }
  if (size >= 1000) { return Math.round(number).toLocaleString("en"); }
  return String(Number(number.toPrecision(3)));
}
function mass(kg) { return kg < 0.1 ? show(1000 * kg) + " g" : show(kg) + " kg"; }
function size(cm) { return cm.map(function (v) { return v >= 100 ? v.toFixed(0) : v.toFixed(1); }).join(" × "); }
// Status of a check: 0 failed, 1 passed, 2 does not apply, 3 was not run.
function passed(asset) { return asset.results.filter(function (r) { return r[1] === 1; }).length; }
function applying(asset) { return asset.results.filter(function (r) { return r[1] !== 2; }).length; }

// Columns: key, heading, what to sort by, whether it is a number.
const COLUMNS = {
  assets: [
    ["picture", "Picture"],
    ["id", "Asset", function (a) { return a.id; }],
    ["category", "Category", function (a) { return a.category; }],
    ["size", "Size (cm)", function (a) { return Math.max.apply(null, a.size); }, true],
    ["mass", "Mass", function (a) { return a.mass; }, true],
    ["colliders", "Colliders", function (a) { return a.colliders; }, true],
    ["faces", "Faces", function (a) { return a.faces; }, true],
    ["source", "Source", function (a) { return a.source + "/" + a.path; }],
    ["licence", "Licence", function (a) { return a.licence; }],
    ["warnings", "Warnings", function (a) { return a.warnings.length; }, true],
    ["checks", "Checks", function (a) { return applying(a) ? passed(a) / applying(a) : 0; }, true]
  ],
  rejects: [
    ["picture", "Picture"],
    ["path", "Input", function (r) { return r.path; }],
    ["category", "Category", function (r) { return r.category; }],
    ["code", "Code", function (r) { return r.code; }],
    ["reason", "What is wrong, and what to do", function (r) { return r.reason; }]
  ]
};

facts.assets.forEach(function (a) {
  a.words = [a.id, a.category, a.title, a.author, a.path, a.source, a.licence]
    .concat(a.warnings.map(function (w) { return w.join(" "); })).join(" ").toLowerCase();
});
facts.rejects.forEach(function (r) {
  r.words = [r.path, r.category, r.code, r.meaning, r.reason, r.fix, r.source].join(" ").toLowerCase();
});

function chosen() {
  const words = state.text.toLowerCase().split(/\s+/).filter(Boolean);
  const rows = facts[state.tab].filter(function (row) {
    return words.every(function (w) { return row.words.includes(w); })
      && (!state.category || row.category === state.category)
      && (state.tab === "assets" ? !state.warned || row.warnings.length : !state.code || row.code === state.code);
  });
  const order = state.sort[state.tab];
  const value = COLUMNS[state.tab].find(function (c) { return c[0] === order[0]; })[2];
  const keyed = rows.map(function (row) { return [value(row), row]; });
  keyed.sort(function (a, b) {
    const ahead = typeof a[0] === "number" ? a[0] - b[0] : a[0] < b[0] ? -1 : a[0] > b[0] ? 1 : 0;
    // Equal rows keep the order of their names whichever way the column runs.
    return order[1] * ahead || ((a[1].id || a[1].path) < (b[1].id || b[1].path) ? -1 : 1);
  });
  return keyed.map(function (pair) { return pair[1]; });
}

function picture(row) {
  return row.thumb
    ? make("img", { "class": "thumb", src: row.thumb, alt: "", width: 80, height: 80, decoding: "async" })
    : make("span", { "class": "thumb none", text: "no picture" });
}
function cell(text, kind) { return make("td", { text: text, "class": kind || "" }); }

function assetRow(a) {
  const good = passed(a);
  const name = make("td", {}, make("div", { "class": "id", text: a.id }));
  if (a.title) { name.append(make("div", { "class": "small", text: a.title })); }
  if (a.decide.length) { name.append(make("span", { "class": "badge warn", text: "in review: " + a.decide.join(", ") })); }
  const source = make("td", {}, make("div", { text: a.source }), make("div", { "class": "small path", text: a.path.split("/").pop(), title: a.path }));
  const warnings = make("td", { "class": "number" });
  warnings.append(a.warnings.length ? make("span", { "class": "badge warn", text: String(a.warnings.length) }) : "0");
  const button = make("button", {
    type: "button", "class": "open", "aria-expanded": "false", "aria-label": "Details of " + a.id,
    text: good + " of " + applying(a), title: good + " of " + applying(a) + " that apply passed", click: function () { toggle(row, a, button); }
  });
  button.classList.toggle("warn-text", good < applying(a));
  const row = make("tr", { "class": "row" },
    make("td", { "class": "picture" }, picture(a)), name, cell(a.category), cell(size(a.size), "number"),
    cell(mass(a.mass), "number"), cell(show(a.colliders), "number"), cell(show(a.faces), "number"), source,
    cell(a.licence, "licence"), warnings, make("td", { "class": "number" }, button));
  return row;
}

function toggle(row, asset, button) {
  const next = row.nextElementSibling;
  const open = next && next.classList.contains("more");
  button.setAttribute("aria-expanded", String(!open));
  if (open) { next.remove(); return; }
  const wide = make("td", { colspan: COLUMNS.assets.length }, detail(asset));
  row.after(make("tr", { "class": "more" }, wide));
}

function large(a) {
  if (!a.large && !a.thumb) { return make("span", { "class": "none thumb", text: "no picture" }); }
  const image = make("img", { src: a.large || a.thumb, alt: "Picture of " + a.id, width: 300, height: 300 });
  // The page may have been moved away from its library: then the small picture has to do.
  image.addEventListener("error", function () { if (a.thumb && image.src !== a.thumb) { image.src = a.thumb; } });
  return image;
}

function list(heading, lines) {
  if (!lines.length) { return null; }
  return make("div", {}, make("h3", { text: heading }),
    make("ul", {}, ...lines.map(function (line) { return make("li", { text: line }); })));
}

function detail(a) {
  const terms = make("dl", { "class": "facts" });
  [["Category", a.category], ["Size", size(a.size) + " cm"], ["Mass", mass(a.mass)],
    ["Colliders", a.colliders + (a.hull ? ", at most " + a.hull + " vertices each" : "")],
    ["Faces", show(a.faces)], ["Title", a.title], ["Author", a.author], ["Licence", a.licence],
    ["Source", a.source + ": " + a.path], ["Address", a.uri], ["By its pictures", a.looks]].forEach(function (pair) {
    if (pair[1]) { terms.append(make("dt", { text: pair[0] }), make("dd", { text: pair[1] })); }
  });
  const links = make("div", { "class": "links" }, ...a.files.map(function (file) {
    return make("a", { href: file[1], text: file[0] });
  }));
  const told = a.guesses.map(function (g) {
    return g[0] + ": " + g[1] + " (" + Math.round(100 * g[2]) + " % sure; " + g[3] + ")";
  });
  const warned = a.warnings.map(function (w) { return w[0] + (w[1] ? " at " + w[1] : "") + ": " + w[2]; });
  const middle = make("div", {}, terms, links, list("Warnings", warned), list("Decided without being stated", told));
  return make("div", { "class": "detail" }, large(a), middle, results(a));
}

function results(a) {
  const body = make("tbody");
  a.results.forEach(function (r) {
    const check = facts.checks[r[0]];
    const name = make("td", {}, document.createTextNode(check[0]));
    if (check[2]) { name.append(make("div", { "class": "small", text: check[2] })); }
    const word = [check[3] ? "advice" : "failed", "passed", "does not apply", "not run"][r[1]];
    const kind = [check[3] ? "warn-text" : "bad-text", "good", "small", "warn-text"][r[1]];
    const state = make("td", { "class": kind, text: word });
    if (r[4]) { state.append(make("div", { "class": "small", text: r[4] })); }
    body.append(make("tr", {}, name, state,
      cell(show(r[2]), "number"), cell(show(r[3]), "number"), cell(check[1])));
  });
  const head = make("tr", {}, ...[["Check", ""], ["", ""], ["Measured", "number"], ["Limit", "number"], ["Unit", ""]]
    .map(function (h) { return make("th", { text: h[0], "class": h[1], scope: "col" }); }));
  return make("div", { "class": "results", tabindex: "0", role: "region", "aria-label": "Checks of " + a.id },
    make("table", {}, make("thead", {}, head), body));
}

function rejectRow(r) {
  const code = make("td", {}, make("span", { "class": "badge bad", text: r.code }),
    make("div", { "class": "small", text: r.meaning }));
  const says = make("td", { "class": "says" }, make("p", { text: r.reason }));
  r.failed.forEach(function (f) {
    const check = facts.checks[f[0]];
    const limit = f[2] === null ? "" : ", limit " + show(f[2]);
    says.append(make("p", { "class": "small", text: check[0] + ": " + show(f[1]) + limit + " " + check[1] }));
  });
  if (r.fix) { says.append(make("p", { "class": "small", text: "Fix: " + r.fix })); }
  return make("tr", { "class": "row" }, make("td", { "class": "picture" }, picture(r)),
    make("td", {}, make("div", { "class": "id", text: r.path }), make("div", { "class": "small", text: r.source })),
    cell(r.category || "–"), code, says);
}

function heading(tab) {
  const row = make("tr");
  COLUMNS[tab].forEach(function (column) {
    const kind = { scope: "col", "class": column[3] ? "number" : "" };
    if (!column[2]) { row.append(make("th", kind, make("span", { text: column[1] }))); return; }
    const order = state.sort[tab];
    kind["aria-sort"] = order[0] !== column[0] ? "none" : order[1] > 0 ? "ascending" : "descending";
    row.append(make("th", kind, make("button", { type: "button", text: column[1], "data-key": column[0],
      click: function () {
        const again = state.sort[tab][0] === column[0];
        // Numbers start with the largest, which is what one looks for.
        state.sort[tab] = [column[0], again ? -state.sort[tab][1] : column[3] ? -1 : 1];
        draw();
        document.querySelector('#panel-' + tab + ' [data-key="' + column[0] + '"]').focus();
      } })));
  });
  return make("thead", {}, row);
}

function tile(a) {
  return make("button", { type: "button", click: function () {
    state.gallery = false; state.text = a.id; byId("search").value = a.id; draw();
    const open = document.querySelector("#panel-assets .open");
    if (open) { open.click(); open.focus(); }
  } }, picture(a), make("span", { "class": "id", text: a.id }),
    make("span", { "class": "small", text: size(a.size) + " cm, " + mass(a.mass) }));
}

// Long lists grow as one scrolls.
let watcher = null;
function fill(place, rows, one, sentinelTag) {
  let done = 0;
  const end = make(sentinelTag, { "class": "sentinel" });
  place.append(end);
  function more() {
    const part = document.createDocumentFragment();
    rows.slice(done, done + STEP).forEach(function (row) { part.append(one(row)); });
    done += STEP;
    end.before(part);
    if (done >= rows.length) { watcher.disconnect(); end.remove(); }
  }
  if (watcher) { watcher.disconnect(); }
  watcher = new IntersectionObserver(function (seen) {
    if (seen.some(function (s) { return s.isIntersecting; })) { more(); watcher.unobserve(end); watcher.observe(end); }
  }, { rootMargin: "1200px" });
  more();
  if (done < rows.length) { watcher.observe(end); }
}

function draw() {
  const rows = chosen();
  const panel = byId("panel-" + state.tab);
  panel.replaceChildren();
  if (!rows.length) {
    const all = facts[state.tab].length;
    panel.append(make("p", { "class": "empty", text: all ? "Nothing matches. Take a filter away." : "There is nothing here." }));
  } else if (state.tab === "assets" && state.gallery) {
    const place = make("div", { "class": "gallery" });
    panel.append(place);
    fill(place, rows, tile, "div");
  } else {
    const body = make("tbody");
    panel.append(make("div", { "class": "sheet" }, make("table", {}, heading(state.tab), body)));
    fill(body, rows, state.tab === "assets" ? assetRow : rejectRow, "tr");
  }
  ["assets", "rejects"].forEach(function (tab) {
    const on = tab === state.tab;
    byId("panel-" + tab).hidden = !on;
    byId("tab-" + tab).setAttribute("aria-selected", String(on));
    byId("tab-" + tab).tabIndex = on ? 0 : -1;
  });
  const whole = facts[state.tab].length;
  byId("shown").textContent = rows.length === whole ? whole + " shown" : rows.length + " of " + whole + " shown";
  byId("layout").setAttribute("aria-pressed", String(state.gallery));
  byId("layout").hidden = byId("only-warned").hidden = state.tab !== "assets";
  chips();
}

function chips() {
  const place = byId("chips");
  place.replaceChildren();
  [["category", "category: "], ["code", "reason: "]].forEach(function (kind) {
    const value = state[kind[0]];
    if (!value || (kind[0] === "code" && state.tab !== "rejects")) { return; }
    place.append(make("button", { type: "button", text: kind[1] + value + "  ×", "aria-label": "Remove filter " + kind[1] + value,
      click: function () { pick(kind[0], value); } }));
  });
  document.querySelectorAll(".bars button").forEach(function (bar) {
    bar.setAttribute("aria-pressed", String(state[bar.dataset.kind] === bar.dataset.value));
  });
}

function pick(kind, value) {
  state[kind] = state[kind] === value ? "" : value;
  if (state[kind]) { state.tab = kind === "code" ? "rejects" : "assets"; }
  draw();
}

function bars(place, kind, rows, label) {
  const counts = new Map();
  rows.forEach(function (row) { counts.set(row[kind], (counts.get(row[kind]) || 0) + 1); });
  const sorted = Array.from(counts).sort(function (a, b) { return b[1] - a[1] || (a[0] < b[0] ? -1 : 1); });
  if (!sorted.length) { place.append(make("p", { "class": "small", text: "None." })); }
  sorted.forEach(function (pair) {
    const fill = make("i");
    fill.style.width = 100 * pair[1] / sorted[0][1] + "%";
    place.append(make("button", { type: "button", "aria-pressed": "false", "data-kind": kind, "data-value": pair[0],
      title: label.title(pair[0]), click: function () { pick(kind, pair[0]); } },
      label.node(pair[0]), make("span", { "class": "track" }, fill), make("span", { "class": "number", text: String(pair[1]) })));
  });
}

function start() {
  const meaning = {};
  facts.rejects.forEach(function (r) { meaning[r.code] = r.meaning; });
  bars(byId("categories"), "category", facts.assets, {
    title: function (name) { return name; },
    node: function (name) { return make("span", { "class": "name", text: name }); }
  });
  bars(byId("reasons"), "code", facts.rejects, {
    title: function (code) { return meaning[code]; },
    node: function (code) {
      return make("span", { "class": "name" }, make("code", { text: code }), document.createTextNode(meaning[code]));
    }
  });
  const tabs = ["assets", "rejects"];
  tabs.forEach(function (tab) {
    const button = byId("tab-" + tab);
    button.querySelector("span").textContent = String(facts[tab].length);
    button.addEventListener("click", function () { state.tab = tab; draw(); });
    button.addEventListener("keydown", function (event) {
      if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") { return; }
      state.tab = tab === "assets" ? "rejects" : "assets";
      draw();
      byId("tab-" + state.tab).focus();
    });
  });
  byId("search").addEventListener("input", function (event) { state.text = event.target.value; draw(); });
  byId("warned").addEventListener("change", function (event) { state.warned = event.target.checked; draw(); });
  byId("layout").addEventListener("click", function () { state.gallery = !state.gallery; draw(); });
  byId("theme").addEventListener("click", function () {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
  });
  document.addEventListener("keydown", function (event) {
    if (event.key === "/" && document.activeElement.tagName !== "INPUT") { event.preventDefault(); byId("search").focus(); }
  });
  if (!facts.assets.length && facts.rejects.length) { state.tab = "rejects"; }
  draw();
}
start();
})();
