// A take in three dimensions: binary glTF, turned by the mouse, at any time of its motion.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { Detail, shareSkeletons } from "./detail.js";
import { isNamedSoftware, Pace } from "./pace.js";

const GROWN = 0.08; // share by which a creature grows or shrinks until it is looked at anew
const AWAY = { spot: 1.35, scene: 1.75 }; // sizes of what is looked at, from its middle
const REST = 180; // ms after which a view that moved no more is drawn in full
const AXIS = new THREE.Vector3();
const PLACE = new THREE.Vector3();
const TURN = new THREE.Quaternion();

// A material that takes little to draw without a graphics processor.
function plain({ color, opacity, transparent, emissive, vertexColors, side, name }) {
  return new THREE.MeshLambertMaterial({ color, opacity, transparent, emissive, vertexColors, side, name });
}

function performerOf(object) {
  for (; object; object = object.parent) if (object.userData.performer) return object.userData.performer;
  return null;
}

export class Viewer {
  constructor(canvas, { onTheSpot = false } = {}) {
    this.canvas = canvas;
    this.onTheSpot = onTheSpot;
    this.pace = new Pace(isNamedSoftware());
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.pace.isLight });
    this.renderer.setPixelRatio(this.pace.isLight ? 1 : Math.min(devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(onTheSpot ? "#e9ecef" : "#c9d9e6");
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.02, 400);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw(true));
    this.sky = new THREE.HemisphereLight("#ffffff", "#8a7f70", 1.6);
    this.sun = new THREE.DirectionalLight("#fff3df", 2.2);
    this.sun.position.set(2, 5, 3);
    this.scene.add(this.sky, this.sun);
    if (onTheSpot) {
      this.grid = new THREE.GridHelper(24, 24, "#b9b4a8", "#d7d3c8");
      this.scene.add(this.grid);
    }
    this.model = null;
    this.roots = new Map();
    this.nodes = new Map();
    this.scale = 1;
    this.time = 0;
    this.filmCamera = null;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  clear() {
    this.detail?.dispose();
    this.detail = this.action = null;
    this.roots = new Map();
    this.nodes = new Map();
    this.helpers = [];
    if (!this.model) return;
    this.mixer.stopAllAction();
    this.scene.remove(this.model);
    this.model.traverse((object) => {
      object.geometry?.dispose();
      object.skeleton?.dispose();
      object.material?.dispose();
    });
    this.model = null;
  }

  async show(bytes) {
    const gltf = await new GLTFLoader().parseAsync(bytes, "");
    const isFirst = this.model === null;
    this.clear();
    this.model = gltf.scene;
    this.scene.add(this.model);
    this.model.traverse((object) => {
      object.frustumCulled = false;
      const { performer: who, name } = object.userData;
      if (who && !object.isMesh) {
        if (!this.roots.has(who)) this.roots.set(who, object);
        if (name && !object.userData.part) this.nodes.set(name, object);
      } else if (name?.includes("~") && !name.endsWith("~shown")) {
        const [first, second, share] = name.split("~");
        if (share > 0) this.helpers.push({ object, first, second, share: Number(share) });
      }
      // Of the rest pose, which motion replaces.
      object.userData.place = object.position.clone();
    });
    const meshes = [];
    this.model.traverse((object) => object.isMesh && meshes.push(object));
    shareSkeletons(meshes);
    if (this.pace.isLight) this.#lighten();
    this.detail = new Detail(this.model, this.roots, this.pace.budget);
    this.mixer = new THREE.AnimationMixer(this.model);
    if (gltf.animations.length) {
      this.action = this.mixer.clipAction(gltf.animations[0]);
      this.action.setLoop(THREE.LoopOnce);
      this.action.clampWhenFinished = true;
      this.action.play();
    }
    this.seek(this.time);
    if (isFirst || this.onTheSpot) this.fit(isFirst);
    this.draw();
  }

  // Gives all meshes materials that take little to draw.
  #lighten() {
    this.model.traverse((object) => {
      if (!object.isMesh) return;
      object.material.dispose();
      if (performerOf(object)) object.material = plain(object.material);
      else this.#light(object);
    });
  }

  // Gives a mesh that stands still the light at its vertices: it covers most of the picture, and
  // without a graphics processor each pixel of it that is lit takes time.
  #light(mesh) {
    const { normal } = mesh.geometry.attributes;
    const towards = this.sun.position.clone().normalize();
    const [sum, own, turned] = [new THREE.Color(), new THREE.Color(), new THREE.Vector3()];
    const colors = new Float32Array(3 * normal.count);
    for (let v = 0; v < normal.count; v++) {
      turned.fromBufferAttribute(normal, v);
      sum.copy(this.sky.groundColor).lerp(this.sky.color, 0.5 * turned.y + 0.5).multiplyScalar(this.sky.intensity);
      sum.add(own.copy(this.sun.color).multiplyScalar(this.sun.intensity * Math.max(turned.dot(towards), 0)));
      sum.multiply(mesh.material.color).multiplyScalar(1 / Math.PI).toArray(colors, 3 * v);
    }
    mesh.geometry.setAttribute("color", new THREE.BufferAttribute(colors, 3));
    mesh.material = new THREE.MeshBasicMaterial({ vertexColors: true });
  }

  // Creatures alone: the ground is far larger than what is watched.
  bounds() {
    const box = new THREE.Box3();
    const place = new THREE.Vector3();
    for (const [, root] of this.roots) {
      root.traverse((object) => box.expandByPoint(object.getWorldPosition(place)));
    }
    return box;
  }

  // Looks at the creatures; where nothing forces it, only when their size has become another, and
  // from where they were seen.
  fit(isForced = true) {
    this.model.updateMatrixWorld(true);
    const box = this.onTheSpot ? new THREE.Box3().setFromObject(this.model) : this.bounds();
    if (box.isEmpty()) return;
    const middle = box.getCenter(new THREE.Vector3());
    const size = Math.max(box.getSize(new THREE.Vector3()).length(), 0.5);
    if (!isForced && Math.abs(Math.log(size / this.fitted)) < GROWN) return;
    this.fitted = size;
    const from = isForced ? new THREE.Vector3(0.9, 0.55, 1.1) : this.camera.position.clone().sub(this.controls.target);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(from.normalize(), size * (this.onTheSpot ? AWAY.spot : AWAY.scene));
    this.camera.near = size / 100;
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  seek(time) {
    this.time = time;
    if (!this.model) return;
    this.mixer.setTime(time);
    if (this.onTheSpot) {
      const [root] = this.roots.values();
      this.model.position.set(0, 0, 0);
      this.model.updateMatrixWorld(true);
      const at = root ? root.getWorldPosition(PLACE) : PLACE.set(0, 0, 0);
      this.model.position.set(-at.x, 0, -at.z);
      this.grid.position.set(-(at.x % 1), 0, -(at.z % 1));
    }
  }

  // The pose of a node in the world at this moment, null where it is not there.
  poseOf(name) {
    const node = this.nodes.get(name);
    node?.updateWorldMatrix(true, false);
    return node?.matrixWorld ?? null;
  }

  // The node of a link of the first performer.
  nodeOf(link) {
    const [who] = this.roots.keys();
    return this.nodes.get(`${who}.${link}`);
  }

  // Poses the first performer where it is by values of its joints, links after their parents.
  pose(links, valueOf) {
    if (!this.model) return;
    const turn = new THREE.Quaternion();
    for (const link of links) {
      const node = this.nodeOf(link.name);
      if (!node) continue;
      turn.identity();
      node.position.copy(node.userData.place);
      for (const joint of link.joints) {
        const value = valueOf(link, joint);
        const axis = AXIS.set(...joint.axis).normalize();
        if (joint.slides) node.position.addScaledVector(axis, value * this.scale);
        else turn.multiply(TURN.setFromAxisAngle(axis, (value * Math.PI) / 180));
      }
      node.quaternion.copy(turn);
    }
    this.model.updateMatrixWorld(true);
    for (const { object, first, second, share } of this.helpers) {
      const [a, b] = [this.nodes.get(first), this.nodes.get(second)];
      if (!a || !b) continue;
      // The second node's place as either node carries it.
      const place = b.parent === a ? b.userData.place.clone() : a.worldToLocal(b.getWorldPosition(new THREE.Vector3()));
      const [at, end] = [a.localToWorld(place), b.getWorldPosition(new THREE.Vector3())];
      object.position.copy(object.parent.worldToLocal(at.lerp(end, share)));
      const whole = object.parent.getWorldQuaternion(new THREE.Quaternion()).invert();
      object.quaternion.copy(whole.multiply(a.getWorldQuaternion(turn).slerp(b.getWorldQuaternion(TURN), share)));
    }
  }

  // Lets the creature move again.
  release() {
    if (!this.action) return;
    // The mixer writes only what has changed since it wrote last.
    this.action.stop();
    this.action.play();
    this.seek(this.time);
  }

  // The link at a place of the canvas, without its performer.
  partAt(event) {
    const hit = this.hitAt(event);
    if (!hit) return null;
    let { object } = hit;
    if (object.isSkinnedMesh) {
      const { skinIndex, skinWeight } = object.geometry.attributes;
      const slot = skinWeight.getY(hit.face.a) > skinWeight.getX(hit.face.a) ? 1 : 0;
      object = object.skeleton.bones[skinIndex.getComponent(hit.face.a, slot)];
    }
    for (; object; object = object.parent) {
      const [first, second, share] = (object.userData.name ?? "").split("~");
      const name = share >= 0.5 ? second : first;
      const node = this.nodes.get(name);
      if (node && !object.userData.part) return name.slice(node.userData.performer.length + 1);
    }
    return null;
  }

  onScreen(place) {
    const box = this.canvas.getBoundingClientRect();
    const { x, y } = place.clone().project(this.camera);
    return [box.left + ((x + 1) / 2) * box.width, box.top + ((1 - y) / 2) * box.height];
  }

  // From the film's camera: origin, target and vertical field of view of a frame.
  lookAs(pose) {
    if (!pose) return;
    const [x, y, z, tx, ty, tz, fov] = pose;
    this.camera.position.set(x, y, z);
    this.camera.fov = fov;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(tx, ty, tz);
    this.controls.target.set(tx, ty, tz);
  }

  // From above: x to the right, z down, `half` metres up and down from the middle; null ends it.
  seeFromAbove(view, isMoving = false) {
    this.above = null;
    if (view) {
      const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
      const wide = (view.half * width) / height;
      this.above = new THREE.OrthographicCamera(-wide, wide, view.half, -view.half, 0.1, 4000);
      this.above.up.set(0, 0, -1);
      this.above.position.set(view.x, 2000, view.z);
      this.above.lookAt(view.x, 0, view.z);
    }
    this.draw(isMoving);
  }

  #casterAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * 2 - 1;
    const y = 1 - ((event.clientY - box.top) / box.height) * 2;
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return caster;
  }

  rayAt(event) {
    return this.#casterAt(event).ray;
  }

  // The first hit of a performer at a place of the canvas.
  hitAt(event) {
    if (!this.model) return null;
    this.model.traverse((object) => {
      // Their spheres are those of the moment at which they were asked for.
      if (object.isSkinnedMesh) object.boundingSphere = object.boundingBox = null;
    });
    return this.#casterAt(event).intersectObject(this.model, true).find(({ object }) => performerOf(object)) ?? null;
  }

  performerAt(event) {
    const hit = this.hitAt(event);
    return hit && performerOf(hit.object);
  }

  get triangles() {
    return this.renderer.info.render.triangles;
  }

  // With fewer triangles while it moves, and in full soon after.
  draw(isMoving = false) {
    clearTimeout(this.resting);
    if (isMoving) this.resting = setTimeout(() => this.draw(), REST);
    // Edges are smoothed by more pixels where the context cannot, as soon as there is time.
    const ratio = isMoving ? 1 : 2;
    if (this.pace.isLight && this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    this.detail?.choose(this.above ?? this.camera, isMoving);
    this.renderer.render(this.scene, this.above ?? this.camera);
  }

  // Takes in how long a frame of a motion took [ms].
  tookFrame(duration) {
    const wasLight = this.pace.isLight;
    if (!this.model || !this.pace.took(duration, this.triangles)) return;
    this.detail.budget = this.pace.budget;
    if (this.pace.isLight && !wasLight) this.#lighten();
  }
}
