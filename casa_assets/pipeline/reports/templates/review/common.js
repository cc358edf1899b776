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

// Calls the function of a pressed key, unless a field is being filled in; Escape leaves a field.
function onKeys(actions) {
  document.addEventListener("keydown", function (event) {
    const inside = /^(INPUT|SELECT)$/.test(document.activeElement.tagName);
    if (event.key === "Escape" && inside) { document.activeElement.blur(); return; }
    if (inside || event.ctrlKey || event.metaKey || event.altKey || !Object.hasOwn(actions, event.key)) { return; }
    actions[event.key]();
    event.preventDefault();
  });
}

// A table of one row of headings and rows of cells.
function tableOf(headings) {
  return make("table", {}, make("tr", {}, ...headings.map(function (h) { return make("th", { text: h }); })));
}

return { byId: byId, make: make, say: say, onKeys: onKeys, tableOf: tableOf };
})();
