// Joints of a model: where they stand, what opens them, and the motion of the nodes that they move.

import { Matrix4, Quaternion, Vector3 } from "three";

const MOTION_S = 0.55;

// One joint. `facts` is `extras.joint` of the node that it moves, see docs/howto/use/glb.md.
class Joint {
  constructor(node, facts, poses) {
    this.node = node;
    this.name = facts.name;
    this.link = node.userData.link;
    this.isHinge = facts.type === "hinge";
    this.axis = new Vector3(...facts.axis);
    this.anchor = new Vector3(...facts.anchor);
    [this.low, this.high] = facts.range;
    this.rest = facts.rest;
    this.behind = facts.behind;
    this.states = facts.states ?? {};
    this.position = facts.rest;
    this.placed = new Matrix4().compose(node.position, node.quaternion, node.scale);
    this.closed = Math.min(Math.max(poses.closed?.[this.name] ?? 0, this.low), this.high);
    this.open = this.openPosition(poses);
    // What is pressed with a finger comes back by itself.
    this.isPressed = !this.isHinge && this.high - this.low < 0.012;
  }

  // Where a click brings it: the first named pose in which it is not closed, else the far end of its range.
  openPosition(poses) {
    for (const name of ["open", "on", ...Object.keys(poses)]) {
      const at = poses[name]?.[this.name];
      if (at !== undefined && Math.abs(at - this.closed) > 1e-6) return at;
    }
    return this.high - this.closed >= this.closed - this.low ? this.high : this.low;
  }

  get share() {
    return this.open === this.closed ? 0 : (this.position - this.closed) / (this.open - this.closed);
  }

  move(position) {
    this.position = Math.min(Math.max(position, this.low), this.high);
    const by = this.position - this.rest;
    const motion = new Matrix4();
    if (this.isHinge) {
      motion.makeRotationFromQuaternion(new Quaternion().setFromAxisAngle(this.axis, by));
      const moved = this.anchor.clone().sub(this.anchor.clone().applyMatrix4(motion));
      motion.setPosition(moved);
    } else {
      motion.makeTranslation(this.axis.x * by, this.axis.y * by, this.axis.z * by);
    }
    motion.premultiply(this.placed).decompose(this.node.position, this.node.quaternion, this.node.scale);
  }
}

// All joints of a model. `onMove` is told of each joint that moved, `redraw` asks for a frame.
export class Joints {
  constructor(root, poses, onMove, redraw) {
    this.poses = poses;
    this.onMove = onMove;
    this.redraw = redraw;
    this.byName = new Map();
    this.running = new Map();
    root.traverse((node) => {
      const facts = node.userData.joint;
      if (facts) {
        const joint = new Joint(node, facts, poses);
        node.userData.moved = joint;
        this.byName.set(joint.name, joint);
      }
    });
  }

  get all() {
    return [...this.byName.values()];
  }

  named(name) {
    const joint = this.byName.get(name);
    if (!joint) throw new Error(`no joint "${name}"; there are ${[...this.byName.keys()].join(", ")}`);
    return joint;
  }

  set(name, position) {
    const joint = this.named(name);
    this.running.delete(joint);
    joint.move(position);
    this.onMove(joint);
    this.redraw();
  }

  // Glides to a position; at once where the user asked for less motion.
  glide(joint, position, after = null) {
    if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.set(joint.name, position);
      if (after) after();
      return;
    }
    this.running.set(joint, { from: joint.position, to: position, begin: performance.now(), after });
    this.redraw();
  }

  // Opens what is closed and closes what is open; before it, opens what it is behind.
  toggle(joint) {
    const opens = joint.share < 0.5;
    if (joint.isPressed) {
      this.glide(joint, joint.open, () => this.glide(joint, joint.closed));
      return;
    }
    const front = opens ? this.byName.get(joint.behind) : undefined;
    if (front && front.share < 0.5) {
      this.glide(front, front.open, () => this.glide(joint, joint.open));
      return;
    }
    if (!opens) {
      const inside = this.all.filter((one) => one.behind === joint.name && one.share > 0.02);
      if (inside.length) {
        inside.forEach((one, i) => this.glide(one, one.closed, i ? null : () => this.glide(joint, joint.closed)));
        return;
      }
    }
    this.glide(joint, opens ? joint.open : joint.closed);
  }

  setPose(name, glides = true) {
    const pose = this.poses[name];
    if (!pose) throw new Error(`no pose "${name}"; there are ${Object.keys(this.poses).join(", ")}`);
    for (const joint of this.all) {
      const position = pose[joint.name] ?? 0;
      if (glides) this.glide(joint, position);
      else this.set(joint.name, position);
    }
  }

  // Moves what glides; true while anything does.
  step(now) {
    for (const [joint, way] of this.running) {
      const share = Math.min((now - way.begin) / (MOTION_S * 1000), 1);
      const eased = share * share * (3 - 2 * share);
      joint.move(way.from + (way.to - way.from) * eased);
      if (share === 1) {
        this.running.delete(joint);
        if (way.after) way.after();
      }
      this.onMove(joint);
    }
    return this.running.size > 0;
  }
}
