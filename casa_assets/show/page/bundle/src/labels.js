// Words at places of the model: elements of the page that follow the picture, and discs on the floor.

import {
  CircleGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, RingGeometry, Shape, ShapeGeometry, Vector2, Vector3,
} from "three";

// Along x, for a disc of radius 1.
const ARROW = new Shape([[0.8, 0], [-0.3, 0.4], [-0.1, 0], [-0.3, -0.4]].map(([x, y]) => new Vector2(x, y)));

export class Labels {
  // `frame` is the node whose frame is that of the file's record: z up, metres.
  constructor(stage, box, frame) {
    this.stage = stage;
    this.frame = frame;
    this.box = box;
    this.items = [];
    stage.afterFrame.push(() => this.place());
  }

  // Puts up words. Each of `labels`: `text`, and `position` [x, y, z] (z up, metres) or `node`, a path in the file.
  // Returns a function that takes them away again.
  add(labels, findNode) {
    const added = labels.map(({ text, position, node, kind }) => {
      const element = document.createElement("div");
      element.className = `cv-label ${kind ? `cv-label-${kind}` : ""}`;
      element.textContent = text;
      this.box.append(element);
      return { element, anchor: node ? middleOf(findNode(node)) : { node: this.frame, at: new Vector3(...position) } };
    });
    this.items.push(...added);
    this.stage.redraw();
    return () => {
      added.forEach((item) => item.element.remove());
      this.items = this.items.filter((item) => !added.includes(item));
      this.stage.redraw();
    };
  }

  // Puts discs on the floor. Each of `discs`: `position` [x, y, z], `radius` in metres, `color` as in CSS, and
  // `yaw` where it has a front: radians to the left of x, shown by an arrow.
  addDiscs(discs) {
    const group = new Group();
    for (const { position, radius, color, yaw } of discs) {
      const look = { color, transparent: true, side: DoubleSide, depthWrite: false };
      const inner = new Mesh(new CircleGeometry(radius, 48), new MeshBasicMaterial({ ...look, opacity: 0.25 }));
      const rim = new Mesh(new RingGeometry(radius * 0.94, radius, 48), new MeshBasicMaterial({ ...look, opacity: 0.9 }));
      for (const part of [inner, rim]) part.position.set(position[0], position[1], position[2] + 0.004);
      group.add(inner, rim);
      if (yaw !== undefined) {
        const arrow = new Mesh(new ShapeGeometry(ARROW), new MeshBasicMaterial({ ...look, opacity: 0.9 }));
        arrow.position.set(position[0], position[1], position[2] + 0.006);
        arrow.scale.setScalar(radius);
        arrow.rotation.z = yaw;
        group.add(arrow);
      }
    }
    this.frame.add(group);
    this.stage.redraw();
    return () => {
      this.frame.remove(group);
      group.traverse((node) => (node.geometry?.dispose(), node.material?.dispose()));
      this.stage.redraw();
    };
  }

  place() {
    const { clientWidth: width, clientHeight: height } = this.stage.canvas;
    const at = new Vector3();
    for (const { element, anchor } of this.items) {
      at.copy(anchor.at).applyMatrix4(anchor.node.matrixWorld).project(this.stage.camera);
      const isSeen = at.z < 1 && Math.abs(at.x) < 1.05 && Math.abs(at.y) < 1.05;
      element.hidden = !isSeen;
      if (isSeen) {
        const x = ((at.x + 1) / 2) * width;
        const y = ((1 - at.y) / 2) * height;
        element.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      }
    }
  }
}

// The middle of what a node shows, in its own frame.
function middleOf(node) {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = low.clone().negate();
  const back = node.matrixWorld.clone().invert();
  node.traverse((one) => {
    if (!one.isMesh || !one.visible) return;
    one.geometry.computeBoundingBox();
    const box = one.geometry.boundingBox.clone().applyMatrix4(one.matrixWorld).applyMatrix4(back);
    low.min(box.min);
    high.max(box.max);
  });
  const at = low.x <= high.x ? low.add(high).multiplyScalar(0.5) : new Vector3();
  return { node, at };
}
