"use strict";
// The page of `casa-assets view`. Its 3D view with sliders, poses, cameras and layers is the viewer of all our pages; here
// stand what only a server can give: states, other styles and textures, and what is known of robots.
// Addresses are relative, so that a tunnel may have any port.
(() => {
  const start = JSON.parse(document.getElementById("start").textContent);
  const at = (id) => document.getElementById(id);
  const POLL_MS = 250, TICK_MS = 500, STEP_MS = 40;
  const PARKED = { opened: "#2f9e57", reached: "#d9a300", missed: "#d64545", untried: "#4c7fd1" };
  let viewer = null, facts = null, shown = "", machines = new Map();
  // The kitchen that was ordered last, and how many were: what comes of an earlier order is not shown any more.
  let ordered = start.first, orders = 0, asking = Promise.resolve(), showing = Promise.resolve();

  // Asking the server -------------------------------------------------------------------------------------------------
  async function ask(path, body) {
    const answer = await fetch(path, body === undefined ? {} : {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
    });
    if (!answer.ok) throw new Error(await answer.text());
    return answer;
  }

  function say(text, isBad = false) {
    at("progress").textContent = text;
    at("progress").hidden = !text;
    at("progress").classList.toggle("bad", isBad);
  }

  const fail = (error) => say(error.message || String(error), true);
  const pause = (ms) => new Promise((done) => setTimeout(done, ms));
  const words = (name) => name.replaceAll("_", " ");

  function make(tag, fields = {}, ...children) {
    const made = Object.assign(document.createElement(tag), fields);
    made.append(...children);
    return made;
  }

  // Waits until a model is made, telling how far it is; throws what went wrong. Ends early where another was ordered.
  async function untilMade(id, turn) {
    while (turn === orders) {
      const found = await (await ask(`progress/${encodeURIComponent(id)}`)).json();
      if (found.error) throw new Error(found.error);
      if (found.is_ready) return;
      say(`${id}: ${found.doing}${found.of ? ` ${found.done} of ${found.of}` : ""}, ${found.seconds.toFixed(0)} s`);
      await pause(POLL_MS);
    }
  }

  // Shows a model; `pose` and `viewpoint` say how it is seen first. True where it is shown, and no other was ordered.
  async function load(id, pose, viewpoint) {
    const turn = orders;
    try {
      await untilMade(id, turn);
      if (turn !== orders) return false;
      say(`${id}: loading`);
      const name = encodeURIComponent(id);
      const [said, glb] = await Promise.all([ask(`facts/${name}`), ask(`model/${name}.glb`)]);
      const [nextFacts, bytes] = [await said.json(), await glb.arrayBuffer()];
      showing = showing.catch(() => {}).then(() => (turn === orders ? show(id, nextFacts, bytes, pose, viewpoint) : null));
      await showing;
      if (turn !== orders) return false;
      say("");
      requestAnimationFrame(() => requestAnimationFrame(() => {
        document.body.dataset.shown = id;
        document.body.dataset.shownMs = String(Math.round(performance.now()));
      }));
      return true;
    } catch (error) {
      if (turn !== orders) return false;
      fail(error);
      document.body.dataset.failed = id;
      ordered = shown || ordered;
      if (facts) fillSwap();
      return false;
    }
  }

  async function show(id, nextFacts, bytes, pose, viewpoint) {
    const extras = at("extras");
    document.body.append(extras); // the old viewer takes what is in it along
    viewer?.dispose();
    facts = nextFacts;
    shown = id;
    viewer = await casaViewer.mount(at("model"), bytes, { title: facts.title, viewpoint });
    const panel = at("model").querySelector(".cv-panel");
    panel.prepend(extras);
    extras.hidden = false;
    at("title").textContent = document.title = facts.title;
    at("sentence").textContent = facts.sentence;
    at("note").textContent = facts.note || "";
    at("note").hidden = !facts.note;
    at("links").replaceChildren(...(facts.report ? [make("a", { textContent: "Report", target: "_blank", href: `report/${encodeURIComponent(id)}/report.html` })] : []));
    machines = new Map(facts.machines.map((m) => [m.placement, { ...m, state: {}, touched: new Set(), since: performance.now() }]));
    fillSwap();
    fillRobots();
    fillMarks();
    fillStates();
    if (pose && viewer.poses().includes(pose)) viewer.setPose(pose);
    else if (pose) say(`no pose ${pose}; there are ${viewer.poses().join(", ")}`, true);
    viewer.onMove(({ name, position }) => moved(name, position));
    viewer.onPick((found) => { if (found?.placement || machines.has("")) reveal(found?.placement?.name ?? ""); });
    await Promise.all([...machines.keys()].map(step));
  }

  // State machines ----------------------------------------------------------------------------------------------------
  const placementOf = (joint) => joint.includes("/") ? joint.slice(0, joint.indexOf("/")) : "";
  const joined = (place, name) => place ? `${place}/${name}` : name;

  function fillStates() {
    at("states_section").hidden = !machines.size;
    at("states_section").open = machines.size < 3;
    at("states").replaceChildren(...[...machines.values()].map((machine) => {
      const chips = make("div", { className: "states" });
      const keys = machine.contacts.map((contact) => {
        const key = make("button", { type: "button", className: "press", textContent: `press ${words(contact.name)}` });
        key.addEventListener("click", () => press(machine, contact));
        return key;
      });
      machine.chips = chips;
      const name = words(machine.placement || facts.title);
      machine.box = make("details", { className: "thing", open: machines.size < 3 }, make("summary", { textContent: name }), chips, make("div", { className: "states" }, ...keys));
      return machine.box;
    }));
  }

  // Unfolds the states of what was clicked.
  function reveal(place) {
    const machine = machines.get(place);
    if (machine) at("states_section").open = machine.box.open = true;
  }

  // A joint has moved: its fixture may be in another state, and a key that is pressed is touched.
  function moved(name, position) {
    const place = placementOf(name), machine = machines.get(place);
    if (!machine) return;
    for (const contact of machine.contacts) {
      if (contact.joint === null || joined(place, contact.joint) !== name) continue;
      const { closed, open } = viewer.jointFacts().find((joint) => joint.name === name);
      if (Math.abs(position - closed) > 0.5 * Math.abs(open - closed)) machine.touched.add(contact.name);
    }
    stepSoon(machine);
  }

  function press(machine, contact) {
    if (contact.joint === null) {
      machine.touched.add(contact.name);
      step(machine.placement);
      return;
    }
    viewer.toggle(joined(machine.placement, contact.joint));
  }

  function stepSoon(machine) {
    machine.soon ??= setTimeout(() => { machine.soon = null; step(machine.placement); }, STEP_MS);
  }

  // One step on the server, one at a time for each fixture: the next needs the state that the last one gave.
  function step(place) {
    const machine = machines.get(place);
    machine.queue = (machine.queue ?? Promise.resolve()).then(() => stepNow(machine)).catch(fail);
    return machine.queue;
  }

  async function stepNow(machine) {
    if (machines.get(machine.placement) !== machine) return; // another kitchen is shown by now
    const positions = new Map(viewer.jointFacts().map(({ name, position }) => [name, position]));
    const joints = Object.fromEntries(machine.joints.map((name) => [name, positions.get(joined(machine.placement, name)) ?? 0]));
    const now = performance.now(), touched = [...machine.touched];
    machine.touched.clear();
    const body = { placement: machine.placement, joints, touched, dt_s: (now - machine.since) / 1000, ...machine.state };
    machine.since = now;
    const { effects, waits, ...state } = await (await ask(`step/${encodeURIComponent(shown)}`, body)).json();
    if (machines.get(machine.placement) !== machine) return;
    machine.state = state;
    showStates(machine, effects);
    clearTimeout(machine.timer);
    // What was touched is let go in the next step; a rule that counts seconds needs more of them.
    if (waits || touched.length) machine.timer = setTimeout(() => step(machine.placement), touched.length ? STEP_MS : TICK_MS);
  }

  function showStates(machine, effects) {
    const chips = Object.entries(machine.state.values).map(([name, value]) => {
      const isOn = value !== machine.variables[name][0];
      return make("span", { className: isOn ? "state acts" : "state", textContent: `${words(name)}: ${value}` });
    });
    const kinds = [...new Set(effects.map((effect) => effect.kind))].filter((kind) => !["show", "light"].includes(kind));
    if (kinds.length) chips.push(make("span", { className: "state acts", textContent: kinds.join(", ") }));
    machine.chips.replaceChildren(...chips);
    machine.box.classList.toggle("acts", effects.length > 0);
    machine.unglow?.();
    machine.unglow = viewer.addGlow(effects.filter((effect) => ["show", "light"].includes(effect.kind)).map((effect) => {
      const target = machine.targets[effect.target];
      return { ...target, node: joined(machine.placement, target.link), color: effect.color };
    }));
  }

  // Labels, and where robots park -------------------------------------------------------------------------------------
  const wanted = { labels: false, parking: false };
  let unmark = [];

  function fillMarks() {
    const names = { labels: "Labels", ...(facts.parking ? { parking: "Parking places" } : {}) };
    at("marks").replaceChildren(...Object.entries(names).map(([name, text]) => {
      const box = make("input", { type: "checkbox", checked: wanted[name], id: `mark_${name}` });
      box.addEventListener("change", () => { wanted[name] = box.checked; mark(); });
      return make("label", {}, box, text);
    }));
    mark();
  }

  function mark() {
    unmark.forEach((undo) => undo());
    unmark = [];
    if (wanted.labels) unmark.push(viewer.addLabels(facts.labels.map(({ node, text }) => ({ node, text: words(text) }))));
    if (!wanted.parking || !facts.parking) return;
    const spots = Object.entries(facts.parking).filter(([, spot]) => spot);
    unmark.push(viewer.addDiscs(spots.map(([place, { x, y, yaw }]) => ({ position: [x, y, 0], radius: facts.base_radius, yaw, color: colorOf(place) }))));
    if (!wanted.labels) return;
    // Several fixtures are served from one place.
    const served = new Map();
    for (const [place, spot] of spots) {
      const key = `${spot.x} ${spot.y}`;
      served.set(key, [...(served.get(key) ?? []), [place, spot]]);
    }
    unmark.push(viewer.addLabels([...served.values()].map((group) => ({
      position: [group[0][1].x, group[0][1].y, 0.05], text: group.map(([place]) => words(place)).join(", "), kind: "hint",
    }))));
  }

  function fillRobots() {
    const robots = facts.robots || [];
    at("reach").hidden = !robots.length;
    at("robot").replaceChildren(...robots.map(({ robot }) => new Option(robot, robot)));
    tellReach();
  }
  at("robot").addEventListener("change", () => { tellReach(); mark(); });

  const reachOf = () => Object.entries((facts.robots || []).find(({ robot }) => robot === at("robot").value)?.joints ?? {});

  function tellReach() {
    const found = reachOf().map(([, word]) => word);
    const opened = found.filter((word) => word === "opened").length;
    const reached = opened + found.filter((word) => word === "reached").length;
    at("reached").textContent = `reaches ${reached} of ${found.length} joints, opens ${opened}`;
    const missed = reachOf().filter(([, word]) => word !== "opened" && word !== "reached");
    at("missed").replaceChildren(...missed.map(([joint, word]) => make("li", { textContent: `${words(joint.replace("/", " "))}: ${word}` })));
  }

  // Of a fixture: what is true of all its joints that the robot was tried on.
  function colorOf(place) {
    const found = reachOf().filter(([joint]) => placementOf(joint) === place).map(([, word]) => word);
    if (!found.length) return PARKED.untried;
    if (found.every((word) => word === "opened")) return PARKED.opened;
    return found.some((word) => word === "opened" || word === "reached") ? PARKED.reached : PARKED.missed;
  }

  // Style and textures ------------------------------------------------------------------------------------------------
  function fillSwap() {
    at("swap").hidden = !facts.choice;
    if (!facts.choice) return;
    const { style, styles, surfaces, textures } = facts.choice;
    at("style").replaceChildren(...Object.keys(styles).map((name) => new Option(words(name), name, false, name === style)));
    at("style").title = styles[style];
    at("surfaces").replaceChildren(...Object.entries(textures).flatMap(([surface, names]) => {
      const label = make("label", { textContent: surface, htmlFor: `surface_${surface}` });
      const select = make("select", { id: `surface_${surface}` }, new Option("the style's own", ""));
      select.append(...names.map((name) => new Option(words(name), name, false, name === surfaces[surface])));
      select.addEventListener("change", () => order({ surfaces: { [surface]: select.value } }));
      return [label, select];
    }));
  }
  at("style").addEventListener("change", () => order({ style: at("style").value }));
  let draws = 0;
  at("random").addEventListener("click", () => order({ random: draws++ }));
  at("plain").addEventListener("click", () => order({ surfaces: { wall: "", floor: "", counter: "", cabinet: "" } }));

  // Another kitchen of the same plan takes the place of this one, seen from the same place with the same doors open.
  async function order(change) {
    const turn = ++orders;
    try {
      // One after another: each changes what the one before it has ordered.
      asking = asking.catch(() => {}).then(async () => {
        ordered = (await (await ask("order", { of: ordered, ...change })).json()).id;
        return ordered;
      });
      const id = await asking;
      if (turn !== orders) return;
      const stood = viewer.jointFacts();
      if (!await load(id, "", viewer.viewpoint())) return;
      const known = new Set(viewer.jointFacts().map(({ name }) => name));
      for (const { name, position } of stood) if (known.has(name)) viewer.setJoint(name, position);
    } catch (error) {
      if (turn !== orders) return;
      fail(error);
      fillSwap();
    }
  }

  load(start.first, start.pose);
})();
