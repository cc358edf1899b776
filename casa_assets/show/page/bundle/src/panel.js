// The controls beside the picture: poses, views, layers, and a slider for each joint, all reached by keyboard.

const LAYERS = [
  ["visual", "Surfaces"],
  ["collider", "Colliders"],
  ["region", "Regions"],
  ["ceiling", "Ceiling"],
  ["outside", "Outer walls"],
];
const FEW_JOINTS = 10;

let ids = 0;

function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== false && value != null) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

// `upper_leftdoor` -> `upper left door`, `drawer0` -> `drawer 0`.
export function words(name) {
  return name.replace(/(left|right)(?=door)/g, "$1 ").replace(/([a-z])(\d)/g, "$1 $2").replaceAll("_", " ");
}

export function sentence(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

// How far a joint is from closed, with its unit: degrees, centimetres, or millimetres of what is pressed.
export function told(joint) {
  const way = Math.abs(joint.position - joint.closed);
  if (joint.isHinge) return `${Math.round((way * 180) / Math.PI)}°`;
  if (joint.high - joint.low < 0.02) return `${(way * 1000).toFixed(1)} mm`;
  return `${(way * 100).toFixed(1)} cm`;
}

function spoken(joint) {
  return told(joint).replace("°", " degrees").replace(" cm", " centimetres").replace(" mm", " millimetres");
}

export class Panel {
  constructor({ box, joints, poses, layers, cameras, actions }) {
    this.rows = new Map();
    this.joints = joints;
    this.actions = actions;
    this.layerBoxes = new Map();
    const parts = [];
    if (poses.length) parts.push(this.group("Pose", poses.map((name) => this.poseButton(name))));
    if (cameras.length) parts.push(this.views(cameras));
    if (layers.length > 1) parts.push(this.group("Show", layers.map((name) => this.layerBox(name))));
    if (joints.all.length) parts.push(this.jointList());
    box.append(...parts);
    this.isEmpty = !parts.length;
  }

  group(title, children) {
    const id = `cv-${++ids}`;
    return make(
      "div", { class: "cv-group", role: "group", "aria-labelledby": id },
      make("div", { class: "cv-title", id }, title), make("div", { class: "cv-row" }, ...children),
    );
  }

  poseButton(name) {
    return make("button", { type: "button", class: "cv-button", onclick: () => this.actions.setPose(name) }, sentence(words(name)));
  }

  views(cameras) {
    const id = `cv-${++ids}`;
    const select = make(
      "select", { id, class: "cv-select", onchange: () => this.actions.look(select.value) },
      make("option", { value: "" }, "Whole"),
      ...cameras.map((name) => make("option", { value: name }, sentence(words(name)))),
    );
    this.viewSelect = select;
    return make("div", { class: "cv-group" }, make("label", { class: "cv-title", for: id }, "View"), select);
  }

  showView(name) {
    if (this.viewSelect) this.viewSelect.value = name;
  }

  layerBox(name) {
    const title = LAYERS.find(([layer]) => layer === name)?.[1] ?? sentence(words(name));
    const box = make("input", { type: "checkbox", onchange: () => this.actions.setLayer(name, box.checked) });
    this.layerBoxes.set(name, box);
    return make("label", { class: "cv-check" }, box, title);
  }

  showLayer(name, isShown) {
    const box = this.layerBoxes.get(name);
    if (box) box.checked = isShown;
  }

  jointList() {
    const groups = new Map();
    for (const joint of this.joints.all) {
      const cut = joint.name.indexOf("/");
      const owner = cut < 0 ? "" : joint.name.slice(0, cut);
      if (!groups.has(owner)) groups.set(owner, []);
      groups.get(owner).push(joint);
    }
    const isLong = this.joints.all.length > FEW_JOINTS;
    const lists = [...groups].map(([owner, members]) => {
      const rows = members.map((joint) => this.jointRow(joint, owner));
      if (!owner) return make("div", {}, ...rows);
      return make("details", { class: "cv-owner", open: !isLong }, make("summary", {}, sentence(words(owner))), ...rows);
    });
    const found = this.group("Joints", []);
    found.classList.add("cv-joints");
    if (isLong) found.append(this.search(lists));
    found.append(...lists);
    return found;
  }

  search(lists) {
    const input = make("input", {
      type: "search", class: "cv-search", placeholder: "fridge door …", "aria-label": "Find a joint",
      oninput: () => {
        const asked = input.value.toLowerCase().split(/\s+/).filter(Boolean);
        for (const list of lists) {
          let count = 0;
          for (const row of list.querySelectorAll(".cv-joint")) {
            row.hidden = !asked.every((word) => row.dataset.words.includes(word));
            count += row.hidden ? 0 : 1;
          }
          list.hidden = !count;
          if (list.tagName === "DETAILS") list.open = asked.length > 0;
        }
      },
    });
    return input;
  }

  jointRow(joint, owner) {
    const id = `cv-${++ids}`;
    // From closed on the left to open on the right, whichever way the joint counts.
    const isTurned = joint.open < joint.closed;
    const [low, high] = isTurned ? [-joint.high, -joint.low] : [joint.low, joint.high];
    const slider = make("input", {
      type: "range", id, min: low, max: high, step: (high - low) / 200, value: isTurned ? -joint.position : joint.position,
      oninput: () => this.actions.setJoint(joint.name, isTurned ? -Number(slider.value) : Number(slider.value)),
    });
    const output = make("output", { for: id });
    const button = make("button", { type: "button", class: "cv-toggle", onclick: () => this.actions.toggle(joint) });
    const name = sentence(words(joint.link));
    const row = make(
      "div", { class: "cv-joint", "data-joint": joint.name, "data-words": `${words(owner)} ${words(joint.link)}`.toLowerCase() },
      make("label", { for: id }, name), output, slider, button,
    );
    this.rows.set(joint, { slider, output, button, row, isTurned, name });
    this.showJoint(joint);
    return row;
  }

  // Follows a joint that was moved.
  showJoint(joint) {
    const found = this.rows.get(joint);
    if (!found) return;
    const { slider, output, button, isTurned, name } = found;
    slider.value = isTurned ? -joint.position : joint.position;
    slider.setAttribute("aria-valuetext", spoken(joint));
    output.textContent = told(joint);
    const word = joint.isPressed ? "Press" : joint.share < 0.5 ? "Open" : "Close";
    button.textContent = word;
    button.setAttribute("aria-label", `${word} ${name}`);
  }

  // Unfolds and marks the row of a joint.
  reveal(joint) {
    const found = this.rows.get(joint);
    if (!found) return;
    const owner = found.row.closest("details");
    if (owner) owner.open = true;
    this.rows.forEach(({ row }) => row.classList.toggle("cv-chosen", row === found.row));
    found.row.scrollIntoView({ block: "nearest" });
  }
}
