// Runs the scripts of a page of review without a browser: `node press_keys.js PAGE KEY...` presses keys one after the
// other and prints the review.json that the page writes; `button:h` presses the button that has the key h on it. Of the DOM
// there is what those scripts use.
"use strict";
const fs = require("fs");
const vm = require("vm");

const page = fs.readFileSync(process.argv[2], "utf-8");
const listeners = {};

class Node {
  constructor(tag) { this.tagName = tag.toUpperCase(); this.style = {}; this.children = []; this.attributes = {}; this.value = ""; }
  set textContent(text) { this.text = text; }
  get textContent() { return this.text || ""; }
  setAttribute(name, value) { this.attributes[name] = value; }
  append(...nodes) { this.children.push(...nodes); }
  prepend(...nodes) { this.children.unshift(...nodes); }
  replaceChildren(...nodes) { this.children = nodes; }
  addEventListener() {}
  focus() {}
  blur() {}
  click() { if (this.attributes.download) { process.stdout.write(written); } }
}

let written = "";
const byId = { data: new Node("script") };
byId.data.textContent = /<script type="application\/json" id="data">(.*?)<\/script>/s.exec(page)[1];
for (const name of ["stage", "cells", "told", "chosen", "kind", "parts", "words", "said", "place"]) { byId[name] = new Node("div"); }
const body = new Node("body");
const context = vm.createContext({
  document: {
    getElementById: (id) => byId[id],
    createElement: (tag) => new Node(tag),
    addEventListener: (kind, listener) => { (listeners[kind] = listeners[kind] || []).push(listener); },
    body: body,
    activeElement: body,
  },
  window: { localStorage: { getItem: () => null, setItem: () => {} }, addEventListener: () => {} },
  Blob: class { constructor(parts) { written = parts.join(""); } },
  location: { hash: "" },
  URL: { createObjectURL: () => "blob:" },
});
for (const script of page.matchAll(/<script>\n(.*?)<\/script>/gs)) { vm.runInContext(script[1], context); }
for (const key of process.argv.slice(3)) {
  const button = key.startsWith("button:") ? { dataset: { key: key.slice(7) } } : null;
  if (button) { listeners.click.forEach((listener) => listener({ target: { closest: (what) => (what === "[data-key]" ? button : null) } })); }
  else { listeners.keydown.forEach((listener) => listener({ key: key, preventDefault: () => {} })); }
  if (byId.said.className === "bad") { process.stderr.write(`${key}: ${byId.said.textContent}\n`); }
}
