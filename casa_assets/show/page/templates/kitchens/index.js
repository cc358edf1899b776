// Finds a kitchen by plan, style, fixtures and tasks: rows of browse.js.
(function () {
"use strict";
const facts = casa.facts;
const make = casa.make;
const show = casa.show;
const words = function (name) { return name.replace(/_/g, " "); };
const named = function (places) { return places.map(function (i) { return facts.names[i]; }); };
const whole = function (number) { return number === null ? "–" : String(Math.round(number)); };

function shot(row, name) { return row.folder + "/" + encodeURIComponent(name); }
// Doors that stand open tell most of a kitchen, seen at the height of eyes.
function best(row) { return row.pictures.find(function (name) { return name === "eye_open.png"; }) || row.pictures[0]; }
function picture(row) {
  const name = best(row);
  return name ? make("img", { src: shot(row, name), alt: "", loading: "lazy", decoding: "async" }) : make("span", { "class": "none", text: "no picture" });
}
function verdict(row) { return make("span", { "class": "badge " + row.verdict.replace(" ", "-"), text: row.verdict, title: row.errors }); }
function link(row) { return make("a", { "class": "id", href: "#" + encodeURIComponent(row.id), text: words(row.plan) + ", " + words(row.style) }); }
function counts(row) { return row.fixtures + " fixtures, " + row.joints + " joints" + (row.objects ? ", " + row.objects + " objects" : "") + ", " + show(row.floor) + " m²"; }

function tile(row) {
  return make("div", {}, picture(row), make("div", { "class": "text" }, make("div", { "class": "clip" }, link(row)),
    make("div", { "class": "small clip", text: row.id }), make("div", { "class": "clip" }, verdict(row), make("span", { "class": "small", text: " " + counts(row) }))));
}
function line(row) {
  return make("div", { "class": "cells" }, make("div", { "class": "picture" }, picture(row)),
    make("div", { "class": "clip" }, link(row), make("div", { "class": "small clip", text: row.id })),
    make("div", { "class": "clip middle-only", text: words(row.plan) }), make("div", { "class": "clip middle-only", text: words(row.style) }),
    make("div", { "class": "clip" }, verdict(row)), make("div", { "class": "number wide-only", text: show(row.fixtures) }),
    make("div", { "class": "number wide-only", text: show(row.joints) }), make("div", { "class": "number wide-only", text: whole(row.design) }),
    make("div", { "class": "number wide-only", text: show(row.floor) }));
}

function details(row, place) {
  const large = make("img", { alt: "Picture of " + row.id });
  if (best(row)) {
    large.src = shot(row, best(row));
    const strip = make("div", { "class": "shots" });
    row.pictures.forEach(function (name) {
      const button = make("button", { type: "button", "aria-pressed": String(name === best(row)), title: words(name.replace(/\.png$/, "")), click: function () {
        large.src = shot(row, name);
        strip.querySelectorAll("button").forEach(function (b) { b.setAttribute("aria-pressed", String(b === button)); });
      } }, make("img", { src: shot(row, name), alt: words(name.replace(/\.png$/, "")), loading: "lazy" }));
      strip.append(button);
    });
    place.append(large, row.pictures.length > 1 ? strip : "");
  }
  const isChecked = row.verdict !== "not checked";
  const files = [["scene.xml", "MJCF"], ["scene.usda", "USD"], ["scene.json", "scene.json"]];
  if (isChecked) { files.unshift(["report.html", "Page of this kitchen"]); }
  place.append(make("div", { "class": "links" }, ...files.map(function (file) { return make("a", { href: row.folder + "/" + file[0], text: file[1] }); })));
  const terms = make("dl", { "class": "facts" });
  [["Id", row.id], ["Verdict", row.verdict + (row.errors ? ": " + row.errors : "")], ["Holds", counts(row)], ["Finishes", row.surfaces.map(words).join(", ")],
    ["Design", row.design === null ? "" : whole(row.design) + " of 100"], ["Access", row.access === null ? "" : whole(row.access) + " of 100"],
    ["Loads in", row.load === null ? "" : show(row.load) + " ms"], ["Runs at", row.pace === null ? "" : show(row.pace) + " times real time"],
    ["Fixtures", named(row.families).map(words).join(", ")], ["Tasks", named(row.tasks).map(words).join(", ")]].forEach(function (pair) {
    if (pair[1]) { terms.append(make("dt", { text: pair[0] }), make("dd", { text: pair[1] })); }
  });
  place.append(terms);
  place.append(make("p", { "class": "small", text: isChecked ? "Open its doors, from the folder of this page:" : "In 3D at once, from the folder of this page:" }), make("code", { "class": "command", text: "casa-assets view " + row.id }));
  if (!isChecked) { place.append(make("p", { "class": "small", text: "Every check, and a page that shows this kitchen in 3D:" }), make("code", { "class": "command", text: "casa-assets scenes check " + row.id + " --out ." })); }
}

casa.browse({
  key: function (row) { return row.id; },
  title: function (row) { return words(row.plan) + ", " + words(row.style); },
  words: function (row) {
    return [row.id, words(row.id), row.plan, row.style, row.verdict, row.errors, row.surfaces.join(" "), row.surfaces.map(words).join(" "),
      named(row.families).map(function (n) { return n + " " + words(n); }).join(" "), named(row.tasks).join(" ")].join(" ");
  },
  tabs: ["list"],
  view: "tiles",
  facets: [
    { key: "plan", title: "Plan", values: function (row) { return [row.plan]; }, label: words },
    { key: "style", title: "Style", values: function (row) { return [row.style]; }, label: words },
    { key: "verdict", title: "Verdict", values: function (row) { return [row.verdict]; } },
    { key: "fixture", title: "Fixtures", all: true, values: function (row) { return named(row.families); }, label: words },
    { key: "task", title: "Tasks", all: true, values: function (row) { return named(row.tasks); }, label: words },
    { key: "finish", title: "Finishes", values: function (row) { return row.surfaces; }, label: words }
  ],
  sorts: [
    { key: "id", title: "name", value: function (row) { return row.id; } },
    { key: "style", title: "style", value: function (row) { return row.style; } },
    { key: "verdict", title: "verdict", value: function (row) { return row.verdict; } },
    { key: "fixtures", title: "fixtures", value: function (row) { return row.fixtures; }, number: true },
    { key: "joints", title: "joints", value: function (row) { return row.joints; }, number: true },
    { key: "design", title: "design", value: function (row) { return row.design; }, number: true },
    { key: "access", title: "access", value: function (row) { return row.access; }, number: true },
    { key: "floor", title: "floor area", value: function (row) { return row.floor; }, number: true },
    { key: "load", title: "time to load", value: function (row) { return row.load; }, number: true }
  ],
  heads: [
    { title: "" }, { key: "id", title: "Kitchen" }, { title: "Plan", kind: "middle-only" }, { key: "style", title: "Style", kind: "middle-only" }, { key: "verdict", title: "Verdict" },
    { key: "fixtures", title: "Fixtures", kind: "number wide-only" }, { key: "joints", title: "Joints", kind: "number wide-only" },
    { key: "design", title: "Design", kind: "number wide-only" }, { key: "floor", title: "Floor, m²", kind: "number wide-only" }
  ],
  line: { height: [84, 88], node: line },
  tile: { width: 300, height: 312, node: tile },
  details: details
});
})();
