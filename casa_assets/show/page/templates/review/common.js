// Shared by the pages of review: nodes, messages and keys. Text only ever becomes text nodes, never markup.
const review = (function () {
"use strict";
const byId = function (id) { return document.getElementById(id); };

function make(tag, attributes) {
  const node = document.createElement(tag);
  Object.keys(attributes || {}).forEach(function (key) {
    if (key === "text") { node.textContent = attributes[key]; } else { node.setAttribute(key, attributes[key]); }
  });
  for (let i = 2; i < arguments.length; i++) { if (arguments[i]) { node.append(arguments[i]); } }
  return node;
}

function say(text, kind) { byId("said").textContent = text; byId("said").className = kind || ""; }

// Calls the function of a pressed key, or of a button that names the key, unless a field is being filled in; Escape
// leaves a field. Enter on a button or link presses that.
function onKeys(actions) {
  const every = Object.assign({ "?": function () { byId("keys").open = !byId("keys").open; } }, actions);
  document.addEventListener("keydown", function (event) {
    const tag = document.activeElement.tagName;
    const inside = /^(INPUT|SELECT)$/.test(tag);
    if (event.key === "Escape" && inside) { document.activeElement.blur(); return; }
    if (inside || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || !Object.hasOwn(every, event.key)) { return; }
    if (event.key === "Enter" && /^(A|BUTTON|SUMMARY)$/.test(tag)) { return; }
    every[event.key]();
    event.preventDefault();
  });
  document.addEventListener("click", function (event) {
    const button = event.target.closest("[data-key]");
    if (button) { every[button.dataset.key](); }
  });
}

// A share as a person reads it, on one line.
function percent(share) { return Math.round(100 * share) + "\u00a0%"; }

// A table of one row of headings and rows of cells.
function tableOf(headings) {
  return make("table", {}, make("tr", {}, ...headings.map(function (h) { return make("th", { text: h }); })));
}

return { byId: byId, make: make, say: say, onKeys: onKeys, tableOf: tableOf, percent: percent };
})();
