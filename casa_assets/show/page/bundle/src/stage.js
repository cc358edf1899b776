// Light, ground, camera and drawing: a frame is drawn when something changed, and at no other time.

import {
  BackSide, Box3, Color, DirectionalLight, Float32BufferAttribute, Mesh, MeshBasicMaterial, NeutralToneMapping,
  PCFShadowMap, PerspectiveCamera, PlaneGeometry, PMREMGenerator, Quaternion, Scene, ShadowMaterial, Sphere,
  SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";

const FOV_DEG = 35;
const VIEW_FROM = new Vector3(0.62, 0.42, 1.0).normalize();
const TURN_RAD = Math.PI / 24;

export class Stage {
  constructor(canvas, isRoom) {
    this.canvas = canvas;
    this.isRoom = isRoom;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.scene = new Scene();
    const generator = new PMREMGenerator(this.renderer);
    const around = new RoomEnvironment();
    this.surroundings = generator.fromScene(around, 0.04);
    around.dispose();
    this.scene.environment = this.surroundings.texture;
    this.scene.environmentIntensity = isRoom ? 0.78 : 0.62;
    generator.dispose();
    this.camera = new PerspectiveCamera(FOV_DEG, 1, 0.01, 200);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.redraw());
    this.controls.zoomToCursor = true;
    this.beforeFrame = [];
    this.afterFrame = [];
    this.isAsked = false;
    this.bounds = new Box3();
  }

  // Shows a model: lights it, puts a ground below what is no room, and looks at it. A room is lit from the side of
  // `camera`, so that the walls that it looks at are bright.
  show(model, camera) {
    this.model = model;
    this.scene.add(model);
    this.measure();
    const sphere = this.bounds.getBoundingSphere(new Sphere());
    const sun = new DirectionalLight(new Color(1, 0.97, 0.92), this.isRoom ? 1.35 : 2.0);
    sun.position.copy(sphere.center).addScaledVector(this.sunFrom(camera, sphere.center), sphere.radius * 3);
    sun.target.position.copy(sphere.center);
    sun.castShadow = true;
    sun.shadow.mapSize.setScalar(this.isRoom ? 2048 : 1024);
    sun.shadow.radius = this.isRoom ? 4 : 7;
    sun.shadow.normalBias = sphere.radius * 0.004;
    sun.shadow.bias = -0.0004;
    const wide = sphere.radius * (this.isRoom ? 1.05 : 1.6);
    Object.assign(sun.shadow.camera, {
      left: -wide, right: wide, top: wide, bottom: -wide, near: sphere.radius, far: sphere.radius * 5,
    });
    this.scene.add(sun, sun.target);
    if (!this.isRoom) this.addGround(sphere);
    this.fit();
  }

  sunFrom(camera, center) {
    if (!this.isRoom || !camera) return new Vector3(0.55, 1, 0.6).normalize();
    const from = new Vector3().setFromMatrixPosition(camera.matrixWorld).sub(center).setY(0).normalize();
    return from.applyAxisAngle(new Vector3(0, 1, 0), -0.4).setY(1.15).normalize();
  }

  // A dome in the colours of the sky, seen through windows while the camera is in the room.
  addSky({ zenith, horizon }) {
    const dome = new SphereGeometry(1, 24, 16);
    const [top, low] = [new Color(...zenith), new Color(...horizon)];
    const colors = [];
    for (let i = 0; i < dome.attributes.position.count; i++) {
      const up = Math.max(dome.attributes.position.getY(i), 0);
      colors.push(...low.clone().lerp(top, Math.min(up * 2, 1)).toArray());
    }
    dome.setAttribute("color", new Float32BufferAttribute(colors, 3));
    this.sky = new Mesh(dome, new MeshBasicMaterial({ vertexColors: true, side: BackSide, depthWrite: false, toneMapped: false }));
    this.sky.renderOrder = -1;
    this.sky.scale.setScalar(this.bounds.getBoundingSphere(new Sphere()).radius * 4);
    this.bounds.getCenter(this.sky.position);
    this.sky.visible = false;
    this.scene.add(this.sky);
  }

  // True while the camera is in the room.
  get isInside() {
    return this.isRoom && this.bounds.containsPoint(this.camera.position);
  }

  addGround(sphere) {
    const ground = new Mesh(new PlaneGeometry(1, 1), new ShadowMaterial({ opacity: 0.28, transparent: true }));
    ground.rotation.x = -Math.PI / 2;
    ground.scale.setScalar(sphere.radius * 10);
    ground.position.set(sphere.center.x, this.bounds.min.y - sphere.radius * 0.002, sphere.center.z);
    ground.receiveShadow = true;
    this.scene.add(ground);
  }

  // Bounds of what is seen, world frame.
  measure() {
    this.bounds.makeEmpty();
    this.model.updateWorldMatrix(true, true);
    this.model.traverseVisible((node) => {
      if (node.isMesh) this.bounds.expandByObject(node);
    });
    if (this.bounds.isEmpty()) this.bounds.set(new Vector3(-0.5, -0.5, -0.5), new Vector3(0.5, 0.5, 0.5));
  }

  // Looks at all of it from the front, a little from the right and above.
  fit(from = VIEW_FROM) {
    this.measure();
    const center = this.bounds.getCenter(new Vector3());
    this.setLens(FOV_DEG);
    this.camera.position.copy(center).add(from);
    this.camera.lookAt(center);
    this.camera.updateMatrixWorld();
    // Smallest distance at which each corner of the box is within the picture.
    const toCamera = new Quaternion().copy(this.camera.quaternion).invert();
    const tall = Math.tan((this.camera.fov * Math.PI) / 360) * 0.92;
    const wide = tall * this.camera.aspect;
    const half = this.bounds.getSize(new Vector3()).multiplyScalar(0.5);
    let distance = 0;
    for (let i = 0; i < 8; i++) {
      const signs = new Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      const corner = signs.multiply(half).applyQuaternion(toCamera);
      distance = Math.max(distance, corner.z + Math.abs(corner.y) / tall, corner.z + Math.abs(corner.x) / wide);
    }
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(from, distance);
    this.setReach();
    this.controls.update();
    this.redraw();
  }

  // Looks as a camera of the file does; the point that the view turns about lies in the middle of what it sees.
  lookFrom(camera) {
    camera.updateWorldMatrix(true, false);
    const way = camera.getWorldDirection(new Vector3());
    this.camera.position.setFromMatrixPosition(camera.matrixWorld);
    const center = this.bounds.getCenter(new Vector3());
    const distance = Math.max(center.sub(this.camera.position).dot(way), 1);
    this.controls.target.copy(this.camera.position).addScaledVector(way, distance);
    this.setLens(camera.fov);
    this.setReach();
    this.controls.update();
    this.redraw();
  }

  // Where the view is from, for `standAt`: world frame, metres and degrees.
  viewpoint() {
    return { position: this.camera.position.toArray(), target: this.controls.target.toArray(), fovDeg: this.fovDeg };
  }

  standAt({ position, target, fovDeg }) {
    this.camera.position.fromArray(position);
    this.controls.target.fromArray(target);
    this.setLens(fovDeg);
    this.setReach();
    this.controls.update();
    this.redraw();
  }

  // In a picture taller than wide, a vertical angle of view that shows as much from side to side as a square one.
  setLens(fovDeg) {
    this.fovDeg = fovDeg;
    const half = Math.tan((fovDeg * Math.PI) / 360);
    const aspect = this.camera.aspect;
    this.camera.fov = (Math.atan(aspect < 1 ? Math.min(half / aspect, half * 1.6) : half) * 360) / Math.PI;
    this.camera.updateProjectionMatrix();
  }

  setReach() {
    const radius = this.bounds.getBoundingSphere(new Sphere()).radius;
    this.camera.near = Math.max(radius / 500, 0.002);
    this.camera.far = radius * 40;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = radius / 50;
    this.controls.maxDistance = radius * 12;
  }

  resize(width, height) {
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.setLens(this.fovDeg ?? FOV_DEG);
    this.redraw();
  }

  // Turns the view by steps about the vertical and up or down, as the arrow keys do.
  turn(aside, up) {
    const arm = this.camera.position.clone().sub(this.controls.target);
    const length = arm.length();
    const height = Math.min(Math.max(Math.acos(arm.y / length) - up * TURN_RAD, 0.02), Math.PI - 0.02);
    const around = Math.atan2(arm.x, arm.z) + aside * TURN_RAD;
    arm.setFromSphericalCoords(length, height, around);
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
    this.redraw();
  }

  // Moves the view aside and up by shares of what it sees.
  pan(aside, up) {
    const reach = this.camera.position.distanceTo(this.controls.target) * 0.06;
    const by = new Vector3(aside * reach, up * reach, 0).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.controls.update();
    this.redraw();
  }

  zoom(factor) {
    const arm = this.camera.position.clone().sub(this.controls.target);
    const { minDistance, maxDistance } = this.controls;
    arm.setLength(Math.min(Math.max(arm.length() * factor, minDistance), maxDistance));
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
    this.redraw();
  }

  redraw(withShadows = false) {
    if (withShadows) this.renderer.shadowMap.needsUpdate = true;
    if (this.isAsked || this.isGone) return;
    this.isAsked = true;
    requestAnimationFrame((now) => {
      this.isAsked = false;
      this.draw(now);
    });
  }

  draw(now) {
    if (this.isGone) return;
    if (this.sky) this.sky.visible = this.isInside;
    if (this.beforeFrame.map((step) => step(now)).some(Boolean)) this.redraw(true);
    this.renderer.render(this.scene, this.camera);
    this.afterFrame.forEach((step) => step());
  }

  dispose() {
    this.isGone = true;
    this.controls.dispose();
    this.scene.traverse((node) => {
      if (node.isLight) node.dispose();
      node.geometry?.dispose();
      for (const material of [node.material ?? []].flat()) {
        Object.values(material).forEach((value) => value?.isTexture && value.dispose());
        material.dispose();
      }
    });
    this.surroundings.dispose();
    this.renderer.dispose();
    // A browser keeps few WebGL contexts, and takes the oldest where there are more: it may be one that is looked at.
    this.renderer.forceContextLoss();
  }
}
