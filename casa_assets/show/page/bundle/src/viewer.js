// Shows a GLB of casa-assets in an element of a page: `casaViewer.mount(element, bytes, options)`.

import { FrontSide, Raycaster, Vector2 } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { addGlow } from "./glow.js";
import { Joints } from "./joints.js";
import { Labels } from "./labels.js";
import { Panel, sentence, told, words } from "./panel.js";
import { Stage } from "./stage.js";
import { addStyle } from "./style.js";

export { loadModel } from "./load.js";

// Layers that are hidden until somebody asks for them.
const HIDDEN_AT_FIRST = new Set(["collider", "region", "ceiling", "outside"]);
const CLICK_PX = 5;
const HELP = "Drag to turn, wheel or pinch to zoom, right button or two fingers to move. Keys: arrows turn, Shift and arrows move, "
  + "+ and − zoom, 0 shows all.";
const HELP_JOINTS = "Click a door to open it. ";

function element(tag, className, attributes = {}) {
  const made = document.createElement(tag);
  made.className = className;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// Shows a model.
//
// `place`: element of the page; what is in it is replaced. `bytes`: a GLB as ArrayBuffer or Uint8Array.
// `options`: `title` names the picture for screen readers; `panel: false` leaves the controls out; `pose` is a named pose
// to begin with; `view` the name of a camera of the file to look from; `layers` names of layers to show besides what is
// seen at first; `viewpoint` what `viewpoint()` of another viewer gave, to look from there.
//
// Resolves to the viewer:
//   jointFacts()                [{name, type, range, position, closed, open, states}] in rad and m
//   setJoint(name, position)    at once; animate: true glides there
//   toggle(name)                opens, closes or presses, as a click does
//   setPose(name), poses()
//   setLayer(name, isShown), layers()
//   look(name) a camera of the file, cameras(); fit(); turn(steps, steps); zoom(factor); viewpoint()
//   onPick(function)            called with {node, link, placement, joint} of what is clicked, or null; returns an undo
//   onMove(function)            called with {name, position} of each joint that moved
//   addLabels([{text, position | node, kind}]), addDiscs([{position, radius, color, yaw}]),
//     addGlow([{node, color, points, faces | shape, size, position, quaternion}]): return an undo, see their files
//   find(path)                  node of three.js; frame: the node with the axes of the record, z up
//   redraw(), picture() a PNG as data URL, dispose()
export async function mount(place, bytes, options = {}) {
  addStyle();
  const data = bytes instanceof Uint8Array ? bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) : bytes;
  const gltf = await new GLTFLoader().parseAsync(data, "");
  return new Viewer(place, gltf, options);
}

