// What a person decides about articulated meshes, as data. Every function changes a copy and returns it; the fields are
// those of decisions.yaml, and a field that says nothing is left out.
const decisions = (function () {
"use strict";

function copy(said) { return JSON.parse(JSON.stringify(said)); }

function partOf(said, name) { return (said.parts || {})[name] || {}; }

// With other fields for a part; a field that is null is taken out.
function withPart(said, name, fields) {
  const changed = copy(said);
  const part = Object.assign({}, partOf(changed, name), fields);
  Object.keys(part).forEach(function (key) { if (part[key] === null) { delete part[key]; } });
  changed.parts = Object.assign({}, changed.parts);
  if (Object.keys(part).length) { changed.parts[name] = part; } else { delete changed.parts[name]; }
  if (!Object.keys(changed.parts).length) { delete changed.parts; }
  return changed;
}

// With another value for the whole mesh; an empty one is taken out.
function withValue(said, name, value) {
  const changed = copy(said);
  if (value === "" || value === null) { delete changed[name]; } else { changed[name] = value; }
  return changed;
}

// What a part is now: as it was told, with what was decided since. A part that an earlier run took away has no `told`.
function stateOf(said, name, told) {
  const part = partOf(said, name);
  const kind = part.kind || (told ? told.kind : "");
  return {
    kind: kind,
    edge: part.hinge || (told ? told.edge : ""),
    flipped: part.flip === true,
    gone: part.remove === true,
    merged: part.merge || "",
  };
}

// The next edge that a hinge may run along: the runner-up comes after the one that was told.
function nextHinge(said, told, edges) {
  const order = edgeOrder(told, edges);
  const now = stateOf(said, told.name, told).edge;
  return withPart(said, told.name, { hinge: order[(order.indexOf(now) + 1) % order.length] });
}

function edgeOrder(told, edges) {
  const first = [told.edge, told.runner_up].filter(function (e) { return edges.includes(e); });
  return first.concat(edges.filter(function (e) { return !first.includes(e); }));
}

// `none` is no kind: the part does not move.
function withKind(said, told, kind) {
  if (kind === "none") { return withPart(said, told.name, { remove: true, merge: null }); }
  const turns = kind === "door" || kind === "lid";
  const fields = { kind: kind, remove: null, merge: null };
  return withPart(said, told.name, turns ? fields : Object.assign(fields, { hinge: null }));
}

function nextKind(said, told, kinds) {
  const state = stateOf(said, told.name, told);
  const every = kinds.concat(["none"]);
  const now = state.gone ? "none" : state.kind;
  return withKind(said, told, every[(every.indexOf(now) + 1) % every.length]);
}

function flipped(said, name) { return withPart(said, name, { flip: partOf(said, name).flip === true ? null : true }); }

function removed(said, name) {
  return withPart(said, name, { remove: partOf(said, name).remove === true ? null : true, merge: null });
}

// Null where it would be merged into itself, over others too.
function merged(said, name, into) {
  let end = into;
  while (end && end !== name) { end = partOf(said, end).merge || ""; }
  return end === name ? null : withPart(said, name, { merge: into, remove: null });
}

// The text of a review.json: every mesh of which something was decided, or of which all that was decided was undone.
function fileOf(rows, now) {
  const meshes = {};
  rows.forEach(function (row) {
    const said = now[row.sha256];
    if (row.sha256 && JSON.stringify(said) !== JSON.stringify(row.decisions)) { meshes[row.sha256] = said; }
    else if (row.sha256 && Object.keys(said).length) { meshes[row.sha256] = said; }
  });
  return JSON.stringify({ meshes: meshes }, null, 1) + "\n";
}

return {
  stateOf: stateOf, nextHinge: nextHinge, nextKind: nextKind, withKind: withKind, withValue: withValue, flipped: flipped,
  removed: removed, merged: merged, fileOf: fileOf,
};
})();
