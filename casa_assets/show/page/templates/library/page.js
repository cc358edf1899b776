// The report on a library: rows of browse.js.
(function () {
"use strict";
const facts = casa.facts;
const make = casa.make;
const show = casa.show;

function mass(kg) { return kg === null ? "–" : kg < 0.1 ? show(1000 * kg) + " g" : show(kg) + " kg"; }
function size(cm) { return cm === null ? "–" : cm.map(function (v) { return v >= 100 ? v.toFixed(0) : v.toFixed(1); }).join(" × "); }
const VERDICTS = { accepted: "accepted", review: "in review", rejected: "rejected" };
const title = function (code) { return (facts.meanings[code] || facts.checks[code] || "").split(":")[0]; };

function picture(row, kind) {
  const place = make("div", { "class": "picture " + kind });
  const image = make("img", { "class": "thumb", alt: "", decoding: "async" });
  place.append(image);
  const none = function () { image.replaceWith(make("span", { "class": "thumb none", text: "no picture" })); };
  if (row.thumb === "") { none(); }
  else { image.addEventListener("error", none, { once: true }); image.src = row.thumb || row.folder + "/" + facts.picture; }
  return place;
}
// Codes of advice that tell something of this asset in particular; the details name all of them.
function telling(row) { return row.codes.filter(function (code) { return facts.quiet.indexOf(code) < 0; }); }
const FEW_CODES = 2;
function verdict(row) {
  const place = make("div", { "class": "verdict" }, make("span", { "class": "badge " + row.verdict, text: VERDICTS[row.verdict] }),
    row.outlier.length ? make("span", { "class": "badge advice", text: "unusual " + row.outlier.join(", "), title: "outside the usual " + row.outlier.join(" and ") }) : null);
  const codes = row.verdict === "accepted" ? telling(row) : row.codes;
  const few = codes.slice(0, FEW_CODES).join(", ") + (codes.length > FEW_CODES ? " +" + (codes.length - FEW_CODES) : "");
  const more = row.verdict === "review" ? row.decide.join(", ") : few && row.verdict === "accepted" ? "advice " + few : few;
  if (more) { place.append(make("div", { "class": "small", text: more, title: codes.map(title).join("; ") })); }
  if (row.change) { place.append(make("div", { "class": "small clip" }, make("span", { "class": row.change === "worse" ? "bad-text" : row.change === "better" ? "good" : "", text: row.change }))); }
  return place;
}
function link(row) { return make("a", { "class": "id", href: "#" + encodeURIComponent(row.id), text: name(row) }); }
function why(row) { return row.codes.map(title).join("; "); }
function name(row) { return row.verdict === "rejected" ? row.path : row.id; }

function line(row) {
  const label = make("div", { "class": "clip" }, link(row), make("div", { "class": "small clip middle-only", text: row.verdict === "rejected" ? why(row) : row.title || row.path.split("/").pop() }));
  const short = row.verdict === "rejected" ? why(row) : row.size ? size(row.size) + " cm, " + mass(row.mass) : row.category;
  label.append(make("div", { "class": "small clip narrow-only", text: short }));
  const unusual = function (quantity) { return row.outlier.indexOf(quantity) >= 0 ? " warn-text" : ""; };
  const sizes = make("div", { "class": "number middle-only" + unusual("size"), text: size(row.size) });
  const weight = make("div", { "class": "number middle-only" + unusual("mass"), text: mass(row.mass) });
  const checks = row.applying ? row.passed + " of " + row.applying : "–";
  return make("div", { "class": "cells" }, picture(row, ""), label,
    make("div", { "class": "clip middle-only", text: row.category }), verdict(row), sizes, weight,
    make("div", { "class": "number wide-only", text: show(row.colliders) }), make("div", { "class": "number wide-only", text: show(row.faces) }),
    make("div", { "class": "number wide-only", text: checks }));
}
function tile(row) {
  const told = row.verdict === "rejected" ? why(row) : size(row.size) + " cm, " + mass(row.mass);
  return make("div", {}, picture(row, ""), make("div", { "class": "text" }, make("div", { "class": "clip" }, link(row)),
    make("div", { "class": "clip" }, make("span", { "class": "badge " + row.verdict, text: VERDICTS[row.verdict] }), make("span", { "class": "small", text: " " + told }))));
}

// Details of a row ------------------------------------------------------------------------------------------------------
function list(heading, lines) {
  return lines.length ? make("div", {}, make("h3", { text: heading }), make("ul", {}, ...lines.map(function (text) { return make("li", { text: text }); }))) : "";
}
function large(row) {
  const image = make("img", { alt: "Picture of " + name(row), src: row.folder + "/" + facts.picture });
  // The page may have been moved away from its library, or nothing could be drawn: then the small picture has to do.
  image.addEventListener("error", function () {
    if (row.thumb) { image.src = row.thumb; } else { image.remove(); }
  }, { once: true });
  return image;
}
function in3d(row) {
  const { folder, suffix, viewer } = facts.models;
  return make("button", { type: "button", "class": "quiet model-popup", "data-model": folder + "/" + encodeURIComponent(row.id) + suffix, "data-name": row.id,
    "data-viewer": viewer, "data-title": name(row), text: "Open in 3D" });
}
function details(row, place) {
  place.append(large(row));
  if (facts.models && row.verdict !== "rejected") { place.append(in3d(row)); }
  const terms = make("dl", { "class": "facts" });
  const told = function (pairs) {
    pairs.forEach(function (pair) { if (pair[1]) { terms.append(make("dt", { text: pair[0] }), make("dd", { text: pair[1] })); } });
  };
  told([["Verdict", VERDICTS[row.verdict] + (row.decide.length ? ": " + row.decide.join(", ") : "")], ["Category", row.category],
    ["Size", row.size ? size(row.size) + " cm" : ""], ["Mass", row.mass === null ? "" : mass(row.mass)],
    ["Unusual", row.outlier.length ? "outside the usual " + row.outlier.join(" and ") : ""], ["Title", row.title], ["Author", row.author],
    ["Licence", row.licence], ["Source", row.source + ": " + row.path]]);
  place.append(terms);
  const more = row.more;
  told([["Colliders", row.colliders === null ? "" : row.colliders + (more.hull ? ", at most " + more.hull + " vertices each" : "")], ["Faces", row.faces === null ? "" : show(row.faces)],
    ["Address", more.uri], ["Prompt", more.prompt], ["Generator", more.generator], ["By its pictures", more.looks],
    ["Checks", row.applying ? row.passed + " of " + row.applying + " that apply passed" : ""]]);
  if (more.files.length) {
    place.append(make("div", { "class": "links" }, ...more.files.map(function (file) { return make("a", { href: row.folder + "/" + file[1], text: file[0] }); })));
  }
  if (more.reason) {
    place.append(make("h3", { text: "What is wrong" }), make("p", {}, make("span", { "class": "badge rejected", text: row.codes.join(", ") }), document.createTextNode(" " + more.reason)));
    if (more.fix) { place.append(make("h3", { text: "What to do" }), make("p", { text: more.fix })); }
  }
  place.append(list("Advice", (more.warnings || []).map(function (w) { return w[0] + (w[1] ? " at " + w[1] : "") + ": " + w[2]; })),
    list("Decided without being stated", (more.guesses || []).map(function (g) { return g[0] + ": " + g[1] + " (" + Math.round(100 * g[2]) + " % sure; " + g[3] + ")"; })),
    results(more.results));
}
// Status of a check: 0 failed, 1 passed, 2 does not apply, 3 was not run, 4 advice.
const STATES = [[0, "failed", "bad-text"], [4, "advice", "warn-text"], [3, "not run", "warn-text"], [1, "passed", "good"], [2, "does not apply", "small"]];
// A number and its limit with their unit, small lengths in millimetres.
function compared(number, limit, unit) {
  const isSmall = unit === "m" && Math.max(Math.abs(number || 0), Math.abs(limit || 0)) < 0.1;
  const name = isSmall ? "mm" : unit.replace("^2", "²").replace("^3", "³");
  return [number, limit].map(function (value) { return value === null ? "" : show(isSmall ? 1000 * value : value) + (name ? "\u00a0" + name : ""); });
}
function results(all) {
  const place = make("div");
  STATES.forEach(function (state) {
    const some = all.filter(function (r) { return r[1] === state[0]; });
    if (!some.length) { return; }
    const body = make("tbody");
    some.forEach(function (r) {
      const text = (facts.checks[r[0]] || "").split(": ");
      const named = make("td", { title: text.slice(1).join(": ") }, make("span", { text: r[0] + " " + text[0] }), r[5] ? make("div", { "class": "small", text: r[5] }) : null);
      body.append(make("tr", {}, named, ...compared(r[2], r[3], r[4]).map(function (text) { return make("td", { "class": "number", text: text }); })));
    });
    const head = make("tr", {}, ...["Check", "Measured", "Limit"].map(function (h, i) { return make("th", { text: h, scope: "col", "class": i ? "number" : "" }); }));
    const box = make("details", {}, make("summary", {}, make("b", { "class": state[2], text: some.length + " " + state[1] })), make("div", { "class": "scroll" }, make("table", {}, make("thead", {}, head), body)));
    box.open = state[0] === 0 || state[0] === 4;
    place.append(box);
  });
  return place.childElementCount ? make("div", {}, make("h3", { text: "Checks" }), place) : "";
}

// What somebody should look at first comes first.
const RANKS = { rejected: 0, review: 1, accepted: 4 };
function rank(row) { return row.verdict !== "accepted" ? RANKS[row.verdict] : row.outlier.length ? 2 : telling(row).length ? 3 : RANKS.accepted; }
const longest = function (row) { return row.size === null ? null : Math.max.apply(null, row.size); };
casa.browse({
  key: function (row) { return row.id; },
  title: name,
  words: function (row) {
    return [row.id, row.category, row.title, row.author, row.path, row.source, row.licence, row.codes.map(function (c) { return c + " " + title(c); }).join(" ")].join(" ");
  },
  tabs: ["list", "numbers", "changes"].filter(function (tab) { return casa.byId("tab-" + tab); }),
  view: "table",
  facets: [
    { key: "verdict", title: "Verdict", values: function (row) { return [row.verdict]; }, label: function (v) { return VERDICTS[v] || v; } },
    { key: "advice", title: "Advice", values: function (row) { return row.verdict === "rejected" ? [] : [telling(row).length ? "yes" : row.codes.length ? "notes" : "no"]; },
      label: function (v) { return { yes: "with advice", notes: "routine notes only", no: "without advice" }[v] || v; } },
    { key: "change", title: "Since the earlier run", values: function (row) { return row.change ? [row.change] : []; } },
    { key: "reason", title: "Reason", values: function (row) { return row.codes; }, label: function (code) { return code + " " + title(code); }, meaning: function (code) { return facts.meanings[code] || code; } },
    { key: "decide", title: "To decide", values: function (row) { return row.decide; } },
    { key: "category", title: "Category", values: function (row) { return [row.category]; } },
    { key: "source", title: "Source", values: function (row) { return [row.source]; } },
    { key: "outlier", title: "Outside the usual range", values: function (row) { return row.outlier; } }
  ],
  sorts: [
    { key: "verdict", title: "severity", ways: ["worst first", "worst last"], value: rank },
    { key: "listed", title: "category", value: function (row) { return row.index; } },
    { key: "id", title: "name", value: function (row) { return row.id; } },
    { key: "size", title: "longest side", value: longest, number: true },
    { key: "mass", title: "mass", value: function (row) { return row.mass; }, number: true },
    { key: "colliders", title: "colliders", value: function (row) { return row.colliders; }, number: true },
    { key: "faces", title: "faces", value: function (row) { return row.faces; }, number: true },
    { key: "source", title: "source", value: function (row) { return row.source + "/" + row.path; } },
    { key: "checks", title: "share of checks passed", value: function (row) { return row.applying ? row.passed / row.applying : null; }, number: true }
  ],
  heads: [
    { title: "" }, { key: "id", title: "Asset or input" }, { key: "listed", title: "Category" }, { key: "verdict", title: "Verdict" },
    { key: "size", title: "Size, cm", kind: "number middle-only" }, { key: "mass", title: "Mass", kind: "number middle-only" },
    { key: "colliders", title: "Colliders", kind: "number wide-only" }, { key: "faces", title: "Faces", kind: "number wide-only" },
    { key: "checks", title: "Checks", kind: "number wide-only" }
  ],
  line: { height: [74, 96], node: line },
  tile: { width: 190, height: 256, node: tile },
  details: details
});
})();
