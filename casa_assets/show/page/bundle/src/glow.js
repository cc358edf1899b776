// What gives light by itself: flames, running water, lamps that are on. Shapes in the frames of nodes of the model.

import {
  BoxGeometry, BufferGeometry, Color, CylinderGeometry, Float32BufferAttribute, Mesh, MeshBasicMaterial, SphereGeometry,
} from "three";

const LEAST_OPACITY = 0.35;

// Adds shapes to the model. Each of `shapes`: `node`, a path in the file; `color`, linear RGBA; and either `points` and
// `faces` of a mesh, or `shape` (`sphere`, `box`, or `cylinder` about z) with its full `size`, `position` and
// `quaternion` (w, x, y, z); metres, frame of the node. Returns a function that takes them away again.
export function addGlow(shapes, findNode, redraw) {
  const added = shapes.map((shape) => {
    const mesh = new Mesh(geometryOf(shape), materialOf(shape));
    if (shape.position) mesh.position.set(...shape.position);
    if (shape.quaternion) {
      const [w, x, y, z] = shape.quaternion;
      mesh.quaternion.set(x, y, z, w);
    }
    mesh.raycast = () => {}; // a click goes through it
    findNode(shape.node).add(mesh);
    return mesh;
  });
  redraw();
  return () => {
    for (const mesh of added) {
      mesh.removeFromParent();
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
    redraw();
  };
}

function geometryOf({ points, faces, shape, size }) {
  if (points) {
    const made = new BufferGeometry();
    made.setAttribute("position", new Float32BufferAttribute(points.flat(), 3));
    made.setIndex(faces.flat());
    return made;
  }
  if (shape === "box") return new BoxGeometry(...size);
  if (shape === "sphere") return new SphereGeometry(size[0] / 2, 24, 16);
  return new CylinderGeometry(0.5, 0.5, 1, 32).rotateX(Math.PI / 2).scale(...size);
}

// A mesh of the model lies in the very place of what is seen there, so it is drawn in front of that; a flame or a stream
// is seen through.
function materialOf({ points, color: [red, green, blue, opacity] }) {
  const look = { color: new Color(red, green, blue), toneMapped: false };
  if (points) return new MeshBasicMaterial({ ...look, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2 });
  return new MeshBasicMaterial({ ...look, transparent: true, opacity: Math.max(opacity, LEAST_OPACITY), depthWrite: false });
}