class Viewer {
  constructor(place, gltf, options) {
    this.frame = gltf.scene.children[0];
    this.facts = this.frame.userData;
    const isRoom = this.facts.kind === "scene";
    this.build(place, options.title ?? this.facts.id ?? "3D model");
    this.stage = new Stage(this.canvas, isRoom);
    this.prepare(gltf.scene);
    this.cameraOf = new Map(gltf.cameras.map((camera) => [(camera.userData.name ?? camera.name).replace(/^camera\//, ""), camera]));
    this.pickers = [];
    this.movers = [];
    this.joints = new Joints(gltf.scene, this.facts.poses ?? {}, (joint) => this.moved(joint), () => this.stage.redraw(true));
    this.stage.beforeFrame.push((now) => this.joints.step(now));
    this.labels = new Labels(this.stage, this.wordBox, this.frame);
    if (options.panel !== false) this.addPanel();
    if (options.panel === false || this.panel.isEmpty) {
      this.panelBox.remove();
      this.box.classList.add("cv-bare");
    }
    this.watchSize();
    this.stage.show(gltf.scene, this.cameraOf.get("overview"));
    if (isRoom && this.facts.sky) this.stage.addSky(this.facts.sky);
    this.closeRoom();
    this.stage.redraw(true);
    for (const layer of options.layers ?? []) this.setLayer(layer, true);
    if (options.pose) this.joints.setPose(options.pose, false);
    const first = options.view ?? (isRoom && this.cameraOf.has("overview") ? "overview" : "");
    this.look(first);
    if (options.viewpoint) this.stage.standAt(options.viewpoint);
    this.listen();
    this.stage.afterFrame.push(() => (this.box.dataset.state = "ready"));
  }

  build(place, title) {
    this.box = element("div", "cv");
    const view = element("div", "cv-view");
    this.canvas = element("canvas", "", { tabindex: "0", role: "application", "aria-label": `${title}. ${HELP}` });
    this.canvas.setAttribute("aria-roledescription", "3D view");
    this.wordBox = element("div", "cv-words", { "aria-hidden": "true" });
    this.tip = element("div", "cv-tip", { "aria-hidden": "true" });
    this.tip.hidden = true;
    this.said = element("div", "cv-said", { role: "status" });
    const tools = element("div", "cv-tools");
    for (const [sign, label, act] of [
      ["+", "Zoom in", () => this.stage.zoom(0.8)],
      ["−", "Zoom out", () => this.stage.zoom(1.25)],
      ["⟲", "Show all", () => this.look("")],
    ]) {
      const button = element("button", "", { type: "button", "aria-label": label, title: label });
      button.textContent = sign;
      button.addEventListener("click", act);
      tools.append(button);
    }
    this.panelBox = element("div", "cv-panel", { role: "region", "aria-label": `Controls of ${title}`, tabindex: "0" });
    view.append(this.canvas, this.wordBox, this.tip, tools, this.said);
    this.box.append(view, this.panelBox);
    place.replaceChildren(this.box);
    this.view = view;
  }

  // Shadows, sharp pictures, layers.
  prepare(root) {
    this.layerNodes = new Map();
    const anisotropy = Math.min(8, this.stage.renderer.capabilities.getMaxAnisotropy());
    root.traverse((node) => {
      const { layer } = node.userData;
      if (layer) {
        if (!this.layerNodes.has(layer)) this.layerNodes.set(layer, []);
        this.layerNodes.get(layer).push(node);
        node.visible = !HIDDEN_AT_FIRST.has(layer);
      }
      if (!node.isMesh) return;
      const { material } = node;
      const isSeen = !["collider", "region"].includes(layerOf(node));
      // Light passes through glass, and through the ceiling, which is often left out; what explains darkens nothing.
      node.castShadow = isSeen && layerOf(node) !== "ceiling" && !(material.transparent && material.opacity < 0.9);
      node.receiveShadow = isSeen;
      for (const map of [material.map, material.normalMap, material.roughnessMap]) if (map) map.anisotropy = anisotropy;
      if (!isSeen) material.depthWrite = false;
      else material.shadowSide = FrontSide;
    });
  }

  // From inside, the ceiling is there; from outside it is left out, until somebody asks for the one or the other.
  closeRoom() {
    const ceiling = this.layerNodes.get("ceiling");
    if (!ceiling) return;
    this.stage.beforeFrame.push(() => {
      const isSeen = this.stage.isInside;
      if (!this.isCeilingChosen && ceiling[0].visible !== isSeen) {
        ceiling.forEach((node) => (node.visible = isSeen));
        this.panel?.showLayer("ceiling", isSeen);
      }
      return false;
    });
  }

  addPanel() {
    this.panel = new Panel({
      box: this.panelBox,
      joints: this.joints,
      poses: this.poses(),
      layers: this.layers().map(({ name }) => name),
      cameras: this.cameras(),
      actions: {
        setPose: (name) => this.setPose(name),
        setLayer: (name, isShown) => this.setLayer(name, isShown),
        setJoint: (name, position) => this.joints.set(name, position),
        toggle: (joint) => this.toggle(joint.name),
        look: (name) => this.look(name),
      },
    });
    for (const { name, isShown } of this.layers()) this.panel.showLayer(name, isShown);
    const help = element("p", "cv-help");
    help.textContent = (this.joints.all.length ? HELP_JOINTS : "") + HELP;
    this.panelBox.append(help);
  }

  watchSize() {
    const fit = () => this.stage.resize(this.view.clientWidth, this.view.clientHeight);
    this.sizes = new ResizeObserver(fit);
    this.sizes.observe(this.view);
    fit();
  }

  listen() {
    let down = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      down = event.isPrimary && event.button === 0 ? [event.clientX, event.clientY] : null;
    });
    this.canvas.addEventListener("pointerup", (event) => {
      const isClick = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < CLICK_PX;
      down = null;
      if (isClick) this.click(this.hit(event));
    });
    let hover = null;
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.pointerType !== "mouse" || event.buttons) return;
      if (!hover) requestAnimationFrame(() => {
        if (hover) this.point(this.hit(hover));
        hover = null;
      });
      hover = event;
    });
    this.canvas.addEventListener("pointerleave", () => {
      hover = null;
      this.point(null);
    });
    this.canvas.addEventListener("keydown", (event) => this.press(event));
    this.canvas.addEventListener("webglcontextrestored", () => this.stage.redraw(true));
  }

  press(event) {
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const { stage } = this;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (ways[event.key]) event.shiftKey ? stage.pan(...ways[event.key]) : stage.turn(...ways[event.key]);
    else if (["+", "="].includes(event.key)) stage.zoom(0.88);
    else if (["-", "_"].includes(event.key)) stage.zoom(1 / 0.88);
    else if (["0", "Home"].includes(event.key)) this.look("");
    else return;
    event.preventDefault();
  }

  // What is seen at a place of the picture; null where there is nothing.
  hit(event) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.stage.camera);
    const seen = [];
    this.frame.traverseVisible((node) => {
      if (node.isMesh && layerOf(node) !== "region") seen.push(node);
    });
    const [first] = ray.intersectObjects(seen, false);
    return first ? this.about(first.object) : null;
  }

  about(node) {
    const found = { node, link: null, placement: null, joint: null };
    for (let one = node; one; one = one.parent) {
      found.link ??= one.userData.link ?? null;
      found.joint ??= one.userData.moved ?? null;
      found.placement ??= one.userData.placement ?? null;
      if (one.userData.placement) break; // what lies in a drawer is not the drawer
    }
    return found;
  }

  // `Main range: door`, or `Door` where there is one thing alone.
  partName(joint) {
    const owner = joint.name.includes("/") ? `${words(joint.name.split("/")[0])}: ` : "";
    return sentence(owner + words(joint.link));
  }

  nameOf(found) {
    const owner = found.placement ? words(found.placement.name) : "";
    const part = found.link && found.link !== "object" ? words(found.link) : "";
    const where = found.joint ? `, ${told(found.joint)}` : "";
    return sentence([owner, part].filter(Boolean).join(": ") || words(this.facts.category ?? this.facts.id)) + where;
  }

  point(found) {
    this.canvas.classList.toggle("cv-hot", Boolean(found?.joint));
    this.tip.hidden = !found;
    if (found) this.tip.textContent = this.nameOf(found);
  }

  click(found) {
    for (const pick of this.pickers) {
      if (pick(found && { ...found, joint: found.joint?.name ?? null }) === false) return;
    }
    if (found?.joint) this.toggle(found.joint.name);
  }

  toggle(name) {
    const joint = this.joints.named(name);
    // Before it moves: where the user asked for less motion it is at its end at once.
    const word = joint.isPressed ? "is pressed" : joint.share < 0.5 ? "opens" : "closes";
    this.joints.toggle(joint);
    this.panel?.reveal(joint);
    this.said.textContent = `${this.partName(joint)} ${word}`;
  }

  moved(joint) {
    this.panel?.showJoint(joint);
    this.movers.forEach((told) => told({ name: joint.name, position: joint.position }));
  }

  setJoint(name, position, { animate = false } = {}) {
    if (animate) this.joints.glide(this.joints.named(name), position);
    else this.joints.set(name, position);
  }

  setPose(name) {
    this.joints.setPose(name);
    this.said.textContent = `Pose: ${words(name)}`;
  }

  poses() {
    const order = ["closed", "open", "on"];
    const rank = (name) => (order.includes(name) ? order.indexOf(name) : order.length);
    if (!this.joints.all.length) return [];
    const names = Object.keys(this.facts.poses ?? {});
    return names.sort((a, b) => rank(a) - rank(b));
  }

  setLayer(name, isShown) {
    const nodes = this.layerNodes.get(name);
    if (!nodes) throw new Error(`no layer "${name}"; there are ${[...this.layerNodes.keys()].join(", ")}`);
    nodes.forEach((node) => (node.visible = isShown));
    if (name === "ceiling") this.isCeilingChosen = true;
    this.panel?.showLayer(name, isShown);
    this.stage.redraw(true);
  }

  layers() {
    return [...this.layerNodes].map(([name, nodes]) => ({ name, isShown: nodes[0].visible }));
  }

  look(name) {
    if (name && !this.cameraOf.has(name)) throw new Error(`no view "${name}"; there are ${this.cameras().join(", ")}`);
    if (name) this.stage.lookFrom(this.cameraOf.get(name));
    else this.stage.fit();
    this.panel?.showView(name);
  }

  cameras() {
    return [...this.cameraOf.keys()];
  }

  fit() {
    this.look("");
  }

  turn(aside, up = 0) {
    this.stage.turn(aside, up);
  }

  zoom(factor) {
    this.stage.zoom(factor);
  }

  find(path) {
    let found = null;
    this.frame.traverse((node) => (found ??= node.userData.name === path ? node : null));
    if (!found) throw new Error(`the model has no node "${path}"`);
    return found;
  }

  onPick(told) {
    this.pickers.push(told);
    return () => (this.pickers = this.pickers.filter((one) => one !== told));
  }

  onMove(told) {
    this.movers.push(told);
    return () => (this.movers = this.movers.filter((one) => one !== told));
  }

  addLabels(labels) {
    return this.labels.add(labels, (path) => this.find(path));
  }

  addDiscs(discs) {
    return this.labels.addDiscs(discs);
  }

  addGlow(shapes) {
    return addGlow(shapes, (path) => this.find(path), () => this.stage.redraw());
  }

  viewpoint() {
    return this.stage.viewpoint();
  }

  jointFacts() {
    return this.joints.all.map(({ name, isHinge, low, high, position, closed, open, states }) => (
      { name, type: isHinge ? "hinge" : "slide", range: [low, high], position, closed, open, states }
    ));
  }

  redraw() {
    this.stage.redraw(true);
  }

  picture() {
    this.stage.renderer.shadowMap.needsUpdate = true;
    this.stage.draw(performance.now());
    return this.canvas.toDataURL("image/png");
  }

  dispose() {
    this.sizes.disconnect();
    this.stage.dispose();
    this.box.remove();
  }
}

function layerOf(node) {
  for (let one = node; one; one = one.parent) if (one.userData.layer) return one.userData.layer;
  return "";
}
