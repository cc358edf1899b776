// Browses many rows: search, filters, order, a list that draws only what is in sight, details, keys, and an address that
// brings all of it back. Text only ever becomes text nodes, never markup. A page calls `casa.browse` with what is its own.
const casa = (function () {
"use strict";
const byId = function (id) { return document.getElementById(id); };
const facts = JSON.parse(byId("data").textContent);

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
  if (size < 1e-6) { return "below 0.000001"; }
  if (size >= 1000) { return Math.round(number).toLocaleString("en"); }
  return String(Number(number.toPrecision(3)));
}

function browse(page) {
  const rows = facts.rows;
  rows.forEach(function (row, index) { row.index = index; row.words = page.words(row).toLowerCase(); });
  const byKey = new Map(rows.map(function (row) { return [page.key(row), row]; }));
  const state = { tab: page.tabs[0], q: "", chosen: {}, sort: page.sorts[0].key, way: 1, view: page.view, id: "" };
  const start = { sort: state.sort, way: 1, view: state.view, tab: state.tab };
  let found = [];
  let at = -1;           // place in `found` of the row that keys are at
  let columns = 1;
  let height = 1;
  const list = byId("list");
  const block = make("div", { "class": "block" });
  list.append(block);
  const drawn = new Map(); // key -> node
  const opened = {};       // facets of which all values are shown

  // The address -------------------------------------------------------------------------------------------------------
  function address() {
    const words = new URLSearchParams();
    if (state.q) { words.set("q", state.q); }
    page.facets.forEach(function (facet) { (state.chosen[facet.key] || []).forEach(function (v) { words.append(facet.key, v); }); });
    if (state.sort !== start.sort || state.way !== start.way) { words.set("sort", (state.way < 0 ? "-" : "") + state.sort); }
    if (state.view !== start.view) { words.set("view", state.view); }
    if (state.tab !== start.tab) { words.set("tab", state.tab); }
    if (!state.id) { return words.toString(); }
    if (!words.toString()) { return encodeURIComponent(state.id); }
    words.set("id", state.id);
    return words.toString();
  }
  function remember(isStep) {
    const hash = address();
    if (hash === location.hash.slice(1)) { return; }
    const target = hash ? "#" + hash : location.pathname + location.search;
    try { if (isStep) { history.pushState(null, "", target); } else { history.replaceState(null, "", target); } }
    catch (error) { location.hash = hash; } // a browser that lets no file change its history
  }
  function readAddress() {
    const hash = location.hash.slice(1);
    const isQuery = hash.indexOf("=") >= 0;
    const words = new URLSearchParams(isQuery ? hash : "");
    state.q = words.get("q") || "";
    state.chosen = {};
    page.facets.forEach(function (facet) { if (words.has(facet.key)) { state.chosen[facet.key] = words.getAll(facet.key); } });
    const sort = words.get("sort") || start.sort;
    const key = sort.replace(/^-/, "");
    const known = page.sorts.some(function (s) { return s.key === key; });
    state.sort = known ? key : start.sort;
    state.way = known && sort[0] === "-" ? -1 : 1;
    state.view = ["table", "tiles"].indexOf(words.get("view")) >= 0 ? words.get("view") : start.view;
    state.tab = page.tabs.indexOf(words.get("tab")) >= 0 ? words.get("tab") : start.tab;
    if (isQuery) { state.id = words.get("id") || ""; } else { try { state.id = decodeURIComponent(hash); } catch (error) { state.id = hash; } }
    if (state.id === "list") { state.id = ""; }
    byId("search").value = state.q;
  }

  // What is found -----------------------------------------------------------------------------------------------------
  const counts = {};
  function search() {
    const words = state.q.toLowerCase().split(/\s+/).filter(Boolean);
    const facets = page.facets.map(function (facet) {
      counts[facet.key] = new Map();
      return { facet: facet, wanted: state.chosen[facet.key] || [], counts: counts[facet.key] };
    });
    found = [];
    rows.forEach(function (row) {
      if (!words.every(function (w) { return row.words.includes(w); })) { return; }
      let misses = 0;
      let missed = null;
      facets.forEach(function (one) {
        if (!one.wanted.length) { return; }
        const values = one.facet.values(row);
        const has = function (v) { return values.indexOf(v) >= 0; };
        if (!(one.facet.all ? one.wanted.every(has) : one.wanted.some(has))) { misses += 1; missed = one; }
      });
      if (misses > 1) { return; }
      if (misses === 0) { found.push(row); }
      facets.forEach(function (one) {
        // A value counts what choosing it would leave, beside what is chosen in the other filters.
        if (misses && (one !== missed || one.facet.all)) { return; }
        one.facet.values(row).forEach(function (v) { one.counts.set(v, (one.counts.get(v) || 0) + 1); });
      });
    });
    const value = page.sorts.find(function (s) { return s.key === state.sort; }).value;
    const keyed = found.map(function (row) { return [value(row), row]; });
    keyed.sort(function (a, b) {
      if ((a[0] === null) !== (b[0] === null)) { return a[0] === null ? 1 : -1; }
      const ahead = a[0] < b[0] ? -1 : a[0] > b[0] ? 1 : 0;
      return state.way * ahead || a[1].index - b[1].index;
    });
    found = keyed.map(function (pair) { return pair[1]; });
    at = found.findIndex(function (row) { return page.key(row) === state.id; });
  }

  // The list ----------------------------------------------------------------------------------------------------------
  function measure() {
    const width = list.clientWidth || 1;
    const isTiles = state.view === "tiles";
    const size = width < 800 ? "narrow" : width < 1080 ? "middle" : "wide";
    list.className = (isTiles ? "tiles-view " : "table ") + size;
    byId("heads").className = "cells " + size;
    byId("heads").hidden = isTiles || !page.line;
    columns = isTiles ? Math.max(1, Math.floor((width + 14) / (page.tile.width + 14))) : 1;
    height = isTiles ? page.tile.height + 14 : page.line.height[size === "narrow" ? 1 : 0];
    block.style.gridTemplateColumns = "repeat(" + columns + ", minmax(0, 1fr))";
    list.style.height = Math.ceil(found.length / columns) * height + "px";
  }
  function node(row) {
    const key = page.key(row);
    const isTiles = state.view === "tiles";
    const made = isTiles ? page.tile.node(row) : page.line.node(row);
    made.classList.add(isTiles ? "tile-card" : "line");
    made.style.height = height - (isTiles ? 14 : 0) + "px";
    made.addEventListener("click", function (event) {
      const link = event.target.closest("a");
      if (event.ctrlKey || event.metaKey || event.shiftKey || (link && !link.classList.contains("id"))) { return; }
      event.preventDefault();
      open(key);
    });
    return made;
  }
  const OVER = 4; // lines above and below the window that are drawn too
  function paint() {
    if (state.tab !== start.tab) { return; }
    const above = -list.getBoundingClientRect().top;
    const first = Math.max(0, Math.floor(above / height) - OVER) * columns;
    const last = Math.min(found.length, (Math.ceil((above + window.innerHeight) / height) + OVER) * columns);
    block.style.transform = "translateY(" + first / columns * height + "px)";
    const wanted = new Set();
    for (let i = first; i < last; i++) { wanted.add(page.key(found[i])); }
    drawn.forEach(function (made, key) { if (!wanted.has(key)) { made.remove(); drawn.delete(key); } });
    for (let i = first; i < last; i++) {
      const key = page.key(found[i]);
      let made = drawn.get(key);
      if (!made) { made = node(found[i]); drawn.set(key, made); }
      made.classList.toggle("now", key === state.id || i === at);
      if (block.children[i - first] !== made) { block.insertBefore(made, block.children[i - first] || null); }
    }
  }
  let isAsked = false;
  function askToPaint() {
    if (isAsked) { return; }
    isAsked = true;
    requestAnimationFrame(function () { isAsked = false; paint(); });
  }
  function redraw() {
    drawn.forEach(function (made) { made.remove(); });
    drawn.clear();
    measure();
    paint();
  }
  function refresh() {
    search();
    list.hidden = found.length === 0;
    redraw();
    heads(); filters(); chips();
    byId("shown").textContent = found.length.toLocaleString("en") + " of " + rows.length.toLocaleString("en");
    byId("empty").hidden = found.length > 0;
    byId("empty").textContent = rows.length ? "Nothing matches. Take a filter away." : "There is nothing here.";
    byId("layout").setAttribute("aria-pressed", String(state.view === "tiles"));
    byId("order").value = (state.way < 0 ? "-" : "") + state.sort;
  }
  function changed() { remember(false); refresh(); toTop(); }
  // After another search the list begins at its top again.
  function toTop() {
    const bar = document.querySelector(".bar");
    const top = list.getBoundingClientRect().top - bar.offsetHeight - byId("heads").offsetHeight;
    if (top < 0) { window.scrollBy(0, top); }
  }

  function heads() {
    const place = byId("heads");
    place.replaceChildren();
    (page.heads || []).forEach(function (head) {
      const sort = page.sorts.find(function (s) { return s.key === head.key; });
      const kind = head.kind || "";
      if (!sort) { place.append(make("div", { "class": kind, text: head.title })); return; }
      const button = make("button", { type: "button", text: head.title, click: function () {
        state.way = state.sort === sort.key ? -state.way : sort.number ? -1 : 1;
        state.sort = sort.key;
        changed();
        byId("heads").querySelector('[data-key="' + sort.key + '"]').focus();
      }, "data-key": sort.key, "data-way": state.sort === sort.key ? state.way : 0 });
      button.setAttribute("aria-label", head.title + ": sort by " + sort.title + (state.sort === sort.key ? (state.way > 0 ? ", ascending now" : ", descending now") : ""));
      place.append(make("div", { "class": kind }, button));
    });
  }

  // The filters -------------------------------------------------------------------------------------------------------
  const FEW = 8; // values of a filter that are shown before one asks for all
  function toggle(key, value) {
    const now = state.chosen[key] || [];
    state.chosen[key] = now.indexOf(value) >= 0 ? now.filter(function (v) { return v !== value; }) : now.concat([value]);
    changed();
  }
  function filters() {
    const place = byId("facet-list");
    const focused = document.activeElement && document.activeElement.dataset ? document.activeElement.dataset.place : "";
    place.replaceChildren();
    page.facets.forEach(function (facet) {
      const chosen = state.chosen[facet.key] || [];
      const order = facet.order || function (a, b) { return b[1] - a[1] || (a[0] < b[0] ? -1 : 1); };
      const values = Array.from(counts[facet.key]).sort(order);
      chosen.forEach(function (v) { if (!counts[facet.key].has(v)) { values.unshift([v, 0]); } });
      if (!values.length) { return; }
      const shown = opened[facet.key] ? values : values.filter(function (pair, i) { return i < FEW || chosen.indexOf(pair[0]) >= 0; });
      const group = make("div", { "class": "facet", role: "group", "aria-label": facet.title }, make("h3", { text: facet.title }));
      shown.forEach(function (pair) {
        const text = facet.label ? facet.label(pair[0]) : pair[0];
        group.append(make("button", { type: "button", "aria-pressed": String(chosen.indexOf(pair[0]) >= 0), title: facet.meaning ? facet.meaning(pair[0]) : text,
          "data-place": facet.key + "=" + pair[0], click: function () { toggle(facet.key, pair[0]); } },
          make("span", { "class": "name", text: text }), make("span", { "class": "number", text: pair[1].toLocaleString("en") })));
      });
      if (values.length > shown.length || opened[facet.key]) {
        group.append(make("button", { type: "button", "class": "all", "data-place": facet.key, text: opened[facet.key] ? "Fewer" : "All " + values.length,
          click: function () { opened[facet.key] = !opened[facet.key]; filters(); } }));
      }
      place.append(group);
    });
    if (focused) {
      const again = Array.from(place.querySelectorAll("button")).find(function (b) { return b.dataset.place === focused; });
      if (again) { again.focus(); }
    }
  }
  function chips() {
    const place = byId("chips");
    place.replaceChildren();
    page.facets.forEach(function (facet) {
      (state.chosen[facet.key] || []).forEach(function (value) {
        const text = facet.title.toLowerCase() + ": " + (facet.label ? facet.label(value) : value);
        place.append(make("button", { type: "button", text: text + "  ×", "aria-label": "Remove filter " + text, click: function () { toggle(facet.key, value); } }));
      });
    });
  }

  // Details -----------------------------------------------------------------------------------------------------------
  function open(key) { state.id = key; remember(true); details(); }
  function close() {
    const key = state.id;
    if (!key) { return; }
    state.id = "";
    remember(true);
    details();
    const made = drawn.get(key);
    if (made) { focusOn(made); }
  }
  function focusOn(made) { const link = made.querySelector("a.id"); if (link) { link.focus({ preventScroll: true }); } }
  let openKey = "";
  function details() {
    const panel = byId("detail");
    const row = byKey.get(state.id);
    document.body.classList.toggle("with-detail", Boolean(row));
    panel.hidden = !row;
    at = row ? found.indexOf(row) : at;
    if (!row) {
      openKey = "";
      byId("detail-body").replaceChildren();
      redraw();
      return;
    }
    if (openKey !== state.id) {
      openKey = state.id;
      byId("detail-title").textContent = page.title(row);
      byId("detail-body").replaceChildren();
      panel.scrollTop = 0;
      page.details(row, byId("detail-body"));
    }
    redraw();
    if (!panel.contains(document.activeElement)) { panel.focus({ preventScroll: true }); }
  }

  // Keys --------------------------------------------------------------------------------------------------------------
  function step(by) {
    if (!found.length) { return; }
    at = Math.min(found.length - 1, Math.max(0, at < 0 ? 0 : at + by));
    const top = list.getBoundingClientRect().top + Math.floor(at / columns) * height;
    const bar = document.querySelector(".bar").offsetHeight + 8;
    if (top < bar) { window.scrollBy(0, top - bar); }
    else if (top + height > window.innerHeight - 8) { window.scrollBy(0, top + height - window.innerHeight + 8); }
    const key = page.key(found[at]);
    if (state.id) { state.id = key; remember(false); details(); return; }
    paint();
    const made = drawn.get(key);
    if (made) { focusOn(made); }
  }
  document.addEventListener("keydown", function (event) {
    const field = /^(INPUT|SELECT|TEXTAREA)$/.test(document.activeElement.tagName);
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) { return; }
    if (event.key === "Escape") {
      if (state.id) { close(); }
      else if (field) { if (state.q) { state.q = ""; byId("search").value = ""; changed(); } document.activeElement.blur(); }
      event.preventDefault();
      return;
    }
    if (field) { if (event.key === "Enter" && document.activeElement.id === "search") { at = -1; step(1); } return; }
    if (state.tab !== start.tab) { return; }
    if (event.key === "/") { event.preventDefault(); byId("search").focus(); }
    else if (event.key === "j") { event.preventDefault(); step(1); }
    else if (event.key === "k") { event.preventDefault(); step(-1); }
    else if (event.key === "Enter" && at >= 0 && !state.id && !/^(BUTTON|A|SUMMARY)$/.test(document.activeElement.tagName)) { open(page.key(found[at])); }
  });

  // Tabs --------------------------------------------------------------------------------------------------------------
  function tabs() {
    page.tabs.forEach(function (name) {
      const button = byId("tab-" + name);
      if (!button) { return; }
      const on = name === state.tab;
      button.setAttribute("aria-selected", String(on));
      button.tabIndex = on ? 0 : -1;
      byId("panel-" + name).hidden = !on;
    });
  }
  page.tabs.forEach(function (name, i) {
    const button = byId("tab-" + name);
    if (!button) { return; }
    button.addEventListener("click", function () { state.tab = name; remember(true); tabs(); redraw(); });
    button.addEventListener("keydown", function (event) {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!by) { return; }
      const other = byId("tab-" + page.tabs[(i + by + page.tabs.length) % page.tabs.length]);
      other.click(); other.focus();
    });
  });

  // Start -------------------------------------------------------------------------------------------------------------
  page.sorts.forEach(function (sort) {
    [1, -1].forEach(function (way) {
      byId("order").append(make("option", { value: (way < 0 ? "-" : "") + sort.key, text: sort.ways ? sort.ways[way < 0 ? 1 : 0] : sort.title + (way < 0 ? " ↓" : " ↑") }));
    });
  });
  byId("order").addEventListener("change", function (event) {
    state.way = event.target.value[0] === "-" ? -1 : 1;
    state.sort = event.target.value.replace(/^-/, "");
    changed();
  });
  byId("search").addEventListener("input", function (event) { state.q = event.target.value; changed(); });
  byId("layout").hidden = !page.line;
  byId("layout").addEventListener("click", function () { state.view = state.view === "tiles" ? "table" : "tiles"; changed(); });
  byId("close").addEventListener("click", close);
  if (byId("theme")) {
    byId("theme").addEventListener("click", function () {
      const root = document.documentElement;
      const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
      root.dataset.theme = dark ? "light" : "dark";
    });
  }
  if (byId("skip")) { byId("skip").addEventListener("click", function (event) { event.preventDefault(); list.focus(); }); }
  const wideEnough = matchMedia("(min-width: 901px)");
  byId("facets").open = wideEnough.matches;
  wideEnough.addEventListener("change", function () { byId("facets").open = wideEnough.matches; });
  window.addEventListener("scroll", askToPaint, { passive: true });
  let width = 0;
  new ResizeObserver(function () { if (list.clientWidth !== width) { width = list.clientWidth; redraw(); } }).observe(list);
  function restore() { readAddress(); tabs(); refresh(); details(); }
  window.addEventListener("popstate", restore);
  window.addEventListener("hashchange", restore);

  restore();
}

return { facts: facts, byId: byId, make: make, show: show, browse: browse };
})();
